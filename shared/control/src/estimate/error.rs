//! Reason why an estimator cannot be built.

use crate::design::placement;
use crate::design::stability::Eigenvalue;

/// Reason why an estimator cannot be built.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Error<T> {
    /// The period is not positive, or not finite.
    Period,
    /// The filter's time constant is negative, or not finite.
    Filter,
    /// The filter's tuning is not finite, or beyond all reason.
    Noise,
    /// The observer's poles cannot be placed.
    Placement(placement::Error),
    /// The observer's error would not decay: its largest eigenvalue.
    Unstable(Eigenvalue<T>),
}
