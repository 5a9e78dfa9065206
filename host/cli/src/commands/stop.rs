//! `armbridge stop`: the emergency stop.

use armbridge_client::transport::stop_socket::Order;

use super::{Outcome, motors_off};
use crate::args::TaskArgs;

pub(crate) const EXAMPLES: &str = "\
Examples:
  armbridge stop
  armbridge stop --link serial:
  armbridge stop --link tcp://127.0.0.1:7001

Without --link every board is stopped that a program of yours has, simulated
ones too, that is plugged in, or that the configuration names; each is listed.
The stop waits for no hello, and is repeated until the board reports it. The
fault stays latched until armbridge clear. A program that has the board sends
the stop for this one. Where that fails the exit code is 2: use the switch at
the board, or the one in the servos' supply.";

pub(crate) fn run(args: &TaskArgs) -> Outcome {
    motors_off::run(args, Order::Stop)
}
