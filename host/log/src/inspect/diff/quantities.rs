//! Differences of each quantity, tick by tick.

use armbridge_link::message::Record;

use super::QuantityDiff;
use crate::export::column::{QUANTITIES, Quantity, Values};

/// Columns that are compared.
pub(super) fn columns() -> impl Iterator<Item = (&'static Quantity, usize)> {
    let is_compared = |quantity: &&Quantity| match quantity.values {
        Values::F64(_) | Values::U32(_) | Values::Truth(_) => false,
        Values::F32(_) | Values::U16(_) | Values::Sample(_) | Values::Word(..) => true,
    };
    let compared = QUANTITIES.iter().filter(is_compared);
    compared.flat_map(|quantity| (0..quantity.columns.len()).map(move |joint| (quantity, joint)))
}

/// A quantity's differences so far.
pub(super) struct Sum {
    pub(super) column: &'static str,
    unit: &'static str,
    values: Values,
    joint: usize,
    max: f64,
    squares: f64,
    pub(super) differing: usize,
}

impl Sum {
    pub(super) fn new((quantity, joint): (&'static Quantity, usize)) -> Self {
        Self {
            column: quantity.columns[joint],
            unit: quantity.unit,
            values: quantity.values,
            joint,
            max: 0.0,
            squares: 0.0,
            differing: 0,
        }
    }

    /// Adds a tick; returns whether it differs.
    pub(super) fn add(&mut self, a: &Record, b: &Record) -> bool {
        let joint = self.joint;
        let (is_same, difference) = match self.values {
            Values::F32(get) => {
                let (a, b) = (get(a, joint), get(b, joint));
                (a.to_bits() == b.to_bits(), f64::from(b) - f64::from(a))
            }
            Values::U16(get) => {
                let (a, b) = (get(a, joint), get(b, joint));
                (a == b, f64::from(b) - f64::from(a))
            }
            Values::Sample(get) => {
                let (a, b) = (get(a, joint), get(b, joint));
                // A missing sample differs, but adds nothing to the sums.
                let difference = a.zip(b).map_or(0.0, |(a, b)| f64::from(b) - f64::from(a));
                (a == b, difference)
            }
            Values::Word(_, get) => (get(a, joint) == get(b, joint), 0.0),
            Values::F64(_) | Values::U32(_) | Values::Truth(_) => (true, 0.0),
        };
        if !is_same {
            self.differing += 1;
            self.max = self.max.max(difference.abs());
            self.squares += difference * difference;
        }
        !is_same
    }

    pub(super) fn diff(&self, ticks: usize) -> QuantityDiff {
        let is_word = matches!(self.values, Values::Word(..));
        QuantityDiff {
            column: self.column,
            unit: self.unit,
            max: (!is_word).then_some(self.max),
            rms: (!is_word).then(|| (self.squares / ticks as f64).sqrt()),
            ticks: self.differing,
        }
    }
}
