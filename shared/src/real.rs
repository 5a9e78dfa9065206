//! The real number that the mathematics is written over.
//!
//! Everything in [`arm`](crate::arm), [`design`](crate::design),
//! [`control`](crate::control) and [`estimate`](crate::estimate) is generic
//! over [`Real`]: `f32` on the board, `f64` where the host designs and checks.
//!
//! # Bit repeatability
//!
//! The same `f32` inputs give the same bits on x86-64 and on a Cortex-M4F:
//! sums, products, quotients and roots are IEEE 754 on both, sine, power and
//! the like come from `libm` on both (nalgebra's `libm-force`), and nothing
//! here uses a fused multiply-add.

use nalgebra::RealField;

/// `f32` or `f64`.
pub trait Real: RealField + Copy {
    /// The nearest value to a constant.
    fn lit(value: f64) -> Self;

    /// A count as a real number, exactly.
    fn from_count(count: u16) -> Self;

    /// The nearest count, halves up, saturating at both ends; NaN gives 0.
    fn to_count(self) -> u16;
}

macro_rules! real {
    ($float:ty) => {
        impl Real for $float {
            fn lit(value: f64) -> Self {
                value as $float
            }

            fn from_count(count: u16) -> Self {
                count as $float
            }

            fn to_count(self) -> u16 {
                // The cast truncates towards zero, which is the floor of what
                // is not negative, and saturates the rest.
                (self + 0.5) as u16
            }
        }
    };
}

real!(f32);
real!(f64);
