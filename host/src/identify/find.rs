//! From traces to numbers: the start, the search in windows of growing length, and what
//! is known of the numbers in the end.

use armbridge_shared::JOINTS;
use nalgebra::SMatrix;

use super::arm::Known;
use super::cost::Stretch;
use super::quantity::{COUNT, Quantity};
use super::search::{Prior, Search};
use super::start::{NoStart, start};
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
    let mut at = start(traces, known, &prior.mean)?;
    let mut evaluations = 0;
    let mut variance = VARIANCE;
    let mut found = None;
    let mut doubt = [0.0; COUNT];
    for (round, len) in ROUNDS.into_iter().enumerate() {
        let zero = [0, 1].map(|joint| Quantity::Zero.value(at[Quantity::Zero.at(joint)]));
        let traces: Vec<Trace> = traces
            .iter()
            .map(|trace| trace.smoothed(known, zero))
            .collect();
        let windows = |joint: usize| {
            let of = move |(index, trace): (usize, &Trace)| trace.windows(index, joint, len);
            traces.iter().enumerate().flat_map(of)
        };
        let stretches: Vec<Stretch> = (0..JOINTS)
            .flat_map(windows)
            .map(|window| Stretch::new(window.clone(), &traces[window.trace]))
            .collect();
        let errors = len as f64 / super::cost::BLOCK as f64;
        let most = variance * (1.0 + ODD * (2.0 / errors).sqrt());
        let begin = |at| {
            Search::begin(
                stretches.clone(),
                &traces,
                known,
                prior,
                at,
                [variance, most],
            )
        };
        let mut search = begin(at).run();
        evaluations += search.evaluations();
        if round == 1 {
            for edge in edges() {
                let others = DEAD_ZONES.map(|counts| {
                    let mut at = search.at();
                    at[edge] = Quantity::DeadAbove.coordinate(counts);
                    begin(at).run()
                });
                evaluations += others.iter().map(Search::evaluations).sum::<usize>();
                (search, doubt[edge]) = simplest(edge, others.into_iter().chain([search]));
            }
        }
        at = search.at();
        let explained = search
            .stretches()
            .iter()
            .filter(|s| s.squares <= most * s.count as f64);
        let (squares, count) = explained.fold((0.0, 0), |(squares, count), stretch| {
            (
                squares + stretch.squares,
                count + stretch.count - super::cost::STARTS,
            )
        });
        if count > 0 {
            variance = squares / count as f64;
        }
        found = Some((
            search.information(),
            search.scatter(),
            search.stretches().to_vec(),
            most,
        ));
    }
    // There is a round.
    let (information, scatter, stretches, most) = found.unwrap_or_default();
    let mut covariance = covariance(&information, &scatter);
    for (i, doubt) in doubt.into_iter().enumerate() {
        covariance[(i, i)] += f64::powi(doubt, 2);
    }
    Ok(Found {
        at,
        covariance,
        unweighed: unweighed(information, prior),
        noise_counts: variance.sqrt(),
        stretches,
        most,
        evaluations,
    })
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
fn simplest<'a>(edge: usize, searches: impl Iterator<Item = Search<'a>>) -> (Search<'a>, f64) {
    let mut searches: Vec<Search> = searches.collect();
    let least = searches
        .iter()
        .map(Search::loss)
        .fold(f64::INFINITY, f64::min);
    searches.retain(|search| search.loss() <= least + NO_WORSE);
    let order = |a: &Search, b: &Search| a.at()[edge].abs().total_cmp(&b.at()[edge].abs());
    searches.sort_by(order);
    let simplest = searches.remove(0);
    let edges = searches
        .iter()
        .map(|other| other.at()[edge] - simplest.at()[edge]);
    let doubt = edges.fold(0.0, f64::max) / 2.0;
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
