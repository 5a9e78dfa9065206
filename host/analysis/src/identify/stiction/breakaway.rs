//! Breakaway: likelihood of each static friction from one rest that ends in sliding.
//!
//! The tick in which sliding began, the onset, follows from the motion afterwards: the
//! likelihood of each candidate is that of the residuals of this motion. Candidates are only
//! ticks in which the applied torque exceeds all before, and dry friction in motion; static
//! friction then lies between that torque and the largest before.

use core::ops::Range;

use nalgebra::SVector;
use num_dual::DualSVec64;

use super::super::arm::JointModel;
use super::super::dataset::Trace;
use super::super::motion::Motion;
use super::super::quantity::{COUNT, PER_JOINT, Quantity};
use super::StaticFrictionFit;
use super::likelihood::TorqueLikelihood;
use super::rest::Rest;

/// Ticks of a rest that give the joint's angle, before any onset.
const SETTLING_TICKS: usize = 25;
/// Standard deviations of the sum of squares beyond which a breakaway is an outlier.
const OUTLIER_SIGMAS: f64 = 3.0;

/// The likelihood from one breakaway.
pub(super) struct Breakaway {
    pub(super) likelihood: TorqueLikelihood,
    /// Gradient of the applied torque by the coordinates of all other parameters.
    pub(super) torque_gradient: SVector<f64, COUNT>,
}

/// Candidate for the tick in which sliding began.
struct Onset {
    tick: usize,
    /// Sum of the squared residuals with this onset, in counts squared.
    squares: f64,
    /// Largest applied torque before, and that of this tick, in N m.
    interval_nm: [f64; 2],
}

type Dual = DualSVec64<{ PER_JOINT + 1 }>;

impl StaticFrictionFit<'_> {
    /// The breakaway that ends a rest; `None` if the log lacks its onset or the model does not
    /// explain it.
    pub(super) fn breakaway(&self, trace: &Trace, joint: usize, rest: Rest) -> Option<Breakaway> {
        let direction = trace.states[rest.sliding][joint][1].signum();
        let onsets = self.onsets(trace, joint, &rest, direction);
        let best = onsets
            .iter()
            .min_by(|a, b| a.squares.total_cmp(&b.squares))?;
        let variance = self.noise_counts.powi(2);
        let ticks = (rest.end - rest.first - SETTLING_TICKS) as f64;
        let is_explained =
            best.squares < variance * (ticks + OUTLIER_SIGMAS * (2.0 * ticks).sqrt());
        // An onset in the first tick may have been earlier, at any torque.
        let first = &onsets[0];
        let is_early = first.interval_nm[0] == f64::NEG_INFINITY;
        let has_rested = first.squares - best.squares > variance * OUTLIER_SIGMAS.powi(2);
        if !is_explained || (is_early && !has_rested) {
            return None;
        }
        let likelihood = |squares: f64| (-0.5 * (squares - best.squares) / variance).exp();
        let candidates = onsets.iter().skip(usize::from(is_early));
        let likelihood = TorqueLikelihood::from_intervals(
            candidates.map(|onset| (onset.interval_nm, likelihood(onset.squares))),
        );
        let torque_gradient = self.torque_gradient(trace, joint, best.tick, direction);
        Some(Breakaway {
            likelihood,
            torque_gradient,
        })
    }

    /// All candidate onsets of a rest.
    fn onsets(&self, trace: &Trace, joint: usize, rest: &Rest, direction: f64) -> Vec<Onset> {
        let model = JointModel::from_coordinates(self.known, self.coordinates, joint);
        let mut position = RunningMoments::default();
        let mut largest = f64::NEG_INFINITY;
        let mut onsets = Vec::new();
        for tick in rest.first..rest.sliding {
            if tick >= rest.first + SETTLING_TICKS && position.count > 0.0 {
                let start = [model.angle(position.mean), 0.0];
                let motion = || Motion::new(model, joint, self.known, trace, start, direction);
                let torque_nm = motion().breakaway_torque(tick, direction);
                if torque_nm > largest && torque_nm < model.dry_friction(0.0) {
                    largest = torque_nm;
                } else if torque_nm > largest {
                    let sliding = squares(motion(), trace, joint, tick..rest.end);
                    onsets.push(Onset {
                        tick,
                        squares: position.squares + sliding,
                        interval_nm: [largest, torque_nm],
                    });
                    largest = torque_nm;
                }
            }
            if let Some(counts) = trace.counts[tick][joint] {
                position.add(counts.into());
            }
            if tick < rest.first + SETTLING_TICKS {
                position.squares = 0.0;
            }
        }
        onsets
    }

    /// Gradient of the torque at a tick, in the direction of sliding, by all coordinates.
    fn torque_gradient(
        &self,
        trace: &Trace,
        joint: usize,
        tick: usize,
        direction: f64,
    ) -> SVector<f64, COUNT> {
        let dual = |value: f64, index: usize| Dual::from_re(value).derivative(index);
        let link_index = Quantity::Gravity.index(1);
        let coordinates =
            core::array::from_fn(|i| dual(self.coordinates[joint * PER_JOINT + i], i));
        let link = match joint {
            0 => dual(self.coordinates[link_index], PER_JOINT),
            _ => coordinates[Quantity::Gravity as usize],
        };
        let model = JointModel::new(self.known, joint, &coordinates, link);
        let counts = trace.counts[tick][joint].map_or(0.0, f64::from);
        let start = [model.angle(Dual::from(counts)), Dual::from(0.0)];
        let mut motion = Motion::new(model, joint, self.known, trace, start, 0.0);
        let torque = motion.breakaway_torque(tick, direction);
        let mut torque_gradient = SVector::zeros();
        for (derivative, value) in torque.eps.0.iter().flat_map(|eps| eps.iter().enumerate()) {
            let index = if derivative == PER_JOINT {
                link_index
            } else {
                joint * PER_JOINT + derivative
            };
            torque_gradient[index] += value;
        }
        torque_gradient
    }
}

/// Sum of the squared residuals of a motion in these ticks, in counts squared.
fn squares(mut motion: Motion<'_, f64>, trace: &Trace, joint: usize, ticks: Range<usize>) -> f64 {
    let mut squares = 0.0;
    for tick in ticks {
        if let Some(counts) = trace.counts[tick][joint] {
            squares += (f64::from(counts) - motion.position()).powi(2);
        }
        motion.step(tick);
    }
    squares
}

/// Running mean of an encoder's counts, and sum of squares about it.
#[derive(Default)]
struct RunningMoments {
    count: f64,
    mean: f64,
    squares: f64,
}

impl RunningMoments {
    fn add(&mut self, value: f64) {
        self.count += 1.0;
        let off = value - self.mean;
        self.mean += off / self.count;
        self.squares += off * (value - self.mean);
    }
}
