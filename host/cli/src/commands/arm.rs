//! `armbridge arm`: armed with zero torque, until ctrl-c.

use std::process::ExitCode;
use std::time::Duration;

use armbridge::board_tasks::arm::{Arm, Outcome as Ending};
use armbridge_client::{ctrl_c, stdio};
use armbridge_sim::link::Pace;
use clap::Args;
use serde_json::json;

use super::{Outcome, task};
use crate::args::TaskArgs;
use crate::args::values::duration;

pub(crate) const EXAMPLES: &str = "\
Examples:
  armbridge arm --link serial:            until ctrl-c
  armbridge arm --for 5                   the simulated board, for 5 s
  armbridge arm --link usb: --record run.mcap

Armed means ready to move, with zero torque. The program keeps running: a board
whose host falls silent switches the motors off. Ctrl-C disarms, then ends. Exit
code 1: the board switched torque off, was reset or disarmed, reports nothing, or
the link broke; 143: a request to terminate.";

/// Arm and stay.
#[derive(Args, Debug)]
pub(crate) struct ArmedArgs {
    #[command(flatten)]
    pub(crate) task: TaskArgs,
    /// Disarm and end after this many seconds instead of on ctrl-c.
    #[arg(long = "for", value_name = "S", value_parser = seconds)]
    pub(crate) lasts: Option<Duration>,
    /// Set stock servos to wheel mode, X servos to PWM control mode, and both to a short
    /// return delay if necessary; they keep it in their EEPROM.
    #[arg(long)]
    pub(crate) prepare: bool,
    /// No status line.
    #[arg(long)]
    pub(crate) quiet: bool,
}

fn seconds(text: &str) -> Result<Duration, String> {
    duration(text).map(Duration::from_secs_f64)
}

pub(crate) fn run(args: &ArmedArgs) -> Outcome {
    let mut job = Arm::new(args.lasts, args.prepare);
    if !args.quiet && !args.task.json {
        job = job.reporting(|line| stdio::note(line));
    }
    let (uri, host) = task::go(&args.task, "arm", Pace::WallClock, job)?;
    let ending = host.task.outcome().unwrap_or(&Ending::Disarmed);
    if args.task.json {
        let report = json!({
            "link": uri.to_string(),
            "ended_by": ending.name(),
            "held_s": host.task.held().as_secs_f64(),
            "in_words": ending.in_words(),
        });
        stdio::print_line(report)?;
    } else {
        let held_s = host.task.held().as_secs_f64();
        let in_words = ending.in_words();
        stdio::print_line(format_args!("armed for {held_s:.1} s; {in_words}"))?;
    }
    Ok(ExitCode::from(match ending {
        Ending::Disarmed => ctrl_c::awaited_exit_code(),
        Ending::Tripped(_)
        | Ending::Fault(_)
        | Ending::Released
        | Ending::Silent
        | Ending::Reset(_)
        | Ending::Parted
        | Ending::Strayed(_) => 1,
    }))
}
