//! A joint that gave way: how likely it makes each static friction.
//!
//! When the joint began to slide follows from the motion afterwards: each tick in which it may
//! have begun is as likely as the encoder's noise lets its motion be. Only ticks in which
//! it is pushed harder than ever before, and harder than a sliding joint's dry friction,
//! come into question, and static friction lies between that push and the hardest before.

use core::ops::Range;

use nalgebra::SVector;
use num_dual::DualSVec64;

use super::super::arm::Joint;
use super::super::dataset::Trace;
use super::super::motion::Motion;
use super::super::quantity::{COUNT, PER_JOINT, Quantity};
use super::Stiction;
use super::posterior::Belief;
use super::rest::Rest;

/// Ticks of a rest by which the joint's angle is known before it may begin to slide.
const SETTLED: usize = 25;
/// Standard deviations by which a rest and what follows may be off.
const ODD: f64 = 3.0;

/// The likelihood from one breakaway.
pub(super) struct Event {
    pub(super) belief: Belief,
    /// How the push depends on the coordinates of all other numbers.
    pub(super) slope: SVector<f64, COUNT>,
}

/// A tick in which the joint may have begun to slide.
struct Beginning {
    tick: usize,
    /// Sum of all errors' squares if it did, in counts squared.
    squares: f64,
    /// The hardest push before, and the push in this tick, in N m.
    pushes_nm: [f64; 2],
}

type Dual = DualSVec64<{ PER_JOINT + 1 }>;

impl Stiction<'_> {
    /// The likelihood from a rest's end; `None` if its beginning was missed or the model does not
    /// explain it.
    pub(super) fn event(&self, trace: &Trace, joint: usize, rest: Rest) -> Option<Event> {
        let way = trace.smooth[rest.slides][joint][1].signum();
        let beginnings = self.beginnings(trace, joint, &rest, way);
        let best = beginnings
            .iter()
            .min_by(|a, b| a.squares.total_cmp(&b.squares))?;
        let variance = self.noise_counts.powi(2);
        let ticks = (rest.end - rest.first - SETTLED) as f64;
        let is_explained = best.squares < variance * (ticks + ODD * (2.0 * ticks).sqrt());
        // What may have slid from the first tick on may have begun before, at any push.
        let first = &beginnings[0];
        let is_early = first.pushes_nm[0] == f64::NEG_INFINITY;
        let has_rested = first.squares - best.squares > variance * ODD.powi(2);
        if !is_explained || (is_early && !has_rested) {
            return None;
        }
        let likelihood = |squares: f64| (-0.5 * (squares - best.squares) / variance).exp();
        let later = beginnings.iter().skip(usize::from(is_early));
        let belief = Belief::of(later.map(|of| (of.pushes_nm, likelihood(of.squares))));
        let slope = self.slope(trace, joint, best.tick, way);
        Some(Event { belief, slope })
    }

    /// All ticks in which it may begin to slide.
    fn beginnings(&self, trace: &Trace, joint: usize, rest: &Rest, way: f64) -> Vec<Beginning> {
        let model = Joint::of(self.known, self.at, joint);
        let mut position = Resting::default();
        let mut hardest = f64::NEG_INFINITY;
        let mut beginnings = Vec::new();
        for tick in rest.first..rest.slides {
            if tick >= rest.first + SETTLED && position.count > 0.0 {
                let start = [model.angle(position.mean), 0.0];
                let motion = || Motion::new(model, joint, self.known, trace, start, way);
                let push = motion().push(tick) * way;
                if push > hardest && push < model.dry(0.0) {
                    hardest = push;
                } else if push > hardest {
                    let sliding = squares(motion(), trace, joint, tick..rest.end);
                    beginnings.push(Beginning {
                        tick,
                        squares: position.squares + sliding,
                        pushes_nm: [hardest, push],
                    });
                    hardest = push;
                }
            }
            if let Some(counts) = trace.counts[tick][joint] {
                position.add(counts.into());
            }
            if tick < rest.first + SETTLED {
                position.squares = 0.0;
            }
        }
        beginnings
    }

    /// How the push at a tick depends on all coordinates.
    fn slope(&self, trace: &Trace, joint: usize, tick: usize, way: f64) -> SVector<f64, COUNT> {
        let lane = |value: f64, index: usize| Dual::from_re(value).derivative(index);
        let link_at = Quantity::Gravity.at(1);
        let coordinates = core::array::from_fn(|i| lane(self.at[joint * PER_JOINT + i], i));
        let link = match joint {
            0 => lane(self.at[link_at], PER_JOINT),
            _ => coordinates[Quantity::Gravity as usize],
        };
        let model = Joint::new(self.known, joint, &coordinates, link);
        let counts = trace.counts[tick][joint].map_or(0.0, f64::from);
        let start = [model.angle(Dual::from(counts)), Dual::from(0.0)];
        let push = Motion::new(model, joint, self.known, trace, start, 0.0).push(tick);
        let mut slope = SVector::zeros();
        for (lane, value) in push.eps.0.iter().flat_map(|eps| eps.iter().enumerate()) {
            let place = if lane == PER_JOINT {
                link_at
            } else {
                joint * PER_JOINT + lane
            };
            slope[place] += value * way;
        }
        slope
    }
}

/// Sum of the squares of a motion's errors in these ticks, in counts squared.
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

/// Where a joint rests: mean, and sum of squares about it, of its encoder's counts.
#[derive(Default)]
struct Resting {
    count: f64,
    mean: f64,
    squares: f64,
}

impl Resting {
    fn add(&mut self, value: f64) {
        self.count += 1.0;
        let off = value - self.mean;
        self.mean += off / self.count;
        self.squares += off * (value - self.mean);
    }
}
