//! Encoders of the servos: their counts, and what a calibration with them can be.
//!
//! | encoder  | servos   | counts             | angle of a count    | middle |
//! |----------|----------|--------------------|---------------------|--------|
//! | `Ax12a`  | AX-12A   | 0..=1023, 300°     | 5.118 mrad          | 512    |
//! | `XSeries` | X series | 0..=4095, a turn  | 1.534 mrad          | 2048   |
//!
//! An AX-12A has a potentiometer, whose track differs from one to the next by some percent. The X
//! series has a contactless absolute encoder, of 4096 counts a turn (e-Manual, "Specifications").

use crate::check_word::{CheckWord, Checked};
use crate::real::Real;
use armbridge_servo::Firmware;

/// Kind of a servo's encoder.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Encoder {
    /// That of an AX-12A, with either firmware.
    Ax12a,
    /// That of the X series.
    XSeries,
}

impl Checked for Encoder {
    fn check(&self, sum: &mut CheckWord) {
        sum.word(match self {
            Self::Ax12a => 0,
            Self::XSeries => 1,
        });
    }
}

impl Encoder {
    /// All of them.
    pub const ALL: [Self; 2] = [Self::Ax12a, Self::XSeries];

    /// That of servos with this firmware.
    pub const fn of(firmware: Firmware) -> Self {
        match firmware {
            Firmware::Morpheus | Firmware::Stock => Self::Ax12a,
            Firmware::XSeries => Self::XSeries,
        }
    }

    /// The encoder with this angle of a count in rad, if there is one.
    pub fn with_rad_per_count<T: Real>(rad_per_count: T) -> Option<Self> {
        Self::ALL.into_iter().find(|encoder| {
            let [low, high] = encoder.rad_per_count().map(T::lit);
            rad_per_count >= low && rad_per_count <= high
        })
    }

    /// Largest count.
    pub const fn counts_max(self) -> u16 {
        match self {
            Self::Ax12a => 1023,
            Self::XSeries => 4095,
        }
    }

    /// Count in the middle.
    pub const fn middle_count(self) -> u16 {
        match self {
            Self::Ax12a => 512,
            Self::XSeries => 2048,
        }
    }

    /// Largest distance of a count from the middle: the first beyond 1.5 rad, the hard bound of a
    /// joint angle, at the nominal angle of a count. Calibration does not move it.
    pub const fn counts_from_middle(self) -> u16 {
        match self {
            Self::Ax12a => 294,
            Self::XSeries => 978,
        }
    }

    /// Nominal angle of a count in rad.
    pub const fn nominal_rad_per_count(self) -> f64 {
        match self {
            Self::Ax12a => 300.0 / 1023.0 * core::f64::consts::PI / 180.0,
            Self::XSeries => core::f64::consts::TAU / 4096.0,
        }
    }

    /// Least and largest angle of a count in rad: a tenth either way of 300/1023 degree, and a
    /// fiftieth of 360/4096.
    pub const fn rad_per_count(self) -> [f64; 2] {
        match self {
            Self::Ax12a => [0.0046, 0.0057],
            Self::XSeries => [0.001_503, 0.001_565],
        }
    }

    /// Largest distance of a joint's zero from the middle in counts: half a radian. The horn's
    /// spline allows 15 of an AX-12A, a bracket some more; a servo mounted further off would not
    /// reach either side.
    pub const fn zero_off_counts(self) -> f64 {
        match self {
            Self::Ax12a => 100.0,
            Self::XSeries => 326.0,
        }
    }
}
