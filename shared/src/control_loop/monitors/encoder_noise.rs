//! Encoder noise: learnt from samples at rest, and the longest credible run of equal counts.
//!
//! An encoder with noise that repeats one count for long has stopped: its cable or its
//! potentiometer is broken, and a loop closed over it drives the arm away. How long is
//! credible depends on the noise, which differs from servo to servo.
//!
//! # Estimate
//!
//! Half the mean square of the difference between consecutive samples, over blocks of
//! [`BLOCK`] samples during which the joint rests (von Neumann): slow motion hardly adds to
//! it. It is the variance of a sample, rounding included. A block counts as at rest if its
//! whole variance is no more than twice that. Blocks are averaged.
//!
//! # Bound
//!
//! An encoder without noise, at the edge between two counts, shows a variance of up to 1/4
//! too. So the noise itself is taken as the variance less 1/4, never more than it is, and the
//! joint as standing in the middle of a count, where a run lasts longest. A sample equals
//! the one before it with probability `p = erf(1 / sqrt(8 variance))` there; a run of `n` has
//! probability `p^n`. [`BOUNDS`] has twice the `n` at which that is 1e-12: once in 30 years at
//! 1 kHz if samples are independent, and as much again for those that are not.
//!
//! Below a variance of 0.35 count^2 no run is too long: the encoder is too quiet to tell.

use super::debounce::Debounce;

/// Samples of a block.
const BLOCK: u8 = 16;

/// Blocks after which the noise is known.
const KNOWN_BLOCKS: u8 = 8;

/// Largest number of blocks that are averaged.
const AVERAGED_BLOCKS: u8 = 32;

/// Variance in count^2 that a block at rest may have beside twice that of its differences.
const REST_VARIANCE: f32 = 0.1;

/// Longest credible run for a variance of at least so many count^2.
const BOUNDS: [(f32, u32); 5] = [(1.0, 67), (0.7, 91), (0.5, 145), (0.4, 252), (0.35, 456)];

/// Noise of one joint's encoder.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct EncoderNoise {
    block: Block,
    /// Variance of a sample in count^2, and number of blocks in it.
    variance: f32,
    blocks: u8,
    /// Follows from both: kept because each tick needs it.
    longest_run: Option<u32>,
}

/// Sums over the samples of a block, less the first of them.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Block {
    samples: u8,
    first: u16,
    last: u16,
    sum: i32,
    squares: i32,
    squared_steps: i32,
}

impl EncoderNoise {
    /// Whether enough samples at rest have been taken.
    pub(super) fn is_known(&self) -> bool {
        self.blocks >= KNOWN_BLOCKS
    }

    /// Longest credible number of consecutive equal samples; `None` while the noise is
    /// unknown, or too small.
    pub(super) fn longest_run(&self) -> Option<u32> {
        self.longest_run
    }

    /// Drops the present block: the next sample does not follow the last.
    pub(super) fn pause(&mut self) {
        if self.block.samples > 0 {
            self.block = Block::default();
        }
    }

    /// Takes a sample.
    pub(super) fn take(&mut self, counts: u16) {
        let block = &mut self.block;
        if block.samples == 0 {
            (block.first, block.last) = (counts, counts);
        }
        let difference = |from: u16| i32::from(counts) - i32::from(from);
        let (deviation, step) = (difference(block.first), difference(block.last));
        block.sum += deviation;
        block.squares += deviation * deviation;
        block.squared_steps += step * step;
        block.last = counts;
        block.samples += 1;
        if block.samples == BLOCK {
            self.end_block();
        }
    }

    fn end_block(&mut self) {
        let block = core::mem::take(&mut self.block);
        // An encoder that has stopped must not pass for one without noise.
        let has_stopped = block.squared_steps == 0 && self.longest_run().is_some();
        let (samples, steps) = (f32::from(BLOCK), f32::from(BLOCK - 1));
        let variance = block.squared_steps as f32 / (2.0 * steps);
        let sum = block.sum as f32;
        let spread = (block.squares as f32 - sum * sum / samples) / steps;
        if spread > 2.0 * variance + REST_VARIANCE || has_stopped {
            return;
        }
        self.blocks = (self.blocks + 1).min(AVERAGED_BLOCKS);
        self.variance += (variance - self.variance) / f32::from(self.blocks);
        let mut bounds = BOUNDS.iter();
        let bound = bounds.find(|(variance, _)| self.variance >= *variance);
        self.longest_run = bound.filter(|_| self.is_known()).map(|(_, run)| *run);
    }
}

/// Consecutive equal samples of one joint.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct EqualSamples {
    last: Option<u16>,
    run: Debounce,
}

impl EqualSamples {
    /// Takes a sample. Whether as many as `longest` before it were equal to it.
    pub(super) fn exceeds(&mut self, counts: u16, longest: u32) -> bool {
        let is_equal = self.last.replace(counts) == Some(counts);
        self.run.count(is_equal, longest)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Gaussian noise of this size, rounded, about `middle`: twelve uniform numbers, summed.
    fn sample(middle: f32, rms: f32, state: &mut u32) -> u16 {
        let sum: f32 = (0..12)
            .map(|_| {
                *state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                (*state >> 8) as f32 / (1 << 24) as f32
            })
            .sum();
        (middle + rms * (sum - 6.0) + 0.5) as u16
    }

    /// The encoder's noise after so many samples.
    fn learnt(middle: impl Fn(u32) -> f32, rms: f32, samples: u32) -> EncoderNoise {
        let (mut noise, mut state) = (EncoderNoise::default(), 1);
        for n in 0..samples {
            noise.take(sample(middle(n), rms, &mut state));
        }
        noise
    }

    #[test]
    fn louder_encoders_have_shorter_runs() {
        let bounds = [0.0, 0.2, 0.4, 0.6, 0.8, 1.0, 2.0]
            .map(|rms| learnt(|_| 512.0, rms, 10_000).longest_run());
        assert_eq!(
            bounds,
            [None, None, None, Some(252), Some(91), Some(67), Some(67)]
        );
        assert_eq!(learnt(|_| 512.0, 1.0, 127).longest_run(), None);
        assert!(learnt(|_| 512.0, 1.0, 128).longest_run().is_some());
    }

    /// An encoder without noise flickers at an edge, and is silent elsewhere.
    #[test]
    fn an_edge_between_two_counts_is_no_noise() {
        for rms in [0.01, 0.1, 0.2] {
            assert_eq!(learnt(|_| 512.5, rms, 10_000).longest_run(), None, "{rms}");
        }
    }

    /// Moved by hand at 1 rad/s, at 1 kHz and at 22 Hz.
    #[test]
    fn motion_is_no_noise() {
        for counts_a_sample in [0.195, 8.8] {
            let wave = |n: u32| {
                let phase = n as f32 * counts_a_sample;
                400.0 + (phase % 400.0 - 200.0).abs()
            };
            let noise = learnt(wave, 0.1, 20_000);
            assert_eq!(noise.longest_run(), None, "{counts_a_sample} {noise:?}");
        }
    }

    /// An hour at 1 kHz, and the longest run in it.
    #[test]
    fn an_encoder_that_works_is_never_too_long_at_one_count() {
        for (rms, samples) in [(0.6, 1_000_000), (1.0, 3_600_000)] {
            let noise = learnt(|_| 512.0, rms, 1_000);
            let longest = noise.longest_run().unwrap();
            let (mut equal, mut state) = (EqualSamples::default(), 7);
            let exceeds = |_| equal.exceeds(sample(512.0, rms, &mut state), longest / 2);
            assert!(!(0..samples).any(exceeds), "{rms}");
        }
    }

    #[test]
    fn one_that_stops_at_rest_keeps_its_bound() {
        let mut noise = learnt(|_| 512.0, 1.0, 1_000);
        for _ in 0..100_000 {
            noise.take(512);
        }
        assert!(
            noise.longest_run().is_some_and(|run| run <= 145),
            "{noise:?}"
        );
        let mut equal = EqualSamples::default();
        let run = (0..200).position(|_| equal.exceeds(512, 67));
        assert_eq!(run, Some(67));
    }
}
