//! Commands of the host, validated once into a type that cannot be invalid.
//!
//! [`validate`] checks all that does not depend on the board's state, and does the work
//! that has no place in a tick; the [`supervisor`](crate::supervisor) decides whether a
//! command may be taken now.

use crate::tick::limits::REFERENCE_MAX_RAD;
use crate::tick::{ControlConfig, DriveRequest};
use armbridge_control::trajectory::Quantity;
use armbridge_control::trajectory::stream::Point;
use armbridge_link::limits::hard;
use armbridge_link::message::{Command, Limits, Refusal};
use armbridge_servo::JOINTS;

/// A command whose values are all within their bounds.
#[derive(Clone, Debug)]
pub enum ValidatedCommand {
    /// Torque off.
    Idle,
    /// Park the arm.
    Park,
    /// Arm; the session has been checked.
    Arm,
    /// Report the start point of a motion.
    StartPoint,
    /// Drive the arm; the shape of an experiment has been checked.
    Drive(DriveRequest),
    /// Make stock servos ready for torque.
    Prepare,
    /// Leave the bus to the transparent port.
    Release,
    /// Clear a fault.
    ClearFault,
    /// Another set-up; its gains have been designed.
    Install(ControlConfig),
    /// Other limits, within their hard bounds.
    Limit(Limits),
    /// Permit the settings to be written now.
    Save,
}

/// Validates a command for this session of the board and an arm with this number of joints, and
/// does the work that has no place in the tick. `arm_refusal` is the reason for which the link's
/// side does not arm now.
///
/// # Errors
/// The reason for the refusal.
pub fn validate(
    command: Command,
    session: u32,
    joints: usize,
    arm_refusal: Option<Refusal>,
) -> Result<ValidatedCommand, Refusal> {
    let within = |values: [f32; JOINTS], limit: f32| {
        // NaN is out of every range.
        values
            .iter()
            .all(|value| value.abs() <= limit)
            .then_some(values)
    };
    if let Some((joint, value)) = beyond(&command, joints) {
        return Err(Refusal::Beyond {
            joint: joint as u8,
            quantity: Quantity::Angle,
            value,
            limit: 0.0,
        });
    }
    match command {
        Command::Idle => Ok(ValidatedCommand::Idle),
        Command::Park => Ok(ValidatedCommand::Park),
        Command::Arm { session: stated } if stated != session => Err(Refusal::OtherSession),
        Command::Arm { .. } => arm_refusal.map_or(Ok(ValidatedCommand::Arm), Err),
        Command::Torque(torque) => within(torque, hard::TORQUE_NM)
            .map(|torque| ValidatedCommand::Drive(DriveRequest::Torque(torque)))
            .ok_or(Refusal::OutOfRange),
        Command::Regulate(reference) => within(reference, REFERENCE_MAX_RAD)
            .map(|angles| ValidatedCommand::Drive(DriveRequest::Regulate(angles)))
            .ok_or(Refusal::OutOfRange),
        Command::Follow(_) => Ok(ValidatedCommand::StartPoint),
        Command::Stream {
            at_us,
            angle_rad,
            speed_rad_s,
        } => Ok(ValidatedCommand::Drive(DriveRequest::Stream(Point {
            at_us,
            q: angle_rad.into(),
            dq: speed_rad_s.map(Into::into),
        }))),
        Command::Experiment(plan) => match plan.check() {
            Ok(()) => Ok(ValidatedCommand::Drive(DriveRequest::Experiment(plan))),
            Err(objection) => Err(Refusal::Experiment(objection)),
        },
        Command::Float => Ok(ValidatedCommand::Drive(DriveRequest::Float)),
        Command::Prepare => Ok(ValidatedCommand::Prepare),
        Command::Release => Ok(ValidatedCommand::Release),
        Command::ClearFault => Ok(ValidatedCommand::ClearFault),
        Command::Configure(setup) => ControlConfig::build(&setup).map(ValidatedCommand::Install),
        Command::Limit(limits) if limits.is_valid() => Ok(ValidatedCommand::Limit(limits)),
        Command::Limit(_) => Err(Refusal::OutOfRange),
        Command::Save => Ok(ValidatedCommand::Save),
    }
}

/// What a command asks of a joint that an arm with this number of joints does not have.
fn beyond(command: &Command, joints: usize) -> Option<(usize, f32)> {
    (joints..JOINTS).find_map(|joint| Some((joint, command.demand_of(joint)?)))
}
