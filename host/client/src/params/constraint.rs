//! What a parameter takes, for checks and in words.

use core::fmt;

/// What a parameter takes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Takes {
    /// Numbers.
    Numbers {
        /// How many.
        shape: Shape,
        /// Of each.
        range: Range,
    },
    /// One of these words.
    OneOf(&'static [&'static str]),
}

/// How many numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Shape {
    /// A number.
    One,
    /// So many in a list.
    List(usize),
    /// So many lists of so many each.
    Rows(usize, usize),
}

/// Where a number must be. Every number must be finite.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Range {
    /// The least, or what is just too little.
    pub low: f64,
    /// The most, or what is just too much.
    pub high: f64,
    /// `low` itself is allowed.
    pub with_low: bool,
    /// `high` itself is allowed.
    pub with_high: bool,
    /// Nothing between two integers is.
    pub whole: bool,
}

impl Range {
    /// Every finite number.
    pub(super) const ANY: Self = Self::reals(f64::NEG_INFINITY, f64::INFINITY);
    /// 0 and more.
    pub(super) const FROM_0: Self = Self::reals(0.0, f64::INFINITY);
    /// More than 0.
    pub(super) const ABOVE_0: Self = Self::above_0_to(f64::INFINITY);
    /// 0 and more, less than 1.
    pub(super) const BELOW_1: Self = Self {
        with_high: false,
        ..Self::reals(0.0, 1.0)
    };

    /// Both ends included.
    pub(super) const fn reals(low: f64, high: f64) -> Self {
        Self {
            low,
            high,
            with_low: true,
            with_high: true,
            whole: false,
        }
    }

    /// More than 0.
    pub(super) const fn above_0_to(high: f64) -> Self {
        Self {
            with_low: false,
            ..Self::reals(0.0, high)
        }
    }

    /// Integers, both ends included.
    pub(super) const fn whole(low: u32, high: u32) -> Self {
        Self {
            whole: true,
            ..Self::reals(low as f64, high as f64)
        }
    }

    /// Whether this number, rounded as it is kept, is inside; so are the ends rounded.
    pub(super) fn contains(&self, number: f64, rounded: fn(f64) -> f64) -> bool {
        let (x, low, high) = (rounded(number), rounded(self.low), rounded(self.high));
        let above = if self.with_low { x >= low } else { x > low };
        let below = if self.with_high { x <= high } else { x < high };
        x.is_finite() && above && below && (!self.whole || number.fract() == 0.0)
    }
}

impl Shape {
    /// Of all lists together.
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
                let what = if range.whole { "integer" } else { "number" };
                match shape {
                    Shape::One if range.whole => write!(f, "an {what} {range}"),
                    Shape::One => write!(f, "a {what} {range}"),
                    Shape::List(count) => write!(f, "{count} {what}s {range}"),
                    Shape::Rows(rows, columns) => {
                        write!(f, "{rows} rows of {columns} {what}s {range}")
                    }
                }
            }
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
