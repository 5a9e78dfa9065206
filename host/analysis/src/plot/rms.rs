//! Root mean square of a value of each joint, tick by tick.

use armbridge_servo::JOINTS;

/// Sums of squares of the values so far that are finite.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Rms {
    squares: [f64; JOINTS],
    counts: [u64; JOINTS],
}

impl Rms {
    pub(super) fn add(&mut self, values: [f64; JOINTS]) {
        for (joint, value) in values.into_iter().enumerate() {
            if value.is_finite() {
                self.squares[joint] += value * value;
                self.counts[joint] += 1;
            }
        }
    }

    /// Root mean square of each joint; zero without a value.
    pub(super) fn values(&self) -> [f64; JOINTS] {
        let rms = |joint: usize| (self.squares[joint] / self.counts[joint].max(1) as f64).sqrt();
        std::array::from_fn(rms)
    }
}
