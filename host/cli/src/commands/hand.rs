//! `armbridge hand`: moves the simulated arm of `serve board` by hand.

use std::process::ExitCode;

use armbridge_link::server::Touch;
use clap::Args;

use super::Outcome;
use super::touch::touch;
use crate::args::LinkArgs;
use crate::args::values::angles;
use armbridge_client::stdio;

pub(crate) const EXAMPLES: &str = "\
Examples:
  armbridge serve board --listen tcp://127.0.0.1:7001   in another terminal
  armbridge hand 0.3,-0.2 --link tcp://127.0.0.1:7001   lift and hold it
  armbridge hand 0,0 --duration 3 --link tcp://127.0.0.1:7001
  armbridge hand --release --link tcp://127.0.0.1:7001      let go of it

The hand moves both joints to these true angles, smoothly, and holds the arm
until a motor drives it or it is released. It is an event of the simulation and
no command: so a calibration can be practised, with armbridge calibrate in a
second terminal. While the board is armed, the motors have the arm. Only a
simulated arm can be moved so.";

/// A hand on the simulated arm.
#[derive(Args, Debug)]
pub(crate) struct HandArgs {
    /// Angles of both joints in rad, 0,0 upright.
    #[arg(value_name = "RAD,RAD", value_parser = angles, allow_hyphen_values = true,
          required_unless_present = "release")]
    angles: Option<[f64; 2]>,
    /// A second angle as a word of its own: takes a minus for no option, so that the first
    /// word is refused, with how to write both.
    #[arg(hide = true, allow_hyphen_values = true)]
    second: Option<String>,
    /// Let go of the arm.
    #[arg(long, conflicts_with = "angles")]
    release: bool,
    /// Duration of the motion in s, at least 1.
    #[arg(long, value_name = "S", default_value = "1.5", value_parser = seconds)]
    duration: f32,
    #[command(flatten)]
    link: LinkArgs,
}

fn seconds(text: &str) -> Result<f32, String> {
    let [least, most] = [Touch::MOVE_MIN_US, Touch::DURATION_MAX_US].map(|us| us / 1_000_000);
    match text.parse() {
        Ok(seconds) if (least as f32..=most as f32).contains(&seconds) => Ok(seconds),
        _ => Err(format!("expected seconds from {least} to {most}")),
    }
}

pub(crate) fn run(args: &HandArgs) -> Outcome {
    if let Some(second) = &args.second {
        return Err(format!("{second}: both angles are one word, as 0.3,-0.2").into());
    }
    let Some(to_rad) = args.angles else {
        touch(&args.link, Touch::Release)?;
        stdio::print_line("the hand lets go of the simulated arm")?;
        return Ok(ExitCode::SUCCESS);
    };
    let motion = Touch::Move {
        angle_rad: to_rad.map(|rad| rad as f32),
        duration_us: (args.duration * 1e6).round() as u32,
    };
    touch(&args.link, motion)?;
    let [first, second] = to_rad;
    stdio::print_line(format_args!(
        "the simulated arm is held at {first:+.3} and {second:+.3} rad, until a motor drives it or\n\
         `armbridge hand --release`"
    ))?;
    Ok(ExitCode::SUCCESS)
}
