//! Reports of the board on torque and faults: the only place that knows which
//! messages carry them.

use armbridge_link::message::{Fault, OffState, ToHost};
use armbridge_servo::JOINTS;

/// The joints whose motors this message reports as off; `None` if it is no report
/// on that.
pub fn off(message: &ToHost) -> Option<[bool; JOINTS]> {
    match message {
        ToHost::Off(report) => Some(report.joints.map(|joint| joint == OffState::Off)),
        _ => None,
    }
}

/// The fault that this message reports.
pub fn fault(message: &ToHost) -> Option<Fault> {
    match message {
        ToHost::Tripped(trip) => Some(trip.fault),
        _ => None,
    }
}
