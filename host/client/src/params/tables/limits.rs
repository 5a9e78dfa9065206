//! Limits of the supervisor, and the pose in which it has the arm parked.

use armbridge_link::limits::{Milliradians, hard};
use armbridge_servo::JOINTS;

use super::{Parameter, Range, access, choice, number, pair};

/// `number one key unit "meaning" range;` or `pair each ...`, the key being the field.
macro_rules! limits {
    ($($new:ident $access:ident $field:ident $unit:literal $about:literal $range:expr;)*) => {
        [$($new(
            concat!("limits.", stringify!($field)),
            $unit,
            $about,
            $range,
            |s| access::$access(&mut s.limits.$field),
        )),*]
    };
}

const COUNTS: u32 = hard::COUNTS as u32;
const SILENCE_MS: u32 = hard::SILENCE_MS as u32;

const PARK_RAD: f64 = hard::PARK_MRAD as f64 / 1_000.0;

/// Above 0, and at most this.
const fn at_most(bound: f32) -> Range {
    Range::above_0_to(bound as f64)
}

pub(super) const LIMITS: [Parameter; 23] = limits! {
    pair each angle_rad "rad"
        "Joint angles beyond which torque goes off. The arm is braked before."
        at_most(hard::ANGLE_RAD);
    pair each speed_rad_s "rad/s"
        "Estimated joint speeds beyond which torque goes off."
        at_most(hard::SPEED_RAD_S);
    pair each torque_nm "N m"
        "Torque that a joint is given at most."
        at_most(hard::TORQUE_NM);
    number one torque_rate_nm_s "N m/s"
        "Change of that torque at most."
        at_most(hard::TORQUE_RATE_NM_S);
    number one pwm_counts "counts"
        "PWM counts from neutral that a servo is given at most."
        Range::whole(1, hard::PWM_COUNTS as u32);
    number one temperature_c "°C"
        "Temperature of a stock servo above which torque goes off."
        Range::whole(0, hard::TEMPERATURE_C as u32);
    pair each temperature_counts "counts"
        "Least and largest temperature of a Morpheus servo, in counts of its converter, not \
         calibrated."
        Range::whole(0, COUNTS);
    number one temperature_drift_counts "counts"
        "How far that may change since the first reading after a start, either way."
        Range::whole(0, COUNTS);
    number one dead_zone_counts "counts"
        "Encoder counts from either end that are taken for the gap of the track."
        Range::whole(0, u8::MAX as u32);
    number one lost_ms "ms"
        "How long samples of one joint may be missing; five ticks at least."
        Range::whole(1, hard::LOST_MS as u32);
    number one lost_percent "%"
        "Share of a joint's samples that may be missing within a second."
        Range::whole(1, hard::LOST_PERCENT as u32);
    number one overruns "ticks"
        "Ticks in a row that may begin a whole period late, and one less."
        Range::whole(1, hard::OVERRUNS as u32);
    number one innovation_rad "rad"
        "Distance between sample and prediction, for three samples in a row."
        at_most(hard::INNOVATION_RAD);
    number one stuck_nm "N m"
        "Torque, beyond gravity, that is sure to move a joint."
        at_most(hard::STUCK_NM);
    number one quiet_ms "ms"
        "How long an encoder may repeat one count while a controller holds the joint, before a \
         small motion must change it; 0: as long as its noise explains."
        Range::whole(0, u16::MAX as u32);
    pair each external_nm "N m"
        "Torque on a joint that the model does not explain, for a second while a controller \
         holds the arm."
        at_most(hard::TORQUE_NM);
    number one check_rad_s2 "rad/s²"
        "Acceleration with which the motors are checked at the first arming; 0: not at all."
        Range::whole(0, hard::CHECK_RAD_S2 as u32);
    number one hold_ms "ms"
        "Silence of the host after which the arm is braked and held; at most `limits.silence_ms`."
        Range::whole(0, SILENCE_MS);
    number one silence_ms "ms"
        "Silence of the host after which torque goes off."
        Range::whole(1, SILENCE_MS);
    number one torque_age_ms "ms"
        "Age at which a constant torque ends unless it is commanded again, even while heartbeats \
         arrive."
        Range::whole(1, hard::AGE_MS as u32);
    number one stream_age_ms "ms"
        "Age of a stream's last point at which the arm is braked and held."
        Range::whole(1, hard::AGE_MS as u32);
    number one setpoint_age_ms "ms"
        "Age at which a setpoint that is held ends, and the torque with it, or a motion, and the \
         arm is held; 0: never."
        Range::whole(0, u16::MAX as u32);
    number one client_silence_ms "ms"
        "Silence after which a client of the transparent port that may have set a motor moving \
         loses the bus, motors off; 0: never."
        Range::whole(0, u16::MAX as u32);
};

/// First pose: from there an upright arm is lowered to the table in 2.4 s.
const LEANING: [Milliradians; JOINTS] = [Milliradians(1_200), Milliradians(0)];
const NONE: &str = "none";
const POSE: &str = "pose";

pub(super) const PARK: [Parameter; 2] = [
    choice(
        "park.kind",
        "The end of a drive without a fault: torque off at once, or first a motion to a pose, in \
         which the arm is lowered.",
        &[NONE, POSE],
        |s| Some(s.limits.park.map_or(NONE, |_| POSE)),
        |s, word| s.limits.park = (word == POSE).then_some(LEANING),
    ),
    pair(
        "park.angle_rad",
        "rad",
        "Pose to which the arm is moved when the host leaves or falls silent, a command expires \
         or a servo is nearly too hot.",
        Range::reals(-PARK_RAD, PARK_RAD),
        |s| access::each(s.limits.park.as_mut()?),
    ),
];
