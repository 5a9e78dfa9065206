//! `armbridge push`: a push on the simulated arm of `serve board`.

use std::process::ExitCode;

use armbridge_link::server::Touch;
use clap::Args;

use super::Outcome;
use super::touch::touch;
use crate::args::LinkArgs;
use armbridge_client::stdio;

pub(crate) const EXAMPLES: &str = "\
Examples:
  armbridge serve board --listen tcp://127.0.0.1:7001   in another terminal
  armbridge push --link tcp://127.0.0.1:7001
  armbridge push --joint 2 --torque -0.3 --link tcp://127.0.0.1:7001

A push is an event of the simulation and no command: it acts also while another
program commands the board. Only a simulated arm can be pushed.";

/// A push on the simulated arm.
#[derive(Args, Debug)]
pub(crate) struct PushArgs {
    /// Joint to push.
    #[arg(long, value_name = "1|2", default_value_t = 1,
          value_parser = clap::value_parser!(u8).range(1..=2))]
    joint: u8,
    /// Torque in N m, at most 6; negative towards negative angles.
    #[arg(long, value_name = "NM", default_value = "0.5", value_parser = torque,
          allow_hyphen_values = true)]
    torque: f32,
    /// Duration in s.
    #[arg(long, value_name = "S", default_value = "0.1", value_parser = seconds)]
    duration: f32,
    #[command(flatten)]
    link: LinkArgs,
}

fn torque(text: &str) -> Result<f32, String> {
    let most = Touch::TORQUE_MAX_NM;
    match text.parse() {
        Ok(nm) if f32::abs(nm) <= most => Ok(nm),
        _ => Err(format!("expected a torque from -{most} to {most} N m")),
    }
}

fn seconds(text: &str) -> Result<f32, String> {
    let most = Touch::DURATION_MAX_US / 1_000_000;
    match text.parse() {
        Ok(seconds) if (0.001..=most as f32).contains(&seconds) => Ok(seconds),
        _ => Err(format!("expected seconds from 0.001 to {most}")),
    }
}

pub(crate) fn run(args: &PushArgs) -> Outcome {
    let push = Touch::Push {
        joint: args.joint - 1,
        torque_nm: args.torque,
        duration_us: (args.duration * 1e6).round() as u32,
    };
    touch(&args.link, push)?;
    stdio::print_line(format_args!(
        "the simulated arm is pushed: joint {}, {} N m for {} s",
        args.joint, args.torque, args.duration
    ))?;
    Ok(ExitCode::SUCCESS)
}
