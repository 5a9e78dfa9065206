//! Safety limits that no host can set; those that a host can set are
//! [`Limits`](armbridge_link::limits::Limits).

use armbridge_control::trajectory::Bounds;

/// Time for which the bus stays with the host after one of its commands, even with a client
/// on the transparent port: time to arm.
pub const CLAIM_US: u64 = 2_000_000;

/// Lateness in µs at which a single tick is a fault: no period is longer,
/// and in 20 ms full torque, all of it misjudged, turns a joint by 8 mrad.
pub const LATE_MAX_US: u64 = 20_000;

/// Largest reference angle: well inside the stops, so that an overshoot is too.
pub const REFERENCE_MAX_RAD: f32 = 1.2;

/// Shortest tick that any bus allows: X servos at 4 Mbaud. The limit of the
/// present bus is [`tick_us`](armbridge_servo::master::timing::tick_us).
pub const PERIOD_MIN_US: u32 = 450;

/// Shortest tick at which AX-12A servos are driven: at 1 Mbaud, where the motor check and the
/// monitors have been tried with them.
pub const PERIOD_MIN_AX12A_US: u32 = 600;

/// Longest tick. The upright arm doubles its angle in 360 ms.
pub const PERIOD_MAX_US: u32 = 100_000;

/// Longest tick at which the motors are checked: the arm falls by 0.06 rad in the three quarters
/// of a second that this takes at longer ones.
pub const CHECK_PERIOD_MAX_US: u32 = 10_000;

/// Least number of consecutive ticks without a sample after which torque goes off, at any period: on
/// a line that damages one reply in five, five in a row are one in 3000.
pub const ROW_TICKS: u32 = 5;

/// Longest duration of a park in µs: 7 s for the longest motion, 10 s for each joint from upright.
pub const PARK_US: u64 = 28_000_000;

/// Bounds of a motion. Speed: two thirds of an AX-12A's 59 rpm without load.
/// Acceleration: that of 0.0307 kg m^2 under 1.18 N m, the least that equation (5) gives
/// at full PWM, when 0.57 N m hold the arm level. Jerk: acceleration builds up in 5 ms and
/// turns over in 10, so that a torque does not jump from one tick to the next.
pub const MOTION: Bounds<f32> = Bounds {
    angle_rad: REFERENCE_MAX_RAD,
    speed_rad_s: 4.0,
    acceleration_rad_s2: 20.0,
    jerk_rad_s3: 4_000.0,
};
