//! The command lines of what does one thing on a link: `status`, `arm`, `disarm`,
//! `stop`, `clear`.

use std::path::PathBuf;
use std::time::Duration;

use clap::Args;

use super::LinkArgs;

pub(crate) const STATUS_EXAMPLES: &str = "\
Examples:
  armbridge status                        of the simulated board
  armbridge status --link serial:         of the board that is plugged in
  armbridge status --link tcp://127.0.0.1:7001 --json

Saying hello disarms a board: a link has one host. Where another program has the
link, that is said and nothing is done.";

pub(crate) const ARM_EXAMPLES: &str = "\
Examples:
  armbridge arm --link serial:            until ctrl-c
  armbridge arm --for 5                   the simulated board, for 5 s
  armbridge arm --link usb: --record run.mcap

Armed means ready to move, with zero torque. The program stays: a board whose host
falls silent switches off by itself. Ctrl-C disarms first, then ends. Exit code 1:
the board switched torque off, was reset, or the link broke meanwhile.";

pub(crate) const DISARM_EXAMPLES: &str = "\
Examples:
  armbridge disarm --link serial:
  armbridge disarm --link tcp://127.0.0.1:7001 --json";

pub(crate) const STOP_EXAMPLES: &str = "\
Examples:
  armbridge stop --link serial:
  armbridge stop --link tcp://127.0.0.1:7001

Said at once, without waiting for the board's hello, and until the board says that
it has stopped. The fault stays latched: `armbridge clear` clears it. While another
program has the link, stop there, or at the board's switch.";

pub(crate) const CLEAR_EXAMPLES: &str = "\
Examples:
  armbridge clear --link serial:
  armbridge clear --link tcp://127.0.0.1:7001 --json

Look after the cause first: `armbridge status` tells what it was.";

/// What does one thing on a link.
#[derive(Args, Clone, Debug)]
pub(crate) struct ErrandArgs {
    #[command(flatten)]
    pub(crate) link: LinkArgs,
    /// Write everything that is said on the link as MCAP: to this file if its name
    /// ends in .mcap, otherwise to a folder of its own in this folder.
    #[arg(long, value_name = "FILE|DIR")]
    pub(crate) record: Option<PathBuf>,
    /// Print one JSON object instead of words.
    #[arg(long)]
    pub(crate) json: bool,
}

/// Arm and stay.
#[derive(Args, Debug)]
pub(crate) struct ArmedArgs {
    #[command(flatten)]
    pub(crate) errand: ErrandArgs,
    /// Disarm and end after so many s, instead of on ctrl-c.
    #[arg(long = "for", value_name = "S", value_parser = seconds)]
    pub(crate) lasts: Option<Duration>,
    /// Set stock servos to wheel mode and a short return delay, where they are not;
    /// both are kept in their EEPROM.
    #[arg(long)]
    pub(crate) prepare: bool,
    /// No status line.
    #[arg(long)]
    pub(crate) quiet: bool,
}

fn seconds(text: &str) -> Result<Duration, String> {
    match text.parse() {
        Ok(seconds) if (0.1..=86_400.0).contains(&seconds) => Ok(Duration::from_secs_f64(seconds)),
        _ => Err("expected seconds from 0.1 to 86400".into()),
    }
}

pub(crate) const CALIBRATE_EXAMPLES: &str = "\
Examples:
  armbridge calibrate --link serial:                   both joints
  armbridge calibrate --link usb: --joint 2
  armbridge calibrate --link serial: --check-motor     each motor pushes once, when told to
  printf '\\n\\n\\n\\ny\\n' | armbridge calibrate --link tcp://127.0.0.1:7001

The motors are off while the arm is moved by hand. Nothing is changed before you say
yes; then zero and direction of each joint are set and saved on the board, and all
its other settings stay. In a script, each line of the input is one answer.";

/// Find zero and sign of each joint.
#[derive(Args, Debug)]
pub(crate) struct CalibrateArgs {
    #[command(flatten)]
    pub(crate) errand: ErrandArgs,
    /// Only this joint.
    #[arg(long, value_name = "1|2", value_parser = clap::value_parser!(u8).range(1..=2))]
    joint: Option<u8>,
    /// Have each motor push once, gently, to see that it turns the way its encoder
    /// counts. Asks before each.
    #[arg(long)]
    pub(crate) check_motor: bool,
    /// Save without asking. Motors are asked for all the same.
    #[arg(long)]
    pub(crate) yes: bool,
}

impl CalibrateArgs {
    /// Which joints, counting from 0.
    pub(crate) fn joints(&self) -> [bool; 2] {
        [1, 2].map(|joint| self.joint.is_none_or(|only| only == joint))
    }
}
