//! From traces to numbers: the start, the search in windows of growing length, what is
//! known of the numbers in the end, and static friction.

use armbridge_shared::JOINTS;
use nalgebra::SMatrix;

use super::arm::Known;
use super::checks;
use super::cost::{BLOCK, STARTS};
use super::dataset::Trace;
use super::fit_result::Found;
use super::initial_guess::{NoStart, start};
use super::quantity::{COUNT, PER_JOINT, Quantity};
use super::search::{Prior, Search};
use super::stage::Round;
use super::stiction::Stiction;
use super::stribeck;

/// Longest windows of each round, in ticks: in short ones a wrong number leads less far
/// astray, in long ones a right one shows more.
const ROUNDS: [usize; 3] = [400, 1_000, 1_000];
/// Variance of an error to begin with, in counts squared: noise of a count, rounded.
const VARIANCE: f64 = 1.0 + 1.0 / 12.0;
/// Standard deviations of a window's mean square beyond which it counts less.
const ODD: f64 = 4.0;

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
        stribeck: [None; JOINTS],
        friction: [None; JOINTS],
        stretches: Vec::new(),
        most: VARIANCE,
    };
    let mut doubt = [0.0; COUNT];
    let mut falls = [false; JOINTS];
    for (number, len) in ROUNDS.into_iter().enumerate() {
        let zero = [0, 1].map(|joint| found.number(joint, Quantity::Zero).0);
        let smooth = |trace: &Trace| trace.smoothed(known, zero);
        let traces: Vec<Trace> = traces.iter().map(smooth).collect();
        let variance = found.noise_counts.powi(2);
        found.most = variance * (1.0 + ODD * (2.0 * BLOCK as f64 / len as f64).sqrt());
        let falling = known.with(&found.stribeck);
        let round = Round {
            stretches: Round::stretches(&traces, len),
            traces: &traces,
            known: &falling,
            prior,
            judged: [variance, found.most],
        };
        let is_last = number + 1 == ROUNDS.len();
        let mut search = round.begin(found.at).run();
        if number == 0 {
            // Where hardly a window is an arm's, linear least squares begins far off.
            let believed = round.begin(prior.mean).try_once();
            if believed.loss() < search.loss() {
                search = believed;
            }
        }
        if number == 1 || (is_last && falls.contains(&true)) {
            let tried = round.try_dead_zones(search.at());
            doubt = tried.doubt;
            search = round.begin(tried.at).run();
        }
        found.take(&search, prior);
        if number == 1 {
            falls = [0, 1].map(|joint| found.fall(&round, joint).is_some());
        }
        if is_last {
            found.end(&round, search, falls);
        }
    }
    for (i, doubt) in doubt.into_iter().enumerate() {
        found.covariance[(i, i)] += f64::powi(doubt, 2);
    }
    let zero = [0, 1].map(|joint| found.number(joint, Quantity::Zero).0);
    let traces: Vec<Trace> = traces.iter().map(|t| t.smoothed(known, zero)).collect();
    let stiction = Stiction {
        traces: &traces,
        known: &known.with(&found.stribeck),
        at: &found.at,
        covariance: &found.covariance,
        noise_counts: found.noise_counts,
    };
    found.friction = stiction.found();
    Ok(found)
}

impl Found {
    /// The last round's end: how these joints' dry friction falls, all other numbers with it,
    /// and how well it is known where there is no dead zone.
    fn end(&mut self, round: &Round<'_>, search: Search<'_>, falls: [bool; JOINTS]) {
        let falling = (0..JOINTS).filter(|joint| falls[*joint]);
        let more: Vec<_> = falling
            .filter_map(|joint| self.fall(round, joint))
            .collect();
        let known = round.known.with(&self.stribeck);
        let round = Round {
            known: &known,
            stretches: round.stretches.clone(),
            ..*round
        };
        let search = if falls.contains(&true) {
            round.begin(self.at).run()
        } else {
            search
        };
        self.take(&search, round.prior);
        self.covariance += more.iter().sum::<SMatrix<f64, COUNT, COUNT>>();
        let edges = Quantity::edges().filter(|edge| search.at()[*edge] <= 0.0);
        let none = edges.filter_map(|edge| Some((edge, round.seen(&search, edge)?)));
        for (edge, deviation) in none {
            self.covariance.row_mut(edge).fill(0.0);
            self.covariance.column_mut(edge).fill(0.0);
            self.covariance[(edge, edge)] = deviation.powi(2);
        }
    }

    /// Seeks how a joint's dry friction falls with speed, from where it was found to, or where
    /// a torque that does would surely explain the logs better. Returns what not knowing that
    /// better adds to the covariance; `None` if it does not fall.
    fn fall(&mut self, round: &Round<'_>, joint: usize) -> Option<SMatrix<f64, COUNT, COUNT>> {
        let before = self.stribeck[joint]
            .take()
            .map(|stribeck| stribeck.falling());
        let begin = before.or_else(|| checks::falling(self, round.traces, round.known, joint))?;
        let sought = stribeck::sought(round, self.at, joint, begin)?;
        self.stribeck[joint] = Some(sought.stribeck);
        let own = joint * PER_JOINT..(joint + 1) * PER_JOINT;
        self.at[own].copy_from_slice(&sought.own);
        Some(sought.covariance)
    }

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
            (
                squares + stretch.squares,
                count + stretch.count.saturating_sub(STARTS),
            )
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
