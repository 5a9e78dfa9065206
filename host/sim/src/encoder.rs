//! Readings of the servos' encoders: from a shaft's position to the count that is read.
//!
//! Positions are in counts of the encoder itself, as a plant's calibration has them, before
//! rounding. The potentiometer of an AX-12A ends where the shaft is in its gap of 60 degrees; the
//! encoder of the X series goes on from 4095 to 0.

use armbridge_control::encoder::Encoder;

/// Counts of a turn, of which an AX-12A does not read all: 0 to 1023 are 300 degrees.
pub(crate) const fn counts_per_turn(encoder: Encoder) -> f64 {
    match encoder {
        Encoder::Ax12a => 360.0 / (300.0 / 1023.0),
        Encoder::XSeries => 4096.0,
    }
}

/// The count nearest to a position.
pub(crate) fn count(encoder: Encoder, position: f64) -> u16 {
    let nearest = position.round();
    match encoder {
        Encoder::Ax12a => nearest.clamp(0.0, f64::from(encoder.counts_max())) as u16,
        Encoder::XSeries => nearest.rem_euclid(counts_per_turn(encoder)) as u16,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_ends_and_the_other_goes_round() {
        let counts = |encoder| [-0.6, 0.4, 1023.4, 4095.6].map(|at| count(encoder, at));
        assert_eq!(counts(Encoder::Ax12a), [0, 0, 1023, 1023]);
        assert_eq!(counts(Encoder::XSeries), [4095, 0, 1023, 0]);
    }
}
