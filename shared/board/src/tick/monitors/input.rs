//! What the monitors see in a tick.

use super::encoder_proof::Held;
use super::external_torque::JointBalance;
use crate::tick::lowering::Lowered;
use armbridge_control::arm::State;
use armbridge_link::limits::Limits;
use armbridge_link::message::Missing;
use armbridge_servo::JOINTS;

/// Inputs of the monitors in one tick.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::tick) struct MonitorInput<'a> {
    /// The samples.
    pub(in crate::tick) counts: [Option<u16>; JOINTS],
    /// Reason for each missing sample; `None` where there is one.
    pub(in crate::tick) missing: [Option<Missing>; JOINTS],
    /// The samples as angles.
    pub(in crate::tick) measured_rad: [Option<f32>; JOINTS],
    /// Predicted angles: the state of the estimator before the samples.
    pub(in crate::tick) predicted_rad: [f32; JOINTS],
    /// Whether the estimator starts with these samples, without a prediction.
    pub(in crate::tick) is_fresh: bool,
    /// State of the estimator after the samples.
    pub(in crate::tick) state: &'a State<f32>,
    /// Torque that acted until these samples, in N m.
    pub(in crate::tick) torque_nm: [f32; JOINTS],
    /// Gravity torque at these angles, in N m.
    pub(in crate::tick) gravity_nm: [f32; JOINTS],
    /// Whether the servo reports an alarm with which it has switched torque off.
    pub(in crate::tick) is_alarmed: [bool; JOINTS],
    /// Hold of the arm.
    pub(in crate::tick) hold: Hold,
    /// Joints that are lowered: nothing but their motors' torque holds them, and that only carries.
    pub(in crate::tick) lowered: Lowered,
    /// Speed of the reference that the controller follows, in rad/s.
    pub(in crate::tick) reference_rad_s: [f32; JOINTS],
    /// Whether the motors may be driven.
    pub(in crate::tick) is_armed: bool,
}

/// What keeps the arm where it is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::tick) enum Hold {
    /// Neither controller nor float.
    None,
    /// It floats: any torque may be a hand's.
    Floating,
    /// A controller: the balance of each joint.
    Controlled([JointBalance; JOINTS]),
}

impl MonitorInput<'_> {
    /// The hold of a joint by controller or float; `None` without one.
    pub(super) fn held(&self, limits: &Limits, joint: usize) -> Option<Held> {
        match &self.hold {
            Hold::None => None,
            Hold::Floating => Some(Held::Floating),
            Hold::Controlled(_) if self.lowered[joint] => None,
            Hold::Controlled(balance) => Some(Held::Controlled {
                push_nm: -balance[joint].unmet_nm,
                reference_rad_s: self.reference_rad_s[joint],
                external_nm: limits.external_nm[joint],
            }),
        }
    }
}
