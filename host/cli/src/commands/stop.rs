//! `armbridge stop`: the emergency stop.

use armbridge::board_tasks::motors_off::{Goal, MotorsOff};
use armbridge_client::fault_text;
use armbridge_sim::link::Pace;

use super::{Outcome, task};
use crate::args::TaskArgs;

pub(crate) const EXAMPLES: &str = "\
Examples:
  armbridge stop --link serial:
  armbridge stop --link tcp://127.0.0.1:7001

The stop is sent at once, without waiting for the board's hello, and repeated until the
board reports it. The fault stays latched: `armbridge clear` clears it. While another
program has the link, stop there, or with the board's switch.";

pub(crate) fn run(args: &TaskArgs) -> Outcome {
    let (uri, host) = task::go(args, "stop", Pace::Free, MotorsOff::new(Goal::Stop))?;
    let cause = host
        .session
        .status()
        .trip
        .map(|trip| fault_text::in_words(&trip).cause);
    let message = format!(
        "stopped: {}; `armbridge clear` clears it when the arm is free to move",
        cause.unwrap_or_default()
    );
    task::print(args, &uri, &host, &message)
}
