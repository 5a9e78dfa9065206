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
//! whole variance is no more than twice that. Blocks are averaged. The noise is known after
//! [`KNOWN_BLOCKS`], before which the board does not arm, and goes on being learnt until it is
//! settled, after [`SETTLED_BLOCKS`]: until then only part of the variance counts
//! ([`UNSETTLED_SHARE`]).
//!
//! # Bound
//!
//! An encoder without noise, at the edge between two counts, shows a variance of up to 1/4
//! too. So the noise itself is taken as the variance less 1/4, never more than it is, and the
//! joint as standing in the middle of a count, where a run lasts longest. A sample equals
//! the one before it with probability `p = erf(1 / sqrt(8 variance))` there; a run of `n` has
//! probability `p^n`. [`LEVELS`] has the `n` at which that is 1e-12: once in 30 years at
//! 1 kHz if samples are independent. Noise that a servo's filter correlates for up to
//! [`CORRELATED_US`] makes runs longer by as many samples as are in that time.
//!
//! Below a variance of 0.35 count^2 no run is too long: the encoder is too quiet to tell, and
//! proves itself by [a small motion](super::encoder_proof).

use armbridge_control::check_word::checked;

/// Samples of a block.
const BLOCK: u8 = 16;

/// Blocks after which the noise is known.
const KNOWN_BLOCKS: u8 = 3;

/// Blocks after which it is settled.
const SETTLED_BLOCKS: u8 = 8;

/// Share of the variance that counts until then. An encoder without noise that flickers between
/// two counts, even with each sample, stays below the least of [`LEVELS`].
const UNSETTLED_SHARE: f32 = 0.69;

/// Largest number of blocks that are averaged.
const AVERAGED_BLOCKS: u8 = 32;

/// Variance in count^2 that a block at rest may have beside twice that of its differences.
const REST_VARIANCE: f32 = 0.1;

/// Longest credible run of independent samples for a variance of at least so many count^2.
const LEVELS: [(f32, f32); 5] = [
    (1.0, 33.3),
    (0.7, 45.4),
    (0.5, 72.4),
    (0.4, 125.9),
    (0.35, 227.7),
];

/// Time in µs over which noise may be correlated.
const CORRELATED_US: f32 = 1_000.0;

/// Noise of one joint's encoder.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "snapshot", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct EncoderNoise {
    block: Block,
    /// Variance of a sample in count^2, and number of blocks in it.
    variance: f32,
    blocks: u8,
    /// Index of [`LEVELS`], which follows from both: kept because each tick needs it.
    level: Option<u8>,
}

/// Sums over the samples of a block, less the first of them.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "snapshot", derive(serde::Serialize, serde::Deserialize))]
struct Block {
    samples: u8,
    first: u16,
    last: u16,
    sum: i32,
    squares: i32,
    squared_steps: i32,
}

impl EncoderNoise {
    /// Whether enough samples at rest have been taken to arm.
    pub(super) fn is_known(&self) -> bool {
        self.blocks >= KNOWN_BLOCKS
    }

    /// Variance of a sample in count^2, rounding included.
    pub(super) fn variance(&self) -> f32 {
        self.variance
    }

    /// Whether enough have been taken for a whole estimate.
    pub(super) fn is_settled(&self) -> bool {
        self.blocks >= SETTLED_BLOCKS
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
        let has_stopped = block.squared_steps == 0 && level(self.variance).is_some();
        let (samples, steps) = (f32::from(BLOCK), f32::from(BLOCK - 1));
        let variance = block.squared_steps as f32 / (2.0 * steps);
        let sum = block.sum as f32;
        let spread = (block.squares as f32 - sum * sum / samples) / steps;
        if spread > 2.0 * variance + REST_VARIANCE || has_stopped {
            return;
        }
        self.blocks = (self.blocks + 1).min(AVERAGED_BLOCKS);
        self.variance += (variance - self.variance) / f32::from(self.blocks);
        self.level = match self.blocks {
            0..KNOWN_BLOCKS => None,
            KNOWN_BLOCKS..SETTLED_BLOCKS => level(self.variance * UNSETTLED_SHARE),
            SETTLED_BLOCKS.. => level(self.variance),
        };
    }
}

/// Index of [`LEVELS`] for this variance; `None` if it is too small.
fn level(variance: f32) -> Option<u8> {
    let mut levels = (0..).zip(LEVELS);
    let level = levels.find(|(_, (least, _))| variance >= *least);
    level.map(|(index, _)| index)
}

/// Longest credible runs at one period, in ticks.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct RunConfig {
    /// For each of [`LEVELS`].
    longest: [u32; LEVELS.len()],
}

checked!(RunConfig { longest });

impl RunConfig {
    pub(super) fn new(period_us: u32) -> Self {
        let correlated = 1.0 + (CORRELATED_US / period_us as f32).min(1.0);
        Self {
            longest: LEVELS.map(|(_, run)| (run * correlated) as u32 + 1),
        }
    }

    /// Longest credible run of an encoder with this noise; `None` where none is too long.
    pub(super) fn longest(&self, noise: &EncoderNoise) -> Option<u32> {
        let level = usize::from(noise.level?);
        self.longest.get(level).copied()
    }
}

#[cfg(test)]
mod tests {
    use super::super::debounce::Debounce;
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

    /// Longest credible run at this period in µs, in ticks.
    fn longest_run(noise: &EncoderNoise, period_us: u32) -> Option<u32> {
        RunConfig::new(period_us).longest(noise)
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
            .map(|rms| longest_run(&learnt(|_| 512.0, rms, 10_000), 1_000));
        assert_eq!(
            bounds,
            [None, None, None, Some(252), Some(91), Some(67), Some(67)]
        );
        let noise = learnt(|_| 512.0, 1.0, 10_000);
        let runs = [1_000, 2_000, 10_000, 45_000].map(|period_us| longest_run(&noise, period_us));
        assert_eq!(runs, [67, 50, 37, 35].map(Some));
    }

    /// 47 samples are too few to arm, 48 give a first bound, and 128 the whole estimate.
    #[test]
    fn noise_is_known_after_48_samples() {
        let early = [47, 48, 128].map(|samples| {
            let noise = learnt(|_| 512.0, 1.0, samples);
            (
                noise.is_known(),
                noise.is_settled(),
                longest_run(&noise, 1_000),
            )
        });
        let expected = [
            (false, false, None),
            (true, false, Some(145)),
            (true, true, Some(67)),
        ];
        assert_eq!(early, expected);
        // One without noise flickers as much as it can.
        let flicker = |n: u32| 512.0 + (n % 2) as f32;
        let noise = learnt(flicker, 0.01, 48);
        assert_eq!((noise.is_known(), longest_run(&noise, 1_000)), (true, None));
    }

    /// An encoder without noise flickers at an edge, and is silent elsewhere.
    #[test]
    fn an_edge_between_two_counts_is_no_noise() {
        for rms in [0.01, 0.1, 0.2] {
            let noise = learnt(|_| 512.5, rms, 10_000);
            assert_eq!(longest_run(&noise, 1_000), None, "{rms}");
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
            let longest = longest_run(&noise, 1_000);
            assert_eq!(longest, None, "{counts_a_sample} {noise:?}");
        }
    }

    /// An hour at 1 kHz, and the longest run in it.
    #[test]
    fn an_encoder_that_works_is_never_too_long_at_one_count() {
        for (rms, samples) in [(0.6, 1_000_000), (1.0, 3_600_000)] {
            let noise = learnt(|_| 512.0, rms, 1_000);
            let longest = longest_run(&noise, 1_000).unwrap();
            let (mut run, mut last, mut state) = (Debounce::default(), 0, 7);
            let is_half = |_| {
                let counts = sample(512.0, rms, &mut state);
                run.count(core::mem::replace(&mut last, counts) == counts, longest / 2)
            };
            assert!(!(0..samples).any(is_half), "{rms}");
        }
    }

    #[test]
    fn one_that_stops_at_rest_keeps_its_bound() {
        let mut noise = learnt(|_| 512.0, 1.0, 1_000);
        for _ in 0..100_000 {
            noise.take(512);
        }
        assert_eq!(longest_run(&noise, 1_000), Some(67), "{noise:?}");
        // Nor is one known that stopped before it was.
        let mut noise = learnt(|_| 512.0, 1.0, 16);
        for _ in 0..100_000 {
            noise.take(512);
        }
        assert!(!noise.is_known());
    }
}
