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
//! which stands for zero torque.
//!
//! What the estimator must be told is what the servo was told: PWM is a clamped
//! integer, and [`Joint::torque`] says which torque that integer stands for.
//!
//! # Dead zone
//!
//! The paper finds no motion for 950 < PWM < 1050: 50 counts, 0.06 N m, of
//! static friction. [`DeadZone`] adds them in the direction of the torque, so
//! that what is asked for is what reaches the arm. The step at zero torque is
//! a ramp, or noise about zero would make the servo rattle by 100 counts.

use crate::real::Real;

/// A PWM command for a Morpheus servo, 0..=2000.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Pwm(u16);

impl Pwm {
    /// The motor off.
    pub const OFF: Self = Self(1000);
    /// Full torque towards lower counts.
    pub const MIN: Self = Self(0);
    /// Full torque towards higher counts.
    pub const MAX: Self = Self(2000);

    /// Takes only what a servo obeys; it ignores anything above 2000.
    pub const fn new(counts: u16) -> Option<Self> {
        if counts <= Self::MAX.0 {
            Some(Self(counts))
        } else {
            None
        }
    }

    /// The nearest valid command.
    pub fn saturating(counts: u16) -> Self {
        Self(counts.min(Self::MAX.0))
    }

    /// The number on the wire.
    pub const fn counts(self) -> u16 {
        self.0
    }
}

impl Default for Pwm {
    fn default() -> Self {
        Self::OFF
    }
}

/// Which way the servo is mounted.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
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

/// Compensation of static friction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DeadZone<T> {
    /// PWM counts added in the direction of the torque.
    pub half_width_counts: T,
    /// Torque in N m at which all of them are added; proportionally fewer
    /// below.
    pub blend_nm: T,
}

impl<T: Real> DeadZone<T> {
    /// 50 counts, half of the paper's 950..1050, blended in over 10 mN m:
    /// about twice what sensor noise makes of a torque at rest.
    pub fn paper() -> Self {
        Self {
            half_width_counts: T::lit(50.0),
            blend_nm: T::lit(0.01),
        }
    }

    fn counts(&self, torque_nm: T) -> T {
        if torque_nm.abs() >= self.blend_nm {
            self.half_width_counts.copysign(torque_nm)
        } else {
            self.half_width_counts * (torque_nm / self.blend_nm)
        }
    }
}

/// A torque that is not a number, or infinite: nothing to send to a servo.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct NotFinite;

/// Calibration of one joint's servo.
#[derive(Clone, Copy, Debug, PartialEq)]
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
    /// Compensation of static friction, where wanted.
    pub dead_zone: Option<DeadZone<T>>,
}

impl<T: Real> Joint<T> {
    /// Equation (5), and the middle of the AX-12A's 0..=1023 over 300 degree
    /// as upright; no dead-zone compensation.
    pub fn paper() -> Self {
        Self {
            zero_count: T::lit(512.0),
            rad_per_count: T::lit((300.0_f64 / 1023.0).to_radians()),
            direction: Direction::Forward,
            gain_counts_per_nm: T::lit(834.0),
            offset_counts: T::lit(15.0),
            dead_zone: None,
        }
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

    /// The PWM for a joint torque in N m: the nearest integer, halves up,
    /// clamped to what the servo can do.
    ///
    /// # Errors
    ///
    /// [`NotFinite`] for NaN and infinities. A caller that must send something
    /// sends [`Pwm::OFF`].
    pub fn pwm(&self, torque_nm: T) -> Result<Pwm, NotFinite> {
        let torque_nm = self.direction.apply(torque_nm);
        let compensation = self
            .dead_zone
            .map_or(T::zero(), |zone| zone.counts(torque_nm));
        let counts = T::from_count(Pwm::OFF.0)
            + self.offset_counts
            + self.gain_counts_per_nm * torque_nm
            + compensation;
        if torque_nm.is_finite() && counts.is_finite() {
            Ok(Pwm::saturating(counts.to_count()))
        } else {
            Err(NotFinite)
        }
    }

    /// The joint torque in N m that a PWM stands for: the inverse of
    /// [`pwm`](Self::pwm), less the compensation where there is one, for the
    /// dead zone takes that share. [`Pwm::OFF`] stands for none.
    pub fn torque(&self, pwm: Pwm) -> T {
        if pwm == Pwm::OFF {
            return T::zero();
        }
        let counts = T::from_count(pwm.0) - T::from_count(Pwm::OFF.0) - self.offset_counts;
        let torque_nm = match self.dead_zone {
            None => counts / self.gain_counts_per_nm,
            Some(zone) => {
                let knee = zone.half_width_counts + self.gain_counts_per_nm * zone.blend_nm;
                if counts.abs() >= knee {
                    (counts - zone.half_width_counts.copysign(counts)) / self.gain_counts_per_nm
                } else {
                    zone.blend_nm * (counts / knee)
                }
            }
        };
        self.direction.apply(torque_nm)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn compensated(direction: Direction) -> Joint<f32> {
        Joint {
            direction,
            dead_zone: Some(DeadZone::paper()),
            ..Joint::paper()
        }
    }

    #[test]
    fn no_torque_that_is_not_finite_becomes_a_pwm() {
        for joint in [Joint::paper(), compensated(Direction::Reverse)] {
            for torque in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, f32::MAX] {
                assert_eq!(joint.pwm(torque), Err(NotFinite), "{torque}");
            }
        }
        assert_eq!(Joint::paper().pwm(1e30_f32), Ok(Pwm::MAX));
        assert_eq!(Joint::paper().pwm(-1e30_f32), Ok(Pwm::MIN));
    }

    #[test]
    fn only_what_a_servo_obeys_is_a_pwm() {
        assert_eq!(Pwm::new(2000), Some(Pwm::MAX));
        assert_eq!(Pwm::new(2001), None);
        assert_eq!(Pwm::saturating(u16::MAX), Pwm::MAX);
    }

    #[test]
    fn every_pwm_survives_the_round_trip_through_torque() {
        let joints = [
            Joint::paper(),
            compensated(Direction::Forward),
            compensated(Direction::Reverse),
        ];
        for joint in joints {
            for counts in 0..=2000 {
                let pwm = Pwm(counts);
                if pwm != Pwm::OFF {
                    assert_eq!(joint.pwm(joint.torque(pwm)), Ok(pwm), "{joint:?}");
                }
            }
            assert_eq!(joint.torque(Pwm::OFF), 0.0);
        }
    }

    #[test]
    fn compensation_adds_its_counts_outside_the_blend_and_is_continuous() {
        let (plain, joint) = (Joint::paper(), compensated(Direction::Forward));
        for torque in [0.01_f32, 0.1, 0.5] {
            for sign in [1.0, -1.0] {
                let counts = |joint: &Joint<f32>| i32::from(joint.pwm(sign * torque).unwrap().0);
                let added = f32::from((counts(&joint) - counts(&plain)) as i16) * sign;
                assert_eq!(added, 50.0, "{torque}");
            }
        }
        // Over the blend, 50 counts in 10 mN m are 5 counts per mN m, and
        // equation (5) adds 0.8.
        let mut last = joint.pwm(-0.02).unwrap().0;
        for step in -199..=200_i16 {
            let now = joint.pwm(f32::from(step) * 1e-4).unwrap().0;
            assert!((last..=last + 1).contains(&now), "{step}: {last} to {now}");
            last = now;
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
        assert_eq!(joint.pwm(0.1), Ok(Pwm(932)));
    }
}
