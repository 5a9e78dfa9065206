//! The numbers by which the bridge judges what is safe.

use crate::control::Bounds;

/// Longest silence of the host while torque is on. The host sends a heartbeat
/// every 50 ms, so five in a row must be lost. 250 ms is what an arm with
/// motors off takes to fall by a few degrees from upright.
pub const HOST_SILENCE_US: u64 = 250_000;

/// How long the bus stays with the host after an order of its, whatever a client
/// of the transparent port says: time to arm.
pub const CLAIM_US: u64 = 2_000_000;

/// Samples of one joint missing in a row before torque goes off, if they have
/// been for [`LOST_US`] too. The estimator predicts through the ones before.
pub const LOST_SAMPLES: u8 = 5;

/// How long they must have been missing, in µs. In 20 ms full torque, all of it
/// misjudged, turns a joint by 8 mrad, which is less than two encoder counts, so
/// the arm goes on at 1 kHz as it would at 50 Hz. On a line that damages one
/// reply in five, five in a row happen every few seconds, and 20 never.
pub const LOST_US: u32 = 20_000;

/// Samples of one joint in a row before torque goes off at a period in µs.
pub const fn lost_samples(period_us: u32) -> u32 {
    let for_long = LOST_US.div_ceil(period_us);
    if for_long > LOST_SAMPLES as u32 {
        for_long
    } else {
        LOST_SAMPLES as u32
    }
}

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

/// Shortest tick that any bus allows: Morpheus servos at 1 Mbaud. What the bus
/// at hand allows is [`tick_us`](crate::servo::master::timing::tick_us).
pub const PERIOD_MIN_US: u32 = 600;

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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn samples_are_lost_after_20_ms_and_five_of_them() {
        let counts = [1_000, 1_500, 4_000, 5_000, 100_000].map(lost_samples);
        assert_eq!(counts, [20, 14, 5, 5, 5]);
    }
}
