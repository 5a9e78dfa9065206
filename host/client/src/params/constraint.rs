//! Permitted values of a parameter, for checks and as text.

use core::fmt;

/// Permitted values of a parameter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Takes {
    /// Numbers.
    Numbers {
        /// Count.
        shape: Shape,
        /// Range of each.
        range: Range,
    },
    /// One of these names.
    OneOf(&'static [&'static str]),
    /// Two poles of each joint's observer.
    Poles,
}

/// Count of numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Shape {
    /// A number.
    One,
    /// A list of this length.
    List(usize),
    /// Rows, and the length of each.
    Rows(usize, usize),
}

/// Range of a number. Every number must be finite.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Range {
    /// The smallest number, or the bound that it must exceed.
    pub low: f64,
    /// The largest number, or the bound that it must stay below.
    pub high: f64,
    /// `low` itself is permitted.
    pub with_low: bool,
    /// `high` itself is permitted.
    pub with_high: bool,
    /// Only integers are permitted.
    pub whole: bool,
}

impl Range {
    /// Every finite number.
    pub const ANY: Self = Self::reals(f64::NEG_INFINITY, f64::INFINITY);
    /// 0 and more.
    pub const FROM_0: Self = Self::reals(0.0, f64::INFINITY);
    /// More than 0.
    pub const ABOVE_0: Self = Self::above_0_to(f64::INFINITY);

    /// Both ends included.
    pub const fn reals(low: f64, high: f64) -> Self {
        Self {
            low,
            high,
            with_low: true,
            with_high: true,
            whole: false,
        }
    }

    /// More than 0.
    pub const fn above_0_to(high: f64) -> Self {
        Self {
            with_low: false,
            ..Self::reals(0.0, high)
        }
    }

    /// Integers, both ends included.
    pub const fn whole(low: u32, high: u32) -> Self {
        Self {
            whole: true,
            ..Self::reals(low as f64, high as f64)
        }
    }

    /// Whether this number, rounded as it is stored, is inside the equally rounded bounds.
    pub(crate) fn contains(&self, number: f64, rounded: fn(f64) -> f64) -> bool {
        let (x, low, high) = (rounded(number), rounded(self.low), rounded(self.high));
        let above = if self.with_low { x >= low } else { x > low };
        let below = if self.with_high { x <= high } else { x < high };
        x.is_finite() && above && below && (!self.whole || number.fract() == 0.0)
    }
}

impl Shape {
    /// Count of all numbers.
    pub fn count(self) -> usize {
        match self {
            Self::One => 1,
            Self::List(count) => count,
            Self::Rows(rows, columns) => rows * columns,
        }
    }
}

impl fmt::Display for Range {
    /// As `from 0 to 1023`.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match (self.low.is_finite(), self.high.is_finite()) {
            (false, false) => return f.write_str("finite"),
            (true, _) if self.with_low => write!(f, "from {}", self.low)?,
            (true, _) => write!(f, "above {}", self.low)?,
            (false, true) => {}
        }
        match (self.high.is_finite(), self.with_high) {
            (true, true) => write!(f, " to {}", self.high),
            (true, false) => write!(f, " and below {}", self.high),
            (false, _) => f.write_str(" up"),
        }
    }
}

impl fmt::Display for Takes {
    /// As `2 numbers above 0 to 1.5`.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Numbers { shape, range } => {
                let noun = if range.whole { "integer" } else { "number" };
                match shape {
                    Shape::One if range.whole => write!(f, "an {noun} {range}"),
                    Shape::One => write!(f, "a {noun} {range}"),
                    Shape::List(count) => write!(f, "{count} {noun}s {range}"),
                    Shape::Rows(rows, columns) => {
                        write!(f, "{rows} rows of {columns} {noun}s {range}")
                    }
                }
            }
            Self::Poles => f.write_str(
                "2 poles for each joint: numbers from 0 and below 1, or a pair as 0.6±0.2i with \
                 a magnitude below 1",
            ),
            Self::OneOf(words) => {
                let words: Vec<String> = words.iter().map(|word| format!("\"{word}\"")).collect();
                match words.split_last() {
                    Some((last, rest)) if !rest.is_empty() => {
                        write!(f, "{} or {last}", rest.join(", "))
                    }
                    Some(_) | None => f.write_str(&words.concat()),
                }
            }
        }
    }
}
