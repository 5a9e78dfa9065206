//! Inputs of the monitors, from samples and estimate.

use super::config::LoopConfig;
use super::estimation::Estimated;
use super::lowering::Lowered;
use super::monitors::{Hold, JointBalance, MonitorInput};
use super::sense::Sensed;
use armbridge_link::message::Drive;
use armbridge_servo::JOINTS;

/// The inputs of the monitors, with the source that drives the arm, which follows a reference of
/// this speed if a controller does.
#[inline]
pub(super) fn monitor_input<'a>(
    config: &LoopConfig,
    sensed: &Sensed,
    estimated: &'a Estimated,
    is_armed: bool,
    drive: Option<Drive>,
    lowered: Lowered,
    reference_rad_s: [f32; JOINTS],
) -> MonitorInput<'a> {
    let hold = match drive {
        Some(drive) if drive.is_closed_loop() => {
            Hold::Controlled(balance(config, sensed, estimated))
        }
        Some(Drive::Float) => Hold::Floating,
        _ => Hold::None,
    };
    MonitorInput {
        counts: sensed.counts,
        missing: sensed.missing,
        measured_rad: sensed.measured_rad,
        predicted_rad: estimated.predicted_rad,
        is_fresh: estimated.is_fresh,
        state: &estimated.state,
        torque_nm: sensed.torque_nm.into(),
        gravity_nm: estimated.gravity_nm.into(),
        is_alarmed: sensed.is_alarmed,
        hold,
        lowered,
        reference_rad_s,
        is_armed,
    }
}

/// Balance of each joint: the torque that posture and motion take, less that of the motor.
fn balance(config: &LoopConfig, sensed: &Sensed, estimated: &Estimated) -> [JointBalance; JOINTS] {
    let arm = &config.control.arm;
    let inertia = estimated.posture.mass_diagonal(arm);
    let rest_nm = estimated.gravity_nm - sensed.torque_nm;
    let unmet_nm = arm.viscous_torque(estimated.state.dq) + rest_nm;
    core::array::from_fn(|joint| JointBalance {
        inertia: inertia[joint],
        unmet_nm: unmet_nm[joint],
    })
}
