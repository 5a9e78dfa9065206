//! Sine and cosine of one angle in `f32`, together.
//!
//! `libm` computes its `f32` functions in `f64`, which a Cortex-M4F has to do
//! in software: 2200 instructions for the pair. This is single precision
//! throughout, a few dozen instructions, the same time for every angle, and
//! the same bits on every machine: sums and products only, none of them fused.
//!
//! The angle is reduced to |r| <= π/4 about the nearest multiple of π/2, which
//! is subtracted in three parts so that no digit is lost (Cody and Waite), and
//! the two are read off minimax polynomials (the coefficients of Cephes' `sinf`
//! and `cosf`). Absolute error below 1e-7 up to 2π and below 2e-7 up to 100 rad,
//! far beyond any joint; further out it grows with the angle. NaN for NaN and
//! infinities.

use core::f32::consts::FRAC_2_PI;

/// π/2 in three parts; the first two have so few digits that their products
/// with small whole numbers are exact.
const HALF_PI: [f32; 3] = [1.5703125, 4.837513e-4, 7.54979e-8];

/// `(sin x, cos x)`.
#[allow(clippy::excessive_precision)] // Coefficients as published.
pub(crate) fn sin_cos(x: f32) -> (f32, f32) {
    let turns = x * FRAC_2_PI;
    // Truncation after adding half: the nearest whole number. Saturates, and is
    // 0 for NaN.
    let quarter = (turns + 0.5_f32.copysign(turns)) as i32;
    let k = quarter as f32;
    let r = ((x - k * HALF_PI[0]) - k * HALF_PI[1]) - k * HALF_PI[2];
    let z = r * r;
    let sin = r + r * z * (-1.6666654611e-1 + z * (8.3321608736e-3 - z * 1.9515295891e-4));
    let cos = (1.0 - 0.5 * z)
        + z * z * (4.166664568298827e-2 + z * (-1.388731625493765e-3 + z * 2.443315711809948e-5));
    match quarter & 3 {
        0 => (sin, cos),
        1 => (cos, -sin),
        2 => (-sin, -cos),
        _ => (-cos, sin),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    extern crate std;

    fn worst_error(limit: f64) -> f64 {
        const STEPS: u32 = 200_000;
        let errors = (0..=STEPS).map(|i| {
            let x = ((2.0 * f64::from(i) / f64::from(STEPS) - 1.0) * limit) as f32;
            let ((sin, cos), (true_sin, true_cos)) = (sin_cos(x), f64::from(x).sin_cos());
            (f64::from(sin) - true_sin)
                .abs()
                .max((f64::from(cos) - true_cos).abs())
        });
        errors.fold(0.0, f64::max)
    }

    #[test]
    fn errors_are_as_documented() {
        let (near, far) = (worst_error(core::f64::consts::TAU), worst_error(100.0));
        assert!(near < 1e-7, "{near:e}");
        assert!(far < 2e-7, "{far:e}");
    }

    #[test]
    fn exact_where_it_should_be_and_nan_where_it_must() {
        assert_eq!(sin_cos(0.0), (0.0, 1.0));
        for x in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
            let (sin, cos) = sin_cos(x);
            assert!(sin.is_nan() && cos.is_nan(), "{x}");
        }
    }
}
