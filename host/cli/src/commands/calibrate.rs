//! `armbridge calibrate`: zero and sign of each joint, by hand.

use std::process::ExitCode;

use armbridge::board_tasks::calibrate::{Calibrate, CalibrationOptions};
use armbridge::config::Config;
use armbridge_client::stdio;
use armbridge_control::actuator::Joint;
use armbridge_log::text_table;
use armbridge_servo::{ControlMode, JOINTS};
use armbridge_sim::link::Pace;
use clap::Args;
use serde_json::json;

use super::terminal_guide::Terminal;
use super::{Outcome, task};
use crate::args::TaskArgs;

pub(crate) const EXAMPLES: &str = "\
Examples:
  armbridge calibrate --link serial:                both joints
  armbridge calibrate --link usb: --joint 2
  armbridge calibrate --link serial: --check-motor  each motor pushes once
  armbridge calibrate --link usb: --mode current    X servos driven by current
  printf '\\n\\n\\n\\ny\\n' | armbridge calibrate --link tcp://127.0.0.1:7001

The motors are off while the arm is moved by hand. Nothing is changed before you
confirm; then zero and direction of each joint are set and saved on the board,
and all its other settings stay. A board whose calibration is of other servos
asks for the model of these. In a script, each line of the input is one answer.
To practise, calibrate the simulated arm of armbridge serve board, and
turn it by armbridge hand.";

/// Note on turning a simulated arm.
const PRACTICE: &str = "\
note: this simulated arm cannot be turned by hand from here. To practise, use terminals:
  1  armbridge serve board --listen tcp://127.0.0.1:7001
  2  armbridge calibrate --link tcp://127.0.0.1:7001
  3  armbridge hand 0,0 --link tcp://127.0.0.1:7001       as the second one asks";

/// Find zero and sign of each joint.
#[derive(Args, Debug)]
pub(crate) struct CalibrateArgs {
    #[command(flatten)]
    pub(crate) task: TaskArgs,
    /// Calibrate only this joint.
    #[arg(long, value_name = "1|2", value_parser = clap::value_parser!(u8).range(1..=2))]
    joint: Option<u8>,
    /// Control mode of X servos: PWM, or current of those that measure it. Another one
    /// than the board's begins with the nominal torque of a model.
    #[arg(long, value_name = "pwm|current", value_parser = mode)]
    mode: Option<ControlMode>,
    /// Let each motor push once, gently, to check that it turns the way its encoder
    /// counts. Asks before each push.
    #[arg(long)]
    pub(crate) check_motor: bool,
    /// Save without asking. Each motor's push is still asked for.
    #[arg(long)]
    pub(crate) yes: bool,
}

impl CalibrateArgs {
    /// Which joints, counting from 0.
    pub(crate) fn joints(&self) -> [bool; 2] {
        [1, 2].map(|joint| self.joint.is_none_or(|only| only == joint))
    }
}

/// The control mode of this name.
fn mode(name: &str) -> Result<ControlMode, &'static str> {
    match name {
        "pwm" => Ok(ControlMode::Pwm),
        "current" => Ok(ControlMode::Current),
        _ => Err("expected pwm or current"),
    }
}

pub(crate) fn run(args: &CalibrateArgs) -> Outcome {
    if Config::discover()?
        .link(args.task.link.link.as_ref())?
        .is_simulated()
    {
        stdio::note(PRACTICE);
    }
    let options = CalibrationOptions {
        joints: args.joints(),
        mode: args.mode,
        checks_motors: args.check_motor,
        is_sure: args.yes,
    };
    let job = Calibrate::new(Terminal::new(), options);
    let (uri, host) = task::go(&args.task, "calibrate", Pace::WallClock, job)?;
    let [before, after] = host
        .task
        .result()
        .ok_or("the calibration was not completed")?;
    if args.task.json {
        let report = json!({
            "link": uri.to_string(),
            "before": before.map(as_json),
            "after": after.map(as_json),
        });
        stdio::print_line(report)?;
    } else {
        // With a question, the change was shown above it.
        if args.yes {
            stdio::print(as_text(&before, &after))?;
        }
        stdio::print_line("Saved on the board.")?;
    }
    Ok(ExitCode::SUCCESS)
}

fn as_json(joint: Joint<f32>) -> serde_json::Value {
    json!({
        "zero_count": joint.zero_count,
        "direction": format!("{:?}", joint.direction).to_lowercase(),
    })
}

fn as_text(before: &[Joint<f32>; JOINTS], after: &[Joint<f32>; JOINTS]) -> String {
    let heads = [
        "joint",
        "zero before",
        "zero",
        "direction before",
        "direction",
    ];
    let mut rows = vec![heads.map(str::to_owned).to_vec()];
    for (number, (before, after)) in before.iter().zip(after).enumerate() {
        rows.push(vec![
            (number + 1).to_string(),
            format!("{:.1}", before.zero_count),
            format!("{:.1}", after.zero_count),
            format!("{:?}", before.direction).to_lowercase(),
            format!("{:?}", after.direction).to_lowercase(),
        ]);
    }
    text_table::columns(&rows)
}
