//! From traces to numbers: the start, the search in windows of growing length, what is
//! known of the numbers in the end, and static friction.

use armbridge_shared::JOINTS;
use nalgebra::SMatrix;

use super::arm::Known;
use super::cost::{BLOCK, STARTS, Stretch};
use super::quantity::{COUNT, PER_JOINT, Quantity};
use super::search::{Prior, Search};
use super::start::{NoStart, start};
use super::stiction::{Static, Stiction};
use super::trace::Trace;

/// Longest windows of each round, in ticks: in short ones a wrong number leads less far
/// astray, in long ones a right one shows more.
const ROUNDS: [usize; 3] = [400, 1_000, 1_000];
/// Variance of an error to begin with, in counts squared: noise of a count, rounded.
const VARIANCE: f64 = 1.0 + 1.0 / 12.0;
/// Standard deviations of a window's mean square beyond which it counts less.
const ODD: f64 = 4.0;
/// Loss by which a dead zone must be better to be believed in place of a smaller one:
/// three standard deviations.
const NO_WORSE: f64 = 9.0;
/// Edges of a dead zone that are tried, in counts. One of nothing looks much like one that
/// reaches as far beyond the motor's true zero as before it: what it takes away is none on
/// average. No slope leads from the one to the other.
const DEAD_ZONES: [f64; 4] = [0.5, 15.0, 30.0, 50.0];

/// What was found.
#[derive(Clone, Debug)]
pub struct Found {
    /// Coordinates of the numbers.
    pub at: [f64; COUNT],
    /// Their covariance.
    pub covariance: SMatrix<f64, COUNT, COUNT>,
    /// Standard deviation of each coordinate if nobody had weighed the arm.
    pub unweighed: [f64; COUNT],
    /// Standard deviation of an encoder's noise in counts, rounding included.
    pub noise_counts: f64,
    /// Static friction of each joint, if it gave way often enough.
    pub friction: [Option<Static>; JOINTS],
    /// The windows, as they are explained.
    pub stretches: Vec<Stretch>,
    /// Mean square of a window's errors beyond which it is not explained, in counts
    /// squared.
    pub most: f64,
    /// How often all motions were computed.
    pub evaluations: usize,
}

impl Found {
    /// A number, and its standard error.
    pub fn number(&self, joint: usize, quantity: Quantity) -> (f64, f64) {
        let i = quantity.at(joint);
        let deviation = self.covariance[(i, i)].max(0.0).sqrt();
        let value: f64 = quantity.value(self.at[i]);
        (value, deviation * quantity.slope(self.at[i]).abs())
    }

    /// Whether a number is known by the arm's weight alone: without it the logs tell it to
    /// less than a tenth.
    pub fn rests_on_weight(&self, joint: usize, quantity: Quantity) -> bool {
        let i = quantity.at(joint);
        quantity.is_relative() && self.unweighed[i] > 0.1 && self.covariance[(i, i)].sqrt() < 0.1
    }

    /// Whether the logs say hardly more of a number than was believed before.
    pub fn is_unseen(&self, prior: &Prior, joint: usize, quantity: Quantity) -> bool {
        let i = quantity.at(joint);
        quantity != Quantity::Gravity && self.covariance[(i, i)].sqrt() > 0.5 * prior.deviation[i]
    }

    /// Windows that are not explained.
    pub fn odd(&self) -> usize {
        let is_odd = |stretch: &&Stretch| stretch.squares > self.most * stretch.count as f64;
        self.stretches.iter().filter(is_odd).count()
    }
}

/// Seeks the numbers that explain these traces.
///
/// # Errors
/// If they do not tell enough to begin with.
pub fn find(traces: &[Trace], known: &Known, prior: &Prior) -> Result<Found, NoStart> {
    let mut found = Found {
        at: start(traces, known, &prior.mean)?,
        covariance: SMatrix::zeros(),
        unweighed: [0.0; COUNT],
        noise_counts: VARIANCE.sqrt(),
        friction: [None; JOINTS],
        stretches: Vec::new(),
        most: VARIANCE,
        evaluations: 0,
    };
    let mut doubt = [0.0; COUNT];
    for (round, len) in ROUNDS.into_iter().enumerate() {
        let zero = [0, 1].map(|joint| found.number(joint, Quantity::Zero).0);
        let smooth = |trace: &Trace| trace.smoothed(known, zero);
        let traces: Vec<Trace> = traces.iter().map(smooth).collect();
        let stretches = stretches(&traces, len);
        let variance = found.noise_counts.powi(2);
        found.most = variance * (1.0 + ODD * (2.0 * BLOCK as f64 / len as f64).sqrt());
        let judged = [variance, found.most];
        let begin = |stretches, at| Search::begin(stretches, &traces, known, prior, at, judged);
        let mut search = begin(stretches.clone(), found.at).run();
        found.evaluations += search.evaluations();
        if round == 1 {
            let mut at = search.at();
            for edge in edges() {
                let joint = edge / PER_JOINT;
                // The other joint's motions say nothing of it.
                let own = stretches.iter().filter(|s| s.window.joint == joint);
                let own: Vec<Stretch> = own.cloned().collect();
                let others = DEAD_ZONES.map(|counts| {
                    let mut at = at;
                    at[edge] = Quantity::DeadAbove.coordinate(counts);
                    begin(own.clone(), at).run()
                });
                found.evaluations += others.iter().map(Search::evaluations).sum::<usize>() / 2;
                let (best, doubtful) = simplest(edge, begin(own.clone(), at).run(), others);
                doubt[edge] = doubtful;
                let numbers = joint * PER_JOINT..(joint + 1) * PER_JOINT;
                at[numbers.clone()].copy_from_slice(&best.at()[numbers]);
            }
            search = begin(stretches.clone(), at).run();
            found.evaluations += search.evaluations();
        }
        found.take(&search, prior);
    }
    for (i, doubt) in doubt.into_iter().enumerate() {
        found.covariance[(i, i)] += f64::powi(doubt, 2);
    }
    let zero = [0, 1].map(|joint| found.number(joint, Quantity::Zero).0);
    let traces: Vec<Trace> = traces.iter().map(|t| t.smoothed(known, zero)).collect();
    let stiction = Stiction {
        traces: &traces,
        known,
        at: &found.at,
        covariance: &found.covariance,
        noise_counts: found.noise_counts,
    };
    found.friction = stiction.found();
    Ok(found)
}

/// All windows of both joints, none longer than this.
fn stretches(traces: &[Trace], len: usize) -> Vec<Stretch> {
    let mut stretches = Vec::new();
    for joint in 0..JOINTS {
        for (index, trace) in traces.iter().enumerate() {
            let windows = trace.windows(index, joint, len).into_iter();
            stretches.extend(windows.map(|window| Stretch::new(window, trace)));
        }
    }
    stretches
}

impl Found {
    /// What a search has come to.
    fn take(&mut self, search: &Search<'_>, prior: &Prior) {
        self.at = search.at();
        self.stretches = search.stretches().to_vec();
        let information = search.information();
        self.covariance = covariance(&information, &search.scatter());
        self.unweighed = unweighed(information, prior);
        let most = self.most;
        let explained = self
            .stretches
            .iter()
            .filter(|s| s.squares <= most * s.count as f64);
        let (squares, count) = explained.fold((0.0, 0), |(squares, count), stretch| {
            (squares + stretch.squares, count + stretch.count - STARTS)
        });
        if count > 0 {
            self.noise_counts = (squares / count as f64).sqrt();
        }
    }
}

/// What would be known without the weights: gravity as little as all else.
fn unweighed(mut information: SMatrix<f64, COUNT, COUNT>, prior: &Prior) -> [f64; COUNT] {
    for joint in 0..JOINTS {
        let [gravity, inertia] = [Quantity::Gravity, Quantity::Inertia].map(|q| q.at(joint));
        let less = prior.deviation[gravity].powi(-2) - prior.deviation[inertia].powi(-2);
        information[(gravity, gravity)] -= less;
    }
    let covariance = information.try_inverse();
    core::array::from_fn(|i| covariance.map_or(f64::INFINITY, |c| c[(i, i)].max(0.0).sqrt()))
}

/// Of searches that differ in this edge of a dead zone, the one with the least dead zone
/// among those that explain the logs as well; and half of how far the others are from it.
fn simplest<'a, const N: usize>(
    edge: usize,
    own: Search<'a>,
    others: [Search<'a>; N],
) -> (Search<'a>, f64) {
    let mut searches: Vec<Search> = std::iter::once(own).chain(others).collect();
    searches.sort_by(|a, b| a.loss().total_cmp(&b.loss()));
    let most = searches[0].loss() + NO_WORSE;
    let as_good = searches.iter().take_while(|search| search.loss() <= most);
    let edges: Vec<f64> = as_good.map(|search| search.at()[edge]).collect();
    let sizes = edges.iter().map(|edge| edge.abs()).enumerate();
    let least = sizes.min_by(|a, b| a.1.total_cmp(&b.1));
    let simplest = searches.swap_remove(least.map_or(0, |(index, _)| index));
    let here = simplest.at()[edge];
    let doubt = edges.iter().map(|edge| edge - here).fold(0.0, f64::max) / 2.0;
    (simplest, doubt)
}

/// Coordinates of the dead zones' edges.
fn edges() -> impl Iterator<Item = usize> {
    (0..JOINTS).flat_map(|joint| [Quantity::DeadBelow.at(joint), Quantity::DeadAbove.at(joint)])
}

/// The covariance if errors are noise, and where what the windows say scatters more than
/// that, larger by as much.
fn covariance(
    information: &SMatrix<f64, COUNT, COUNT>,
    scatter: &SMatrix<f64, COUNT, COUNT>,
) -> SMatrix<f64, COUNT, COUNT> {
    let Some(plain) = information.try_inverse() else {
        return SMatrix::from_diagonal_element(f64::INFINITY);
    };
    let robust = plain * scatter * plain;
    let more =
        SMatrix::<f64, COUNT, 1>::from_fn(|i, _| (robust[(i, i)] / plain[(i, i)]).max(1.0).sqrt());
    plain.component_mul(&(more * more.transpose()))
}
