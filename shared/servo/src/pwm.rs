//! PWM commands, in the counts of the Morpheus firmware.

/// A PWM command for a Morpheus servo, 0..=2000.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[cfg_attr(feature = "snapshot", derive(serde::Serialize, serde::Deserialize))]
pub struct Pwm(u16);

impl Pwm {
    /// The motor off.
    pub const OFF: Self = Self(1000);
    /// The smallest torque towards lower counts.
    pub const JUST_BELOW_OFF: Self = Self(999);
    /// The smallest torque towards higher counts.
    pub const JUST_ABOVE_OFF: Self = Self(1001);
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

    /// The nearest to this many counts from off, halves up; off itself for NaN and
    /// infinities.
    pub fn from_off(counts: f32) -> Self {
        if counts.is_finite() {
            // The cast truncates towards zero, and saturates.
            Self::saturating((counts + f32::from(Self::OFF.0) + 0.5) as u16)
        } else {
            Self::OFF
        }
    }

    /// The nearest command at most this many counts away from off.
    #[must_use]
    pub fn within(self, most: u16) -> Self {
        let least = Self::OFF.0.saturating_sub(most);
        Self(self.0.clamp(least, Self::OFF.0.saturating_add(most)))
    }

    /// The number on the wire.
    pub const fn counts(self) -> u16 {
        self.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_what_a_servo_obeys_is_a_pwm() {
        assert_eq!(Pwm::new(2000), Some(Pwm::MAX));
        assert_eq!(Pwm::new(2001), None);
        assert_eq!(Pwm::saturating(u16::MAX), Pwm::MAX);
    }
}
