//! One joint's servo: counts to radians, torque to PWM.
//!
//! # Encoder
//!
//! The servo reports its angle in counts 0..=1023 of 300/1023 degree (5.118
//! mrad). [`Joint::angle`] turns counts into rad, [`Joint::position`] is the
//! inverse.
//!
//! # Motor
//!
//! A Morpheus servo takes a PWM in 0..=2000, 1000 being off, above turning
//! towards higher counts. Equation (5) of the paper relates it to torque:
//!
//! ```text
//! PWM = 834 torque + 15 + 1000        torque -1.2170 ..= +1.1811 N m
//! ```
//!
//! By (5) zero torque is 1015, although the paper's text calls 1000 zero. Both
//! are kept: a torque is converted by (5), and 1000 *exactly* is the motor off,
//! which stands for zero torque. So a torque that would come to 1000 is sent as
//! 999 or 1001: a motor that fell silent at -0.018 N m would be a step in the
//! loop, and the arm can come to rest on it.
//!
//! The estimator must be given what the servo was sent: PWM is a clamped
//! integer, and a [`Command`] carries the torque that this integer stands for.
//!
//! The paper's dead zone, no motion for 950 < PWM < 1050, is static friction, and is
//! met by [`DryFriction`](crate::controller::DryFriction) as a torque.

use crate::check_word::{CheckWord, Checked, checked};
use crate::encoder::Encoder;
use crate::real::Real;
use armbridge_servo::Pwm;
#[cfg(feature = "postcard")]
use postcard::experimental::max_size::MaxSize;
#[cfg(feature = "postcard")]
use postcard_schema::Schema;
#[cfg(feature = "postcard")]
use serde::{Deserialize, Serialize};

/// Which way the servo is mounted.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
#[cfg_attr(feature = "postcard", derive(Serialize, Deserialize, Schema, MaxSize))]
pub enum Direction {
    /// Counts grow with the joint angle.
    #[default]
    Forward,
    /// Counts fall as the joint angle grows.
    Reverse,
}

impl Direction {
    fn apply<T: Real>(self, value: T) -> T {
        match self {
            Self::Forward => value,
            Self::Reverse => -value,
        }
    }
}

/// Command for a servo, and its effect.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Command<T> {
    /// For the servo.
    pub pwm: Pwm,
    /// For the estimator: the joint torque in N m that this PWM stands for.
    pub torque_nm: T,
    /// More was wanted than the servo may be given.
    pub is_limited: bool,
}

/// A torque that is not a number, or infinite: nothing to send to a servo.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct NotFinite;

/// Bounds of a calibration, beside those of the [`Encoder`].
pub mod bounds {
    /// PWM counts per N m: 834 by equation (5), a tenth and ten times that. It scales the
    /// torque, and no bound of an angle depends on it.
    pub const GAIN_COUNTS_PER_NM: [f64; 2] = [83.0, 8_340.0];
    /// PWM counts above off without torque: ten times that of equation (5), either way.
    pub const OFFSET_COUNTS: f64 = 150.0;
}

/// Calibration of one joint's servo.
///
/// ```
/// use armbridge_control::actuator::{Joint, NotFinite};
///
/// let joint = Joint::<f64>::paper();
/// // 100 counts above the middle, of 300/1023 degree each.
/// assert!((joint.angle(612).to_degrees() - 29.33).abs() < 0.01);
/// assert!((joint.position(joint.angle(612)) - 612.0).abs() < 1e-9);
///
/// // Equation (5): 834 * 0.5 + 1015 counts, and the torque that the rounded count gives.
/// let command = joint.command(0.5, 1_000).unwrap();
/// assert_eq!(command.pwm.counts(), 1_432);
/// assert!((command.torque_nm - 0.5).abs() < 0.5 / 834.0 && !command.is_limited);
///
/// // At most 200 counts from off.
/// let limited = joint.command(0.5, 200).unwrap();
/// assert_eq!((limited.pwm.counts(), limited.is_limited), (1_200, true));
/// assert_eq!(joint.command(f64::NAN, 1_000), Err(NotFinite));
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "postcard", derive(Serialize, Deserialize, Schema, MaxSize))]
pub struct Joint<T> {
    /// Encoder count at joint angle 0.
    pub zero_count: T,
    /// Angle of one encoder count in rad.
    pub rad_per_count: T,
    /// Mounting; turns the encoder and the motor alike.
    pub direction: Direction,
    /// PWM counts per N m.
    pub gain_counts_per_nm: T,
    /// PWM counts above [`Pwm::OFF`] at which the motor gives no torque.
    pub offset_counts: T,
}

checked!(Joint<T> {
    zero_count, rad_per_count, direction, gain_counts_per_nm, offset_counts,
});

impl Checked for Direction {
    fn check(&self, sum: &mut CheckWord) {
        sum.word(match self {
            Self::Forward => 0,
            Self::Reverse => 1,
        });
    }
}

impl<T: Real> Joint<T> {
    /// Equation (5), and the middle of the AX-12A's 0..=1023 over 300 degree
    /// as upright.
    pub fn paper() -> Self {
        Self {
            zero_count: T::lit(512.0),
            rad_per_count: T::lit((300.0_f64 / 1023.0).to_radians()),
            direction: Direction::Forward,
            gain_counts_per_nm: T::lit(834.0),
            offset_counts: T::lit(15.0),
        }
    }

    /// The encoder that these numbers are of, by the angle of a count.
    pub fn encoder(&self) -> Option<Encoder> {
        Encoder::with_rad_per_count(self.rad_per_count)
    }

    /// A servo of the X series, its middle upright, and the torque of the paper's: stall torque
    /// and friction of a model are to be identified.
    pub fn x_series() -> Self {
        Self {
            zero_count: T::from_count(Encoder::XSeries.middle_count()),
            rad_per_count: T::lit(Encoder::XSeries.nominal_rad_per_count()),
            offset_counts: T::lit(0.0),
            ..Self::paper()
        }
    }

    /// Whether this can be a servo, see [`bounds`]. NaN never can.
    pub fn is_valid(&self) -> bool {
        let within = |x: T, [low, high]: [f64; 2]| x >= T::lit(low) && x <= T::lit(high);
        let Some(encoder) = self.encoder() else {
            return false;
        };
        let zero_off = self.zero_count - T::from_count(encoder.middle_count());
        let most_off = encoder.zero_off_counts();
        within(zero_off, [-most_off, most_off])
            && within(self.gain_counts_per_nm, bounds::GAIN_COUNTS_PER_NM)
            && within(
                self.offset_counts,
                [-bounds::OFFSET_COUNTS, bounds::OFFSET_COUNTS],
            )
    }

    /// Largest joint angle in rad, the same either way, at which the count is within
    /// [`Encoder::counts_from_middle`]; 0 of a calibration that is of no encoder.
    pub fn reach_rad(&self) -> T {
        let Some(encoder) = self.encoder() else {
            return T::lit(0.0);
        };
        let zero_off = (self.zero_count - T::from_count(encoder.middle_count())).abs();
        (T::from_count(encoder.counts_from_middle()) - zero_off) * self.rad_per_count
    }

    /// Joint angle in rad at an encoder count.
    pub fn angle(&self, count: u16) -> T {
        self.direction
            .apply((T::from_count(count) - self.zero_count) * self.rad_per_count)
    }

    /// Encoder position in counts at a joint angle in rad, neither rounded nor
    /// clamped.
    pub fn position(&self, angle_rad: T) -> T {
        self.zero_count + self.direction.apply(angle_rad) / self.rad_per_count
    }

    /// The command for a joint torque in N m, at most `pwm_max` counts, but one,
    /// away from off.
    ///
    /// # Errors
    ///
    /// [`NotFinite`] for NaN and infinities. A caller that must send something
    /// sends [`Pwm::OFF`].
    pub fn command(&self, torque_nm: T, pwm_max: u16) -> Result<Command<T>, NotFinite> {
        let wanted = self.pwm(torque_nm)?;
        // Zero counts would be off, and torque is on.
        let pwm = wanted.within(pwm_max.max(1));
        Ok(Command {
            pwm,
            torque_nm: self.torque(pwm),
            is_limited: wanted != pwm || wanted == Pwm::MIN || wanted == Pwm::MAX,
        })
    }

    /// Equation (5): the nearest integer, halves up, clamped to what the servo
    /// can do, and never [`Pwm::OFF`].
    ///
    /// # Errors
    ///
    /// [`NotFinite`], as [`command`](Self::command).
    pub fn pwm(&self, torque_nm: T) -> Result<Pwm, NotFinite> {
        let counts = T::from_count(Pwm::OFF.counts())
            + self.offset_counts
            + self.gain_counts_per_nm * self.direction.apply(torque_nm);
        if !counts.is_finite() {
            return Err(NotFinite);
        }
        let off = T::from_count(Pwm::OFF.counts());
        Ok(match Pwm::saturating(counts.to_count()) {
            Pwm::OFF if counts < off => Pwm::JUST_BELOW_OFF,
            Pwm::OFF => Pwm::JUST_ABOVE_OFF,
            pwm => pwm,
        })
    }

    /// The joint torque in N m that the motor makes of a PWM: the inverse of
    /// [`pwm`](Self::pwm), and none for [`Pwm::OFF`].
    pub fn torque(&self, pwm: Pwm) -> T {
        if pwm == Pwm::OFF {
            return T::zero();
        }
        let counts =
            T::from_count(pwm.counts()) - T::from_count(Pwm::OFF.counts()) - self.offset_counts;
        self.direction.apply(counts / self.gain_counts_per_nm)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn joints() -> [Joint<f32>; 2] {
        let direction = Direction::Reverse;
        [
            Joint::paper(),
            Joint {
                direction,
                ..Joint::paper()
            },
        ]
    }

    #[test]
    fn no_torque_that_is_not_finite_becomes_a_pwm() {
        for joint in joints() {
            for torque in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, f32::MAX] {
                assert_eq!(joint.pwm(torque), Err(NotFinite), "{torque}");
                assert_eq!(joint.command(torque, 1_000), Err(NotFinite), "{torque}");
            }
        }
        let joint = Joint::paper();
        assert_eq!(joint.pwm(1e30), Ok(Pwm::MAX));
        assert_eq!(joint.pwm(-1e30), Ok(Pwm::MIN));
    }

    #[test]
    fn every_pwm_survives_the_round_trip_through_torque() {
        for joint in joints() {
            for pwm in (0..=2000)
                .filter_map(Pwm::new)
                .filter(|&pwm| pwm != Pwm::OFF)
            {
                assert_eq!(joint.pwm(joint.torque(pwm)), Ok(pwm));
            }
            assert_eq!(joint.torque(Pwm::OFF).to_bits(), 0);
        }
    }

    #[test]
    fn a_command_tells_the_torque_left_after_rounding_and_clamp() {
        for joint in joints() {
            let told = |torque| joint.command(torque, 1_000).unwrap().torque_nm;
            for step in -110..=110_i16 {
                let torque = f32::from(step) * 0.01;
                let lost = (told(torque) - torque).abs();
                // Half a count; at PWM 1000 the motor is off, 15 counts early.
                assert!(
                    lost <= 0.51 / 834.0 || told(torque) == 0.0,
                    "{torque}: {lost}"
                );
            }
            assert!(told(5.0) < 1.25 && told(-5.0) > -1.25);
        }
    }

    #[test]
    fn a_torque_is_never_sent_as_off() {
        for joint in joints() {
            for step in -2000..=2000_i16 {
                let command = joint.command(f32::from(step) * 1e-4, 1_000).unwrap();
                assert_ne!(command.pwm, Pwm::OFF, "{step}");
            }
        }
    }

    #[test]
    fn a_reversed_joint_mirrors_encoder_and_motor() {
        let joint = Joint::<f64> {
            direction: Direction::Reverse,
            ..Joint::paper()
        };
        assert!(joint.angle(600) < 0.0);
        assert!((joint.position(joint.angle(600)) - 600.0).abs() < 1e-12);
        assert_eq!(joint.pwm(0.1), Ok(Pwm::saturating(932)));
    }
}
