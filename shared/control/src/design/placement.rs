//! Observer poles for one joint.
//!
//! About upright the joints do not couple, so the observer of each is a 2 x 2
//! problem with one measured state and one gain per pole: the gain is unique
//! and closed. Multi-output placers solve a problem with no unique answer, and
//! every one returns another gain.
//!
//! The error of `x^(k+1) = A x^(k) + B u(k) + L (y(k) - C x^(k))`, equation
//! (11), decays as `A - L C`. This prediction form answers a sample one period
//! later. The current form corrects with it at once,
//!
//! ```text
//! x^(k) = x-(k) + Lc (y(k) - C x-(k))        x-(k+1) = A x^(k) + B u(k)
//! ```
//!
//! and with `L = A Lc` both are the same recursion with the same poles. A here
//! is the 2 x 2 block of one joint, see
//! [`Discrete::joints`](crate::arm::Discrete::joints).
//!
//! ```
//! use armbridge_control::arm::Parameters;
//! use armbridge_control::design::placement::{Error, Poles, prediction_gain};
//! use nalgebra::Vector2;
//!
//! let model = Parameters::<f64>::paper().linearise(Vector2::zeros()).zero_order_hold(1e-3);
//! let [joint, _] = model.joints();
//! let gain = prediction_gain(&joint, Poles::Real(0.9, 0.95)).unwrap();
//!
//! let mut error = joint;
//! error.m11 -= gain.x;
//! error.m21 -= gain.y;
//! assert!((error.trace() - (0.9 + 0.95)).abs() < 1e-12);
//! assert!((error.determinant() - 0.9 * 0.95).abs() < 1e-12);
//!
//! assert_eq!(prediction_gain(&joint, Poles::Real(0.9, 1.0)), Err(Error::Unstable));
//! ```

use super::stability::Eigenvalue;
use crate::real::Real;
use nalgebra::{ComplexField, Matrix2, Vector2};
#[cfg(feature = "postcard")]
use postcard::experimental::max_size::MaxSize;
#[cfg(feature = "postcard")]
use postcard_schema::Schema;
#[cfg(feature = "postcard")]
use serde::{Deserialize, Serialize};

/// The two poles of one joint's observer, in z.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "postcard", derive(Serialize, Deserialize, Schema, MaxSize))]
pub enum Poles<T> {
    /// Two real poles.
    Real(T, T),
    /// `re + i im` and `re - i im`.
    Conjugate {
        /// Real part.
        re: T,
        /// Imaginary part.
        im: T,
    },
}

/// Why a placement is refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Error {
    /// A pole or a model entry is not finite.
    NotFinite,
    /// A pole lies on or outside the unit circle: the error would not decay.
    Unstable,
    /// A negative real pole has no counterpart at another period.
    Negative,
    /// The angle does not depend on the speed, so samples cannot show it.
    Unobservable,
    /// The model has a pole at zero, so there is no current form.
    NotInvertible,
}

impl<T> Poles<T> {
    /// The same poles in another precision.
    pub fn map<U>(self, convert: impl Fn(T) -> U) -> Poles<U> {
        match self {
            Self::Real(p1, p2) => Poles::Real(convert(p1), convert(p2)),
            Self::Conjugate { re, im } => Poles::Conjugate {
                re: convert(re),
                im: convert(im),
            },
        }
    }
}

impl<T: Real> Poles<T> {
    /// The larger of them.
    pub fn dominant(self) -> Eigenvalue<T> {
        let (re, im) = match self {
            Self::Real(p1, p2) if p1.abs() < p2.abs() => (p2, T::zero()),
            Self::Real(p1, _) => (p1, T::zero()),
            Self::Conjugate { re, im } => (re, im.abs()),
        };
        Eigenvalue { re, im }
    }

    /// The poles that decay as fast in time when the period is `to_s` instead
    /// of `from_s`: `p^(to/from)`.
    ///
    /// # Errors
    ///
    /// [`Error::Negative`] for a negative real pole; a pole outside the unit
    /// circle maps outside and is refused by the placement.
    pub fn at_period(self, from_s: T, to_s: T) -> Result<Self, Error> {
        let exponent = to_s / from_s;
        match self {
            Self::Real(p1, p2) if p1 < T::zero() || p2 < T::zero() => Err(Error::Negative),
            Self::Real(p1, p2) => Ok(Self::Real(p1.powf(exponent), p2.powf(exponent))),
            Self::Conjugate { re, im } => {
                let radius = re.hypot(im).powf(exponent);
                let (sin, cos) = (im.atan2(re) * exponent).sin_cos();
                Ok(Self::Conjugate {
                    re: radius * cos,
                    im: radius * sin,
                })
            }
        }
    }

    fn sum_and_product(self) -> Result<(T, T), Error> {
        let (radius_1, radius_2, sum, product) = match self {
            Self::Real(p1, p2) => (p1.abs(), p2.abs(), p1 + p2, p1 * p2),
            Self::Conjugate { re, im } => {
                let radius = re.hypot(im);
                (radius, radius, re + re, radius * radius)
            }
        };
        if !(radius_1.is_finite() && radius_2.is_finite()) {
            Err(Error::NotFinite)
        } else if radius_1 >= T::one() || radius_2 >= T::one() {
            Err(Error::Unstable)
        } else {
            Ok((sum, product))
        }
    }
}

/// Gain of the prediction form on the angle and on the speed.
///
/// # Errors
///
/// See [`Error`].
pub fn prediction_gain<T: Real>(a: &Matrix2<T>, poles: Poles<T>) -> Result<Vector2<T>, Error> {
    let (sum, product) = poles.sum_and_product()?;
    if !a.iter().all(ComplexField::is_finite) {
        return Err(Error::NotFinite);
    }
    if a.m12 == T::zero() {
        return Err(Error::Unobservable);
    }
    // Trace and determinant of A - L C.
    let l_angle = a.trace() - sum;
    let l_speed = a.m21 + (product - (a.m11 - l_angle) * a.m22) / a.m12;
    Ok(Vector2::new(l_angle, l_speed))
}

/// Gain of the current form on the angle and on the speed.
///
/// # Errors
///
/// See [`Error`].
pub fn current_gain<T: Real>(a: &Matrix2<T>, poles: Poles<T>) -> Result<Vector2<T>, Error> {
    let gain = prediction_gain(a, poles)?;
    to_current(a, gain)
}

/// The current-form gain with the poles of a prediction-form one.
///
/// # Errors
///
/// [`Error::NotInvertible`] if A has a pole at zero.
pub fn to_current<T: Real>(a: &Matrix2<T>, prediction: Vector2<T>) -> Result<Vector2<T>, Error> {
    let determinant = a.determinant();
    if determinant == T::zero() {
        return Err(Error::NotInvertible);
    }
    let adjugate = Matrix2::new(a.m22, -a.m12, -a.m21, a.m11);
    Ok(adjugate * prediction / determinant)
}
