//! Limits of the monitors, which the host may set.
//!
//! Every number has a hard bound that no host can move
//! ([`hard`]); [`Limits::is_valid`] checks whether all are within.

use armbridge_control::check_word::{CheckWord, Checked, checked};
use armbridge_servo::JOINTS;
use postcard::experimental::max_size::MaxSize;
use postcard_schema::Schema;
use serde::{Deserialize, Serialize};

/// Bounds that no host can move.
pub mod hard {
    /// Joint angle in rad: short of ±π/2, where the table stops the first joint,
    /// so that no motor is left pushing against it.
    pub const ANGLE_RAD: f32 = 1.5;
    /// Joint speed in rad/s: three times what an AX-12A reaches without load (59
    /// rpm, its e-Manual).
    pub const SPEED_RAD_S: f32 = 20.0;
    /// Torque in N m: what a servo gives at full PWM by equation (5), rounded up.
    pub const TORQUE_NM: f32 = 1.25;
    /// Rate of the torque in N m/s: from one end to the other within a tick of 1 ms.
    pub const TORQUE_RATE_NM_S: f32 = 2_500.0;
    /// PWM counts away from off.
    pub const PWM_COUNTS: u16 = 1_000;
    /// Temperature of a stock servo in °C: the most that its own limit can be set
    /// to is 150, its default 70.
    pub const TEMPERATURE_C: u8 = 80;
    /// The converter's largest count.
    pub const COUNTS: u16 = 1_023;
    /// Samples missing for so long, in ms.
    pub const LOST_MS: u16 = 100;
    /// Samples missing within a second, in percent.
    pub const LOST_PERCENT: u8 = 90;
    /// Ticks in a row that began a whole period late.
    pub const OVERRUNS: u8 = 10;
    /// Distance between sample and prediction, in rad.
    pub const INNOVATION_RAD: f32 = 0.5;
    /// Torque that moves nothing, in N m.
    pub const STUCK_NM: f32 = 1.0;
    /// Acceleration of the motor check, in rad/s²: pulses of 30 ms move a joint by 0.03 rad.
    pub const CHECK_RAD_S2: u8 = 32;
    /// Silence of the host, in ms.
    pub const SILENCE_MS: u16 = 2_000;
    /// Age of a constant torque and of a stream's last point, in ms.
    pub const AGE_MS: u16 = 10_000;
    /// Angles of the pose in which the arm is parked, in mrad: those that a motion may reach.
    pub const PARK_MRAD: i16 = 1_200;
}

/// Distance in rad before an angle limit at which the board brakes a joint, or a quarter of the
/// limit if that is less.
pub const SOFT_STOP_RAD: f32 = 0.1;

/// An angle in mrad, which has three bytes at most on the wire.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, Schema, MaxSize)]
pub struct Milliradians(pub i16);

impl Milliradians {
    /// The same angle in rad.
    pub fn rad(self) -> f32 {
        f32::from(self.0) * 1e-3
    }
}

impl Checked for Milliradians {
    fn check(&self, sum: &mut CheckWord) {
        sum.word(self.0 as u32);
    }
}

/// Limits of the monitors; replaced as one group while the board is idle.
///
/// ```
/// use armbridge_link::limits::{Limits, hard};
///
/// let gentle = Limits { torque_nm: [0.5, 0.3], ..Limits::default() };
/// assert!(gentle.is_valid());
/// // A board refuses what is beyond a hard bound, or not a number.
/// for torque in [hard::TORQUE_NM + 0.01, f32::NAN] {
///     assert!(!Limits { torque_nm: [0.5, torque], ..gentle }.is_valid());
/// }
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, Schema, MaxSize)]
pub struct Limits {
    /// Joint angles in rad beyond which torque goes off. The arm is braked before.
    pub angle_rad: [f32; JOINTS],
    /// Estimated joint speeds in rad/s.
    pub speed_rad_s: [f32; JOINTS],
    /// Torque in N m that a joint is given at most.
    pub torque_nm: [f32; JOINTS],
    /// Change of that torque in N m/s.
    pub torque_rate_nm_s: f32,
    /// PWM counts away from off that a servo is given at most.
    pub pwm_counts: u16,
    /// Temperature of a stock servo in °C.
    pub temperature_c: u8,
    /// Temperatures between which a Morpheus servo may be, in counts of its
    /// converter, which is not calibrated.
    pub temperature_counts: [u16; 2],
    /// Maximum drift from the first reading after a start.
    pub temperature_drift_counts: u16,
    /// Encoder counts from either end that are taken for the gap of the track.
    pub dead_zone_counts: u8,
    /// Longest gap in the samples of a joint, in ms; five ticks at least.
    pub lost_ms: u16,
    /// Share of a joint's samples that may be missing within a second, in percent.
    pub lost_percent: u8,
    /// Consecutive ticks, each a whole period late, that trip `Overrun`.
    pub overruns: u8,
    /// Distance between sample and prediction in rad, for three samples in a row.
    pub innovation_rad: f32,
    /// Torque in N m, beyond gravity, that is sure to move a joint.
    pub stuck_nm: f32,
    /// Time in ms for which an encoder may repeat one count while a controller holds the joint,
    /// before a small motion must change it; 0: as long as its noise explains.
    pub quiet_ms: u16,
    /// Torque in N m on each joint that the model does not explain, for a second.
    pub external_nm: [f32; JOINTS],
    /// Acceleration in rad/s² with which the motors are checked at the first arming; 0: not at
    /// all.
    pub check_rad_s2: u8,
    /// Silence of the host after which the arm is braked and held, in ms.
    pub hold_ms: u16,
    /// Silence of the host after which torque goes off, in ms.
    pub silence_ms: u16,
    /// Age in ms at which a constant torque ends, even while heartbeats arrive.
    pub torque_age_ms: u16,
    /// Age in ms of a stream's last point at which the arm is braked and held.
    pub stream_age_ms: u16,
    /// Age in ms at which a setpoint ends, and the torque with it, or a motion, and the arm is
    /// held; 0: never.
    pub setpoint_age_ms: u16,
    /// Silence in ms after which a client of the transparent port that may have set a motor
    /// moving loses the bus; 0: never.
    pub client_silence_ms: u16,
    /// Pose to which the arm is moved when the host leaves or falls silent, a command
    /// expires or a servo is nearly too hot, before it is lowered and torque goes off; `None`:
    /// torque goes off at once.
    pub park: Option<[Milliradians; JOINTS]>,
}

checked!(Limits {
    angle_rad,
    speed_rad_s,
    torque_nm,
    torque_rate_nm_s,
    pwm_counts,
    temperature_c,
    temperature_counts,
    temperature_drift_counts,
    dead_zone_counts,
    lost_ms,
    lost_percent,
    overruns,
    innovation_rad,
    stuck_nm,
    quiet_ms,
    external_nm,
    check_rad_s2,
    hold_ms,
    silence_ms,
    torque_age_ms,
    stream_age_ms,
    setpoint_age_ms,
    client_silence_ms,
    park,
});

impl Default for Limits {
    fn default() -> Self {
        Self {
            angle_rad: [hard::ANGLE_RAD; JOINTS],
            // Beyond what an AX-12A reaches: the estimate or the arm runs away.
            speed_rad_s: [10.0; JOINTS],
            torque_nm: [hard::TORQUE_NM; JOINTS],
            torque_rate_nm_s: 1_000.0,
            pwm_counts: hard::PWM_COUNTS,
            // Where a stock servo switches itself off.
            temperature_c: 70,
            temperature_counts: [0, hard::COUNTS],
            temperature_drift_counts: 250,
            dead_zone_counts: 8,
            lost_ms: 20,
            lost_percent: 50,
            overruns: 3,
            innovation_rad: 0.1,
            stuck_nm: 0.4,
            // Before an arm that nothing controls is 0.5 rad off.
            quiet_ms: 400,
            // Well above dry friction, below the weight of a link that leans.
            external_nm: [0.22, 0.15],
            // Pulses of 30 ms move a joint by three encoder counts either way.
            check_rad_s2: 16,
            hold_ms: 100,
            silence_ms: 500,
            torque_age_ms: 2_000,
            stream_age_ms: 2_000,
            setpoint_age_ms: 0,
            client_silence_ms: 500,
            park: None,
        }
    }
}

impl Limits {
    /// Pose in which the arm is parked, in rad.
    pub fn park_rad(&self) -> Option<[f32; JOINTS]> {
        self.park.map(|angles| angles.map(Milliradians::rad))
    }

    /// Whether the pose of a park is within the bounds of motions, and short of where a joint is
    /// braked before its angle limit.
    pub fn is_pose_valid(&self) -> bool {
        let pose = self.park.iter().flatten().zip(self.angle_rad);
        pose.into_iter().all(|(angle, limit_rad)| {
            let is_motion = angle.0.unsigned_abs() <= hard::PARK_MRAD.unsigned_abs();
            is_motion && angle.rad().abs() <= limit_rad - SOFT_STOP_RAD.min(limit_rad * 0.25)
        })
    }

    /// Whether every number is within its hard bound, and none is NaN.
    pub fn is_valid(&self) -> bool {
        let within = |values: &[f32], limit: f32| {
            // NaN is out of every range.
            values.iter().all(|value| *value > 0.0 && *value <= limit)
        };
        let [coldest, hottest] = self.temperature_counts;
        within(&self.angle_rad, hard::ANGLE_RAD)
            && within(&self.speed_rad_s, hard::SPEED_RAD_S)
            && within(&self.torque_nm, hard::TORQUE_NM)
            && within(&[self.torque_rate_nm_s], hard::TORQUE_RATE_NM_S)
            && within(&[self.innovation_rad], hard::INNOVATION_RAD)
            && within(&[self.stuck_nm], hard::STUCK_NM)
            && within(&self.external_nm, hard::TORQUE_NM)
            && self.check_rad_s2 <= hard::CHECK_RAD_S2
            && (1..=hard::PWM_COUNTS).contains(&self.pwm_counts)
            && self.temperature_c <= hard::TEMPERATURE_C
            && coldest < hottest
            && hottest <= hard::COUNTS
            && self.temperature_drift_counts <= hard::COUNTS
            && (1..=hard::LOST_MS).contains(&self.lost_ms)
            && (1..=hard::LOST_PERCENT).contains(&self.lost_percent)
            && (1..=hard::OVERRUNS).contains(&self.overruns)
            && self.hold_ms <= self.silence_ms
            && (1..=hard::SILENCE_MS).contains(&self.silence_ms)
            && (1..=hard::AGE_MS).contains(&self.torque_age_ms)
            && (1..=hard::AGE_MS).contains(&self.stream_age_ms)
            && self.is_pose_valid()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn defaults_are_within_and_nothing_beyond_is() {
        assert!(Limits::default().is_valid());
        let beyond: [fn(&mut Limits); 11] = [
            |limits| limits.angle_rad[1] = hard::ANGLE_RAD * 1.01,
            |limits| limits.speed_rad_s[0] = f32::NAN,
            |limits| limits.torque_nm[0] = 0.0,
            |limits| limits.torque_rate_nm_s = f32::INFINITY,
            |limits| limits.pwm_counts = 1_001,
            |limits| limits.temperature_counts = [5, 5],
            |limits| limits.silence_ms = limits.hold_ms - 1,
            |limits| limits.lost_ms = 0,
            |limits| limits.park = Some([Milliradians(0), Milliradians(hard::PARK_MRAD + 1)]),
            |limits| {
                limits.angle_rad = [0.8; JOINTS];
                limits.park = Some([Milliradians(720), Milliradians(0)]);
            },
            |limits| limits.park = Some([Milliradians(i16::MIN), Milliradians(0)]),
        ];
        for change in beyond {
            let mut limits = Limits::default();
            change(&mut limits);
            assert!(!limits.is_valid(), "{limits:?}");
        }
    }
}
