//! Free runs: prediction of an arm's motion over up to 5 s from the PWM alone.
//!
//! A run begins with an experiment, where the board holds both joints. They do not rest
//! there: noise makes the PWM jitter, and joints slip by fractions of a count. So the model
//! is at rest 0.3 s before; errors of its initial speed decay in 0.1 s, and its position is
//! the mean of the encoders in the other 0.2 s. Noise of a count leaves an uncertainty of
//! 0.07 counts. From there on only the PWM of the log is used.
//!
//! A run lasts 5 s, or until it diverges, as four perturbed runs show: they begin a tenth of
//! a count beside it, in either direction of either joint. When one of them is a count from
//! it, in either joint, an error below the encoder's resolution has grown tenfold, and the
//! run ends. That is soon for an arm that falls from upright, or for a joint about to break
//! away, and never for one that rests. It depends on the model's motion, not on the
//! covariance of a fit.
//!
//! The error is measured less computed, root mean square of both joints, less noise and
//! rounding. It is close if it is at most a count of an AX-12A, 5.1 mrad.

use armbridge_control::encoder::Encoder;
use armbridge_link::message::{Drive, Record, Sample};
use armbridge_servo::JOINTS;

use super::model::{Model, Moving};

/// Most ticks of a run.
const TICKS: usize = 5_000;
/// Ticks before a run, and those of them whose mean is its initial position.
const BEFORE: usize = 300;
const MEAN: usize = 200;
/// Corrections of the initial position; the first leaves hundredths of a count.
const CORRECTIONS: usize = 4;
/// Perturbation of the initial position, and distance at divergence, in counts.
const PERTURBATION_COUNTS: f64 = 0.1;
const DIVERGED_COUNTS: f64 = 1.0;
/// Variance of rounding in counts squared.
const ROUNDING: f64 = 1.0 / 12.0;

/// A run, up to its divergence.
#[derive(Clone, Copy, Debug)]
pub struct FreeRun {
    /// The tick of the log in which it begins.
    begin: usize,
    ticks: usize,
    /// Sum of the squares of both joints' errors without noise, in counts of an AX-12A.
    squares: f64,
}

impl FreeRun {
    /// Root mean square in counts of an AX-12A, without the encoder's noise.
    fn rms(&self) -> f64 {
        let squares = self.squares / (JOINTS * self.ticks) as f64;
        squares.max(0.0).sqrt()
    }
}

/// Runs, together.
#[derive(Clone, Copy, Debug)]
pub struct Summary {
    /// Runs.
    pub runs: usize,
    /// Runs with an error of at most a count of an AX-12A.
    pub close: usize,
    /// Root mean square of all of their ticks, in counts of an AX-12A.
    pub rms: f64,
    /// Length in s: least, quartiles, most.
    lengths_s: [f64; 5],
}

impl Summary {
    /// Summary of these runs.
    pub fn of(runs: &[FreeRun]) -> Self {
        let all = FreeRun {
            begin: 0,
            ticks: runs.iter().map(|run| run.ticks).sum(),
            squares: runs.iter().map(|run| run.squares).sum(),
        };
        let mut ticks: Vec<usize> = runs.iter().map(|run| run.ticks).collect();
        ticks.sort_unstable();
        Self {
            runs: runs.len(),
            close: runs.iter().filter(|run| run.rms() <= 1.0).count(),
            rms: all.rms(),
            lengths_s: [0, 1, 2, 3, 4].map(|quarter| {
                let index = quarter * (ticks.len() - 1) / 4;
                ticks[index] as f64 * 1e-3
            }),
        }
    }
}

impl core::fmt::Display for Summary {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        let Self {
            runs, close, rms, ..
        } = self;
        let [least, first, half, third, most] = self.lengths_s;
        write!(
            f,
            "{close} of {runs} free runs to a count, {rms:.2} counts rms together; they last \
             {least:.1} to {most:.1} s, half of them {first:.1} to {third:.1}, median {half:.1}"
        )
    }
}

/// Free runs from the beginning of every experiment of a log, whose encoders have this noise in
/// counts; prints those that are not close.
pub fn free_runs(model: &Model, noise_counts: f64, log: &[Record]) -> Vec<FreeRun> {
    let is_one = |record: &Record| record.mode.drive() == Some(Drive::Experiment);
    let begins = (2 * BEFORE..log.len().saturating_sub(TICKS))
        .filter(|&tick| is_one(&log[tick]) && !is_one(&log[tick - 1]));
    let runs: Vec<FreeRun> = begins
        .filter_map(|begin| free_run(model, noise_counts, log, begin))
        .collect();
    for run in runs.iter().filter(|run| run.rms() > 1.0) {
        let [at_s, lasts_s] = [run.begin, run.ticks].map(|ticks| ticks as f64 * 1e-3);
        println!(
            "a free run of {lasts_s:.1} s at {at_s:.1} s is {:.2} counts off",
            run.rms()
        );
    }
    runs
}

fn measured(log: &[Record], tick: usize) -> Option<[f64; JOINTS]> {
    let [first, second] = log[tick].input.samples.map(Sample::counts);
    Some([first?.into(), second?.into()])
}

/// A free run; `None` if the log lacks a sample.
fn free_run(model: &Model, noise_counts: f64, log: &[Record], begin: usize) -> Option<FreeRun> {
    let start = start(model, log, begin)?;
    let settled = |start: [f64; JOINTS]| {
        let mut moving = model.at_rest(log, begin - BEFORE, start);
        (0..BEFORE).for_each(|_| moving.step());
        moving
    };
    let beside = |joint: usize, counts: f64| {
        let mut start = start;
        start[joint] += counts;
        settled(start)
    };
    let scale = model.rad_per_count() / Encoder::Ax12a.nominal_rad_per_count();
    let noise = noise_counts.powi(2) + ROUNDING;
    let mut moving = settled(start);
    let mut others: Vec<Moving> = (0..JOINTS)
        .flat_map(|joint| {
            [-PERTURBATION_COUNTS, PERTURBATION_COUNTS].map(|counts| beside(joint, counts))
        })
        .collect();
    let mut run = FreeRun {
        begin,
        ticks: 0,
        squares: 0.0,
    };
    while run.ticks < TICKS {
        let counts = moving.counts();
        let has_diverged = |other: &Moving| {
            let beside = other.counts();
            (0..JOINTS).any(|joint| (beside[joint] - counts[joint]).abs() >= DIVERGED_COUNTS)
        };
        if others.iter().any(has_diverged) {
            break;
        }
        let errors = measured(log, begin + run.ticks)?.into_iter().zip(counts);
        let squares = errors.map(|(is, own)| (is - own).powi(2) - noise);
        run.squares += squares.sum::<f64>() * scale.powi(2);
        run.ticks += 1;
        moving.step();
        others.iter_mut().for_each(Moving::step);
    }
    Some(run)
}

/// Initial position in counts of a model that rests [`BEFORE`] ticks before a run, fitted so
/// that its mean over the last [`MEAN`] of them is that of the encoders.
fn start(model: &Model, log: &[Record], begin: usize) -> Option<[f64; JOINTS]> {
    let first = begin - BEFORE;
    let mut start = measured(log, first)?;
    for _ in 0..CORRECTIONS {
        let mut off = [0.0; JOINTS];
        let mut moving = model.at_rest(log, first, start);
        for tick in first..begin {
            if tick >= begin - MEAN {
                let errors = measured(log, tick)?.into_iter().zip(moving.counts());
                for (off, (is, own)) in off.iter_mut().zip(errors) {
                    *off += (is - own) / MEAN as f64;
                }
            }
            moving.step();
        }
        for (start, off) in start.iter_mut().zip(off) {
            *start += off;
        }
    }
    Some(start)
}
