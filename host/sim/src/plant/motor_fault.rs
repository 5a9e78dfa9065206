//! Faults of the virtual arm's motors.

/// Fault of a motor: its torque is another function of its PWM.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MotorFault {
    /// Factor on the torque; negative where the motor turns the other way.
    pub gain: f64,
    /// PWM counts that are added to all but off.
    pub offset_counts: f64,
}

impl MotorFault {
    /// A sound motor.
    pub const NONE: Self = Self {
        gain: 1.0,
        offset_counts: 0.0,
    };
}
