//! The numbers by which the bridge judges what is safe.

use crate::control::Bounds;

/// Longest silence of the host while torque is on. The host sends a heartbeat
/// every 50 ms, so five in a row must be lost. 250 ms is what an arm with
/// motors off takes to fall by a few degrees from upright.
pub const HOST_SILENCE_US: u64 = 250_000;

/// Samples of one joint missing in a row before torque goes off. The observer
/// predicts through the ones before.
pub const LOST_SAMPLES: u8 = 5;

/// Ticks in a row that began a whole period late before torque goes off.
pub const OVERRUNS: u8 = 3;

/// Joint angle beyond which torque goes off: short of ±π/2, where the table
/// stops the first joint, so that no motor is left pushing against it.
pub const ANGLE_MAX_RAD: f32 = 1.5;

/// Largest reference angle: well inside the stops, so that an overshoot is too.
pub const REFERENCE_MAX_RAD: f32 = 1.2;

/// Largest constant torque, what a servo gives at full PWM by equation (5),
/// rounded up.
pub const TORQUE_MAX_NM: f32 = 1.25;

/// Shortest tick: two packets and two replies take 0.6 ms on the wire.
pub const PERIOD_MIN_US: u32 = 1_000;

/// Longest tick. The upright arm doubles its angle in 360 ms.
pub const PERIOD_MAX_US: u32 = 100_000;

/// What a motion may ask. Speed: two thirds of an AX-12A's 59 rpm without load.
/// Acceleration: what 1.18 N m, the least that equation (5) gives at full PWM,
/// leaves of 0.0307 kg m^2 when 0.57 N m hold the arm level.
pub const MOTION: Bounds<f32> = Bounds {
    angle_rad: REFERENCE_MAX_RAD,
    speed_rad_s: 4.0,
    acceleration_rad_s2: 20.0,
};
