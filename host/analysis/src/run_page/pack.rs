//! Numbers of the page's data: 16-bit integers, or 32-bit floating point for times, in base64.
//!
//! A value is `min + step * n` with n from 0 to 65534; 65535 is none. Over the range of an
//! angle that is finer than a hundredth of an encoder count.

use serde::Serialize;

/// Code of a missing value.
const NONE: u16 = u16::MAX;

/// Times of rows, in s.
#[derive(Debug, Serialize)]
#[serde(untagged)]
pub(super) enum Times {
    /// Equally spaced.
    Even { from: f64, step: f64, count: usize },
    /// Single precision, little-endian, in base64.
    Single { f32: String },
}

/// A quantity in each row.
#[derive(Debug, Serialize)]
pub(super) struct Series {
    min: f64,
    step: f64,
    /// Lowest values, little-endian, in base64.
    low: String,
    /// Highest values; none if they are the lowest.
    #[serde(skip_serializing_if = "Option::is_none")]
    high: Option<String>,
}

/// Largest difference in s of times that count as equally spaced.
const EVEN_S: f64 = 2e-6;

impl Times {
    pub(super) fn of(times_s: &[f64]) -> Self {
        if let [from, .., last] = *times_s {
            let step = (last - from) / (times_s.len() - 1) as f64;
            let is_even =
                |(row, time): (usize, &f64)| (from + step * row as f64 - time).abs() < EVEN_S;
            if times_s.iter().enumerate().all(is_even) {
                let count = times_s.len();
                return Self::Even { from, step, count };
            }
        }
        let bytes: Vec<u8> = (times_s.iter())
            .flat_map(|time| (*time as f32).to_le_bytes())
            .collect();
        Self::Single {
            f32: base64(&bytes),
        }
    }
}

impl Series {
    /// `None` if there is no value at all.
    pub(super) fn of(values: &(impl Iterator<Item = [f32; 2]> + Clone)) -> Option<Self> {
        let (mut min, mut max, mut is_single) = (f32::INFINITY, f32::NEG_INFINITY, true);
        for [low, high] in values.clone() {
            if low.is_finite() && high.is_finite() {
                (min, max) = (min.min(low), max.max(high));
                is_single &= low.to_bits() == high.to_bits();
            }
        }
        if min > max {
            return None;
        }
        let min = f64::from(min);
        let step = (f64::from(max) - min) / f64::from(NONE - 1);
        let code = |value: f32| {
            if !value.is_finite() {
                NONE
            } else if step > 0.0 {
                // From 0 to 65534 by the choice of the step.
                ((f64::from(value) - min) / step).round() as u16
            } else {
                0
            }
        };
        let packed = |end: usize| {
            let bytes: Vec<u8> = (values.clone())
                .flat_map(|value| code(value[end]).to_le_bytes())
                .collect();
            base64(&bytes)
        };
        Some(Self {
            min,
            step,
            low: packed(0),
            high: (!is_single).then(|| packed(1)),
        })
    }

    /// Whether all values are zero.
    pub(super) fn is_zero(&self) -> bool {
        self.min == 0.0 && self.step == 0.0
    }
}

/// Base64 with padding, RFC 4648.
fn base64(bytes: &[u8]) -> String {
    const DIGITS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let mut text = String::with_capacity(bytes.len().div_ceil(3) * 4);
    for group in bytes.chunks(3) {
        let byte = |index: usize| u32::from(group.get(index).copied().unwrap_or(0));
        let bits = byte(0) << 16 | byte(1) << 8 | byte(2);
        for digit in 0..4 {
            if digit <= group.len() {
                let value = bits >> (18 - 6 * digit) & 0x3f;
                text.push(char::from(DIGITS[value as usize]));
            } else {
                text.push('=');
            }
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn base64_is_that_of_the_rfc() {
        for (bytes, text) in [
            (&b""[..], ""),
            (b"f", "Zg=="),
            (b"fo", "Zm8="),
            (b"foo", "Zm9v"),
            (b"foobar", "Zm9vYmFy"),
            (b"\xff\xfe\x00\x80", "//4AgA=="),
        ] {
            assert_eq!(base64(bytes), text);
        }
    }

    #[test]
    fn values_keep_their_ends_and_gaps() {
        let values = [[-1.0, -1.0], [f32::NAN, f32::NAN], [0.25, 3.0]];
        let series = Series::of(&values.into_iter()).unwrap();
        assert!((series.min + 1.0).abs() < 1e-9);
        assert!((series.step * 65_534.0 - 4.0).abs() < 1e-9);
        // -1, none and 0.25 are 0, 65535 and 20479.
        assert_eq!(series.low, base64(&[0, 0, 255, 255, 255, 79]));
        assert!(series.high.is_some());
        assert!(Series::of(&[[f32::NAN; 2]].into_iter()).is_none());
        let level = Series::of(&[[2.0; 2]; 3].into_iter()).unwrap();
        assert!(level.high.is_none() && level.low == "AAAAAAAA");
    }

    #[test]
    fn times_that_are_even_take_no_space() {
        let even: Vec<f64> = (0..1000).map(|tick| f64::from(tick) * 1e-3 - 0.3).collect();
        assert!(matches!(Times::of(&even), Times::Even { count: 1000, .. }));
        assert!(matches!(Times::of(&[0.0, 1.0, 3.0]), Times::Single { .. }));
        assert!(matches!(Times::of(&[]), Times::Single { .. }));
    }
}
