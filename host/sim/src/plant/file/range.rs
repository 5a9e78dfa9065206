//! Ranges of a file's numbers, which every arm meets. They are checked while the file is
//! parsed, so that an error has its line and column.

use core::ops::RangeInclusive;

use serde::de::Error as _;
use serde::{Deserialize, Deserializer};

/// A number in a range, or an error with its name.
fn within<'de, D: Deserializer<'de>>(
    deserializer: D,
    range: RangeInclusive<f64>,
) -> Result<f64, D::Error> {
    let number = f64::deserialize(deserializer)?;
    if range.contains(&number) {
        return Ok(number);
    }
    let (low, high) = range.into_inner();
    Err(D::Error::custom(format!(
        "{number} is not a number from {low} to {high}"
    )))
}

/// Names for [`within`] these ranges, as serde wants them.
macro_rules! ranges {
    ($($name:ident $range:expr;)*) => {
        $(pub(super) fn $name<'de, D: Deserializer<'de>>(deserializer: D) -> Result<f64, D::Error> {
            within(deserializer, $range)
        })*
    };
}

ranges! {
    scale 0.1..=10.0;
    counts -500.0..=500.0;
    torque 0.0..=10.0;
    noise 0.0..=100.0;
    length 0.0..=1.0;
    mass 0.0..=10.0;
    gravity 0.0..=100.0;
    inertia 1e-5..=10.0;
    small_inertia 0.0..=1.0;
    viscous 0.0..=10.0;
    speed -100.0..=100.0;
    angle -1.5..=1.5;
    zero 0.0..=1023.0;
    angle_of_count 1e-4..=0.1;
    gain 10.0..=1e5;
    delay_us 0.0..=1e6;
    stribeck 0.0..=100.0;
}

/// A time in µs, where there is one.
pub(super) fn maybe_delay<'de, D: Deserializer<'de>>(
    deserializer: D,
) -> Result<Option<u32>, D::Error> {
    delay_us(deserializer).map(|us| Some(us as u32))
}

/// PWM counts below and above off, where there are any.
pub(super) fn maybe_dead_zone<'de, D: Deserializer<'de>>(
    deserializer: D,
) -> Result<Option<[u16; 2]>, D::Error> {
    let counts = <[u16; 2]>::deserialize(deserializer)?;
    if counts.iter().all(|&counts| counts <= 500) {
        Ok(Some(counts))
    } else {
        let message = "expected PWM counts below and above off, from 0 to 500";
        Err(D::Error::custom(message))
    }
}

/// An angle in rad, where there is one.
pub(super) fn maybe_angle<'de, D: Deserializer<'de>>(
    deserializer: D,
) -> Result<Option<f64>, D::Error> {
    angle(deserializer).map(Some)
}

/// Two angles in rad, the smaller first, where there are any.
pub(super) fn maybe_stops<'de, D: Deserializer<'de>>(
    deserializer: D,
) -> Result<Option<[f64; 2]>, D::Error> {
    let [low, high] = <[f64; 2]>::deserialize(deserializer)?;
    if -3.2 <= low && low < high && high <= 3.2 {
        Ok(Some([low, high]))
    } else {
        let message = "expected the smallest and the largest angle, from -3.2 to 3.2";
        Err(D::Error::custom(message))
    }
}
