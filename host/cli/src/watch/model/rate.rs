//! Rate of an event.

/// Parts of the second that is looked at.
const PARTS: usize = 10;
const PART_NS: u64 = 1_000_000_000 / PARTS as u64;

/// Counts of the last second.
#[derive(Clone, Debug, Default)]
pub(super) struct Rate {
    counts: [u32; PARTS],
    /// Number of the latest part, since time began.
    part: u64,
    /// Parts that have been looked at, the latest included.
    age: u64,
}

impl Rate {
    /// Counts an event.
    pub(super) fn note(&mut self, now_ns: u64) {
        self.turn_to(now_ns / PART_NS);
        self.counts[self.part as usize % PARTS] += 1;
    }

    /// Events per second, over the second before the unfinished part.
    pub(super) fn per_s(&self, now_ns: u64) -> f64 {
        let part = now_ns / PART_NS;
        let oldest = (part + 1).saturating_sub(PARTS as u64);
        let begun = (self.part + 1).saturating_sub(self.age);
        let looked_at = oldest.max(begun)..part.min(self.part + 1);
        let count: u32 = looked_at
            .clone()
            .map(|part| self.counts[part as usize % PARTS])
            .sum();
        let over = part.saturating_sub(oldest.max(begun));
        if over == 0 {
            return 0.0;
        }
        f64::from(count) * PARTS as f64 / over as f64
    }

    fn turn_to(&mut self, part: u64) {
        let passed = part.saturating_sub(self.part);
        if self.age == 0 || passed >= PARTS as u64 {
            (self.counts, self.age) = ([0; PARTS], 1);
        } else {
            for passed in 1..=passed {
                self.counts[(self.part + passed) as usize % PARTS] = 0;
            }
            self.age += passed;
        }
        // Time that goes back is taken for standing still.
        self.part = if self.age == 1 {
            part
        } else {
            self.part.max(part)
        };
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_steady_rate_is_told_and_its_end_too() {
        let mut rate = Rate::default();
        let begin_ns = 1_700_000_000_000_000_000;
        for tick in 0..3_000 {
            rate.note(begin_ns + tick * 1_000_000);
        }
        let end_ns = begin_ns + 3_000_000_000;
        assert!((rate.per_s(end_ns) - 1_000.0).abs() < 1.0, "{rate:?}");
        assert!((rate.per_s(end_ns + 500_000_000) - 444.0).abs() < 60.0);
        assert!(rate.per_s(end_ns + 2_000_000_000).abs() < 1e-9);
        // After a break it counts the frames since.
        for tick in 0..400 {
            rate.note(end_ns + 5_000_000_000 + tick * 2_000_000);
        }
        let measured = rate.per_s(end_ns + 5_800_000_000);
        assert!((measured - 500.0).abs() < 1.0, "{measured}");
    }
}
