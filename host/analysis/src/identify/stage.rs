//! A round of the search: windows of one length, and the dead zones tried in them.
//!
//! Where a dead zone ends does not show in the slope: one of nothing looks much like one
//! that reaches as far beyond the motor's true zero as before it, for what it takes away is
//! none on average, and no slope leads from the one to the other. So each edge is tried
//! from several places. Where there is no dead zone, nothing pulls an edge anywhere: how
//! far off one would be seen is tried as well.

use armbridge_shared::JOINTS;

use super::arm::Known;
use super::cost::Stretch;
use super::dataset::Trace;
use super::quantity::{COUNT, PER_JOINT, Quantity};
use super::search::{Prior, Search};

/// Loss by which a dead zone must be better to be believed in place of a smaller one:
/// three standard deviations.
const NO_WORSE: f64 = 9.0;
/// An edge so far on the wrong side of off that there is no dead zone.
const NONE_COUNTS: f64 = -2.0;
/// Edges of a dead zone that are tried, in counts: up to the paper's.
const TRIED_COUNTS: [f64; 4] = [NONE_COUNTS, 15.0, 30.0, 50.0];
/// Edges of which the first that explains the logs worse than none would have been seen.
const SEEN_COUNTS: [f64; 6] = [1.0, 2.0, 4.0, 8.0, 16.0, 32.0];
/// So many standard deviations is that: the square root of [`NO_WORSE`].
const SEEN_ERRORS: f64 = 3.0;

/// What the searches of a round share.
pub(super) struct Round<'a> {
    /// Smoothed.
    pub(super) traces: &'a [Trace],
    pub(super) known: &'a Known,
    pub(super) prior: &'a Prior,
    /// Variance of an error, and a window's mean square beyond which it counts less, in
    /// counts squared.
    pub(super) judged: [f64; 2],
    pub(super) stretches: Vec<Stretch>,
}

/// What was come to with dead zones.
pub(super) struct Tried {
    pub(super) at: [f64; COUNT],
    /// How far off each edge may be because another explains the logs as well.
    pub(super) doubt: [f64; COUNT],
}

impl<'a> Round<'a> {
    /// Windows of both joints, none longer than this.
    pub(super) fn stretches(traces: &[Trace], len: usize) -> Vec<Stretch> {
        let mut stretches = Vec::new();
        for joint in 0..JOINTS {
            for (index, trace) in traces.iter().enumerate() {
                let windows = trace.windows(index, joint, len).into_iter();
                stretches.extend(windows.map(|window| Stretch::new(window, trace)));
            }
        }
        stretches
    }

    /// Begins in all windows.
    pub(super) fn begin(&self, at: [f64; COUNT]) -> Search<'a> {
        self.begin_in(self.stretches.clone(), at)
    }

    pub(super) fn begin_in(&self, stretches: Vec<Stretch>, at: [f64; COUNT]) -> Search<'a> {
        let Self {
            traces,
            known,
            prior,
            judged,
            ..
        } = self;
        Search::begin(stretches, traces, known, prior, at, *judged)
    }

    /// Tries each edge of a dead zone from several places, in windows of its own joint: the
    /// other's motions say nothing of it.
    pub(super) fn try_dead_zones(&self, mut at: [f64; COUNT]) -> Tried {
        let mut doubt = [0.0; COUNT];
        for edge in Quantity::edges() {
            let joint = edge / PER_JOINT;
            let own = self.stretches.iter().filter(|s| s.window.joint == joint);
            let own: Vec<Stretch> = own.cloned().collect();
            let from = |counts: Option<f64>| {
                let mut at = at;
                at[edge] = counts.map_or(at[edge], |counts| Quantity::DeadAbove.coordinate(counts));
                self.begin_in(own.clone(), at).try_once()
            };
            let mut searches = vec![from(None)];
            searches.extend(TRIED_COUNTS.map(|counts| from(Some(counts))));
            let (best, doubtful) = simplest(edge, searches);
            doubt[edge] = doubtful;
            let numbers = joint * PER_JOINT..(joint + 1) * PER_JOINT;
            at[numbers.clone()].copy_from_slice(&best[numbers]);
        }
        Tried { at, doubt }
    }

    /// How well it is known that there is no edge here: a standard deviation of its
    /// coordinate; `None` if none would have been seen.
    pub(super) fn seen(&self, search: &Search<'_>, edge: usize) -> Option<f64> {
        let most = search.loss() + NO_WORSE;
        let is_seen = |counts: &f64| {
            let mut at = search.at();
            at[edge] = Quantity::DeadAbove.coordinate(*counts);
            self.begin(at).loss() > most
        };
        let counts = SEEN_COUNTS.into_iter().find(is_seen)?;
        Some(Quantity::DeadAbove.coordinate(counts) / SEEN_ERRORS)
    }
}

/// Of searches that differ in this edge of a dead zone, where the one with the least dead
/// zone came to among those that explain the logs as well; and half of how far the others
/// are from it.
fn simplest(edge: usize, mut searches: Vec<Search<'_>>) -> ([f64; COUNT], f64) {
    searches.sort_by(|a, b| a.loss().total_cmp(&b.loss()));
    let most = searches[0].loss() + NO_WORSE;
    let as_good = searches.iter().take_while(|search| search.loss() <= most);
    let edges: Vec<f64> = as_good.map(|search| search.at()[edge].max(0.0)).collect();
    let sizes = edges.iter().enumerate();
    let least = sizes.min_by(|a, b| a.1.total_cmp(b.1));
    let (index, here) = least.map_or((0, 0.0), |(index, here)| (index, *here));
    let doubt = edges.iter().map(|edge| edge - here).fold(0.0, f64::max) / 2.0;
    (searches[index].at(), doubt)
}
