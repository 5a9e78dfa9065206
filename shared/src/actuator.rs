//! To come: stand-in.

/// PWM.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Pwm(u16);

impl Pwm {
    /// Off.
    pub const OFF: Self = Self(1000);
    /// Checked.
    pub const fn new(counts: u16) -> Option<Self> {
        if counts <= 2000 {
            Some(Self(counts))
        } else {
            None
        }
    }
    /// Counts.
    pub const fn counts(self) -> u16 {
        self.0
    }
}
