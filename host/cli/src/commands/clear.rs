//! `armbridge clear`: a latched fault cleared.

use armbridge::board_tasks::motors_off::{Goal, MotorsOff};
use armbridge::config::Config;
use armbridge_sim::link::Pace;

use super::{Outcome, task};
use crate::args::TaskArgs;

pub(crate) const EXAMPLES: &str = "\
Examples:
  armbridge clear --link serial:
  armbridge clear --link tcp://127.0.0.1:7001 --json

Remove the cause first: armbridge status shows it.";

pub(crate) fn run(args: &TaskArgs) -> Outcome {
    let uri = Config::discover()?.link(args.link.link.as_ref())?;
    if uri.is_simulated() {
        return Err(format!(
            "a fault is cleared on a board that is running, and {uri} would be a new one: give \
             its --link, for example serial: or that of `armbridge serve board`"
        )
        .into());
    }
    let (uri, host) = task::go(args, "clear", Pace::Free, MotorsOff::new(Goal::Clear))?;
    let message = host.task.cleared().map_or_else(
        || "no fault was latched; motors are off".to_owned(),
        |fault| {
            let fault = fault.name();
            format!("the fault {fault} is cleared; motors are off")
        },
    );
    task::print(args, &uri, &host, &message)
}
