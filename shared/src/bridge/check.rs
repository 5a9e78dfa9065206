//! Which commands may be, as far as can be told without knowing what the board is
//! doing: that is the [`supervisor`](super::supervisor)'s to say.

use super::law::Law;
use super::limits::REFERENCE_MAX_RAD;
use super::mailbox::Task;
use crate::JOINTS;
use crate::control::trajectory::stream::Point;
use crate::link::limits::hard;
use crate::link::message::{Command, Refusal};

/// Checks a command and does the work that has no place in the tick. The board's
/// session is this one, and settings are being saved or not.
///
/// # Errors
/// Why it cannot be.
pub(super) fn task(command: Command, session: u32, is_saving: bool) -> Result<Task, Refusal> {
    let within = |values: [f32; JOINTS], limit: f32| {
        // A NaN is within nothing.
        values
            .iter()
            .all(|value| value.abs() <= limit)
            .then_some(values)
    };
    match command {
        Command::Idle => Ok(Task::Idle),
        Command::Arm { session: told } if told != session => Err(Refusal::OtherSession),
        // Settings are being written, which may hold up the program.
        Command::Arm { .. } if is_saving => Err(Refusal::Busy),
        Command::Arm { .. } => Ok(Task::Arm),
        Command::Torque(torque) => within(torque, hard::TORQUE_NM)
            .map(Task::Torque)
            .ok_or(Refusal::OutOfRange),
        Command::Regulate(reference) => within(reference, REFERENCE_MAX_RAD)
            .map(Task::Regulate)
            .ok_or(Refusal::OutOfRange),
        Command::Follow(_) => Ok(Task::Depart),
        Command::Stream {
            at_us,
            angle_rad,
            speed_rad_s,
        } => Ok(Task::Stream(Point {
            at_us,
            q: angle_rad.into(),
            dq: speed_rad_s.map(Into::into),
        })),
        Command::Experiment(plan) => match plan.check() {
            Ok(()) => Ok(Task::Experiment(plan)),
            Err(objection) => Err(Refusal::Experiment(objection)),
        },
        Command::Prepare => Ok(Task::Prepare),
        Command::Release => Ok(Task::Release),
        Command::ClearFault => Ok(Task::ClearFault),
        Command::Configure(setup) => Law::build(&setup).map(Task::Install),
        Command::Limit(limits) if limits.is_valid() => Ok(Task::Limit(limits)),
        Command::Limit(_) => Err(Refusal::OutOfRange),
        Command::Save => Ok(Task::Save),
    }
}
