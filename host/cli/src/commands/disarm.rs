//! `armbridge disarm`: motors off.

use armbridge::board_tasks::motors_off::{Goal, MotorsOff};
use armbridge_client::fault_text;
use armbridge_shared::link::message::Mode;
use armbridge_sim::link::Pace;

use super::{Outcome, task};
use crate::args::TaskArgs;

pub(crate) const EXAMPLES: &str = "\
Examples:
  armbridge disarm --link serial:
  armbridge disarm --link tcp://127.0.0.1:7001 --json";

pub(crate) fn run(args: &TaskArgs) -> Outcome {
    let (uri, host) = task::go(args, "disarm", Pace::Free, MotorsOff::new(Goal::Disarm))?;
    let is_fault = matches!(host.session.status().mode(), Some(Mode::Fault(_)));
    let message = host.session.status().trip.filter(|_| is_fault).map_or_else(
        || "disarmed: motors are off".to_owned(),
        |tripped| {
            let account = fault_text::in_words(&tripped);
            format!(
                "motors are off; a fault is latched: {}; {}",
                account.cause, account.remedy
            )
        },
    );
    task::print(args, &uri, &host, &message)
}
