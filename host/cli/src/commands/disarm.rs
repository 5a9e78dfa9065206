//! `armbridge disarm`: motors off, without a fault.

use armbridge_client::transport::stop_socket::Order;

use super::{Outcome, motors_off};
use crate::args::TaskArgs;

pub(crate) const EXAMPLES: &str = "\
Examples:
  armbridge disarm
  armbridge disarm --link serial:
  armbridge disarm --link tcp://127.0.0.1:7001 --json

Without --link every board is disarmed that a program of yours has, simulated
ones too, that is plugged in, or that the configuration names; each is listed. A
program that has the board does it for this one.";

pub(crate) fn run(args: &TaskArgs) -> Outcome {
    motors_off::run(args, Order::Disarm)
}
