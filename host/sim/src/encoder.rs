//! Position encoders of the servos: from a shaft's position to the count that is read.
//!
//! Positions are in counts of the encoder itself, as a plant's calibration has them, before
//! rounding. An AX-12A has a potentiometer: 1024 counts over 300 degrees, and its end where the
//! shaft is in the gap. The X series has a contactless encoder of 4096 counts a turn (e-Manual,
//! "Specifications"), which goes on from 4095 to 0.

/// Kind of encoder.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Encoder {
    /// That of an AX-12A.
    Potentiometer,
    /// That of the X series.
    Absolute,
}

/// Counts of a turn of the potentiometer: 0 to 1023 are 300 degrees.
const POTENTIOMETER_TURN: f64 = 360.0 / (300.0 / 1023.0);
/// Counts of a turn of the absolute encoder.
const ABSOLUTE_TURN: f64 = 4096.0;

impl Encoder {
    /// Largest count.
    pub const fn largest_count(self) -> u16 {
        match self {
            Self::Potentiometer => 1023,
            Self::Absolute => 4095,
        }
    }

    /// Counts of a turn, of which the potentiometer does not read all.
    pub const fn counts_per_turn(self) -> f64 {
        match self {
            Self::Potentiometer => POTENTIOMETER_TURN,
            Self::Absolute => ABSOLUTE_TURN,
        }
    }

    /// The count nearest to a position.
    pub fn count(self, position: f64) -> u16 {
        let nearest = position.round();
        match self {
            Self::Potentiometer => nearest.clamp(0.0, 1023.0) as u16,
            Self::Absolute => nearest.rem_euclid(ABSOLUTE_TURN) as u16,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_ends_and_the_other_goes_round() {
        let counts = |encoder: Encoder| [-0.6, 0.4, 1023.4, 4095.6].map(|at| encoder.count(at));
        assert_eq!(counts(Encoder::Potentiometer), [0, 0, 1023, 1023]);
        assert_eq!(counts(Encoder::Absolute), [4095, 0, 1023, 0]);
    }
}
