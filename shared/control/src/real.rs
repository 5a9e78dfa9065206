//! The real number that the mathematics is written over.
//!
//! Everything in [`arm`](crate::arm), [`design`](crate::design),
//! [`control`](crate::controller) and [`estimate`](crate::estimate) is generic
//! over [`Real`]: `f32` on the board, `f64` where the host designs and checks.
//!
//! # Bit repeatability
//!
//! A host that replays a board's tick must get the board's bits. So only what
//! is the same everywhere is used: sums, products, quotients and roots as IEEE
//! 754 defines them, no fused multiply-add, and sine, power and the like from
//! one library, `libm` (nalgebra's `libm-force`), on host and board alike.

use nalgebra::RealField;

/// `f32` or `f64`.
pub trait Real: RealField + Copy {
    /// The nearest value to a constant.
    fn lit(value: f64) -> Self;

    /// A count as a real number, exactly.
    fn from_count(count: u16) -> Self;

    /// Sine and cosine of an angle in rad, together.
    fn sine_cosine(self) -> (Self, Self);

    /// The nearest count, halves up, saturating at both ends; NaN gives 0.
    fn to_count(self) -> u16;
}

macro_rules! real {
    ($float:ty, $sin_cos:path) => {
        impl Real for $float {
            fn lit(value: f64) -> Self {
                value as $float
            }

            fn from_count(count: u16) -> Self {
                count as $float
            }

            fn sine_cosine(self) -> (Self, Self) {
                $sin_cos(self)
            }

            fn to_count(self) -> u16 {
                // The cast truncates towards zero, which is the floor of what
                // is not negative, and saturates the rest.
                (self + 0.5) as u16
            }
        }
    };
}

real!(f32, crate::trig::sin_cos);
real!(f64, nalgebra::ComplexField::sin_cos);
