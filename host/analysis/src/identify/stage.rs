//! A stage of the fit: windows of one length, and the dead zones fitted in them.
//!
//! The gradient does not show where a dead zone ends: no dead zone looks much like one that
//! reaches as far beyond the motor's true neutral as before it, since on average it removes
//! no torque, and no gradient leads from one to the other. So each edge is fitted from
//! several initial guesses. Without a dead zone nothing determines an edge: the smallest
//! edge that would be detected gives its uncertainty.

use armbridge_servo::JOINTS;

use super::arm::KnownParameters;
use super::cost::WindowFit;
use super::dataset::Trace;
use super::prior::Prior;
use super::quantity::{COUNT, PER_JOINT, Quantity};
use super::search::{ErrorModel, Search};

/// Loss by which a larger dead zone must beat a smaller one at least, and by which an absent dead
/// zone is detected: the square of [`LOSS_SIGMAS`].
pub(super) const LOSS_MARGIN: f64 = 9.0;
/// Standard deviations of the difference by which a dead zone must beat none: one in ten does by
/// chance.
const DIFFERENCE_SIGMAS: f64 = 1.28;
/// [`LOSS_MARGIN`] in standard deviations.
const LOSS_SIGMAS: f64 = 3.0;
/// Edge of no dead zone: on the wrong side of neutral.
const NO_DEAD_ZONE_COUNTS: f64 = -2.0;
/// Initial guesses of an edge, in counts: up to the paper's.
const INITIAL_EDGES_COUNTS: [f64; 4] = [NO_DEAD_ZONE_COUNTS, 15.0, 30.0, 50.0];
/// Edges of which the smallest that the logs reject is the detection limit.
const DETECTION_COUNTS: [f64; 6] = [1.0, 2.0, 4.0, 8.0, 16.0, 32.0];

/// Inputs that the searches of a stage share.
pub(super) struct Stage<'a> {
    /// Smoothed.
    pub(super) traces: &'a [Trace],
    pub(super) known: &'a KnownParameters,
    pub(super) prior: &'a Prior,
    pub(super) errors: ErrorModel,
    pub(super) window_fits: Vec<WindowFit>,
}

/// Fit of the dead zones.
pub(super) struct DeadZoneFit {
    pub(super) coordinates: [f64; COUNT],
    /// Uncertainty of each edge's coordinate because another explains the logs as well.
    pub(super) ambiguity: [f64; COUNT],
}

impl<'a> Stage<'a> {
    /// Windows of both joints of at most this length.
    pub(super) fn window_fits(traces: &[Trace], len: usize) -> Vec<WindowFit> {
        let mut window_fits = Vec::new();
        for joint in 0..JOINTS {
            for (index, trace) in traces.iter().enumerate() {
                let windows = trace.windows(index, joint, len).into_iter();
                window_fits.extend(windows.map(|window| WindowFit::new(window, trace)));
            }
        }
        window_fits
    }

    /// Windows of one joint.
    pub(super) fn joint_window_fits(&self, joint: usize) -> Vec<WindowFit> {
        let own = |window_fit: &&WindowFit| window_fit.window.joint == joint;
        self.window_fits.iter().filter(own).cloned().collect()
    }

    /// A search in all windows.
    pub(super) fn search(&self, coordinates: [f64; COUNT]) -> Search<'a> {
        self.search_in(self.window_fits.clone(), coordinates)
    }

    pub(super) fn search_in(
        &self,
        window_fits: Vec<WindowFit>,
        coordinates: [f64; COUNT],
    ) -> Search<'a> {
        let Self {
            traces,
            known,
            prior,
            errors,
            ..
        } = self;
        Search::new(window_fits, traces, known, prior, coordinates, *errors)
    }

    /// Fits each edge of a dead zone from several initial guesses, in windows of its own
    /// joint: the other joint's motion has no information on it. Once the forms of friction are
    /// known, `by_chance` also leaves out a dead zone that beats none by chance: before, what the
    /// model lacks differs as much between windows.
    pub(super) fn fit_dead_zones(
        &self,
        mut coordinates: [f64; COUNT],
        by_chance: bool,
    ) -> DeadZoneFit {
        let mut ambiguity = [0.0; COUNT];
        for edge in Quantity::dead_zone_edges() {
            let joint = edge / PER_JOINT;
            let own = self.joint_window_fits(joint);
            let from = |counts: Option<f64>| {
                let mut guess = coordinates;
                guess[edge] =
                    counts.map_or(guess[edge], |counts| Quantity::DeadAbove.coordinate(counts));
                self.search_in(own.clone(), guess).minimise_briefly()
            };
            let mut searches = vec![from(None)];
            searches.extend(INITIAL_EDGES_COUNTS.map(|counts| from(Some(counts))));
            let (best, range) = smallest_dead_zone(edge, searches, by_chance);
            ambiguity[edge] = range;
            let parameters = joint * PER_JOINT..(joint + 1) * PER_JOINT;
            coordinates[parameters.clone()].copy_from_slice(&best[parameters]);
        }
        DeadZoneFit {
            coordinates,
            ambiguity,
        }
    }

    /// Standard deviation of the coordinate of an edge where there is no dead zone, from the
    /// smallest edge that would be detected; `None` if none would.
    pub(super) fn no_dead_zone_deviation(&self, search: &Search<'_>, edge: usize) -> Option<f64> {
        let limit = search.loss() + LOSS_MARGIN;
        let is_detected = |counts: &f64| {
            let mut coordinates = search.coordinates();
            coordinates[edge] = Quantity::DeadAbove.coordinate(*counts);
            self.search(coordinates).loss() > limit
        };
        let counts = DETECTION_COUNTS.into_iter().find(is_detected)?;
        Some(Quantity::DeadAbove.coordinate(counts) / LOSS_SIGMAS)
    }
}

/// Result of the search with the smallest dead zone, among searches that differ in this
/// edge and explain the logs as well as the best; and half of the range of their edges.
fn smallest_dead_zone(
    edge: usize,
    mut searches: Vec<Search<'_>>,
    by_chance: bool,
) -> ([f64; COUNT], f64) {
    searches.sort_by(|a, b| a.loss().total_cmp(&b.loss()));
    let (best, best_windows) = (searches[0].loss(), searches[0].window_losses());
    let is_as_good = |search: &&Search<'_>| {
        let is_none = search.coordinates()[edge] <= 0.0;
        let chance = if by_chance && is_none {
            DIFFERENCE_SIGMAS * deviation_of_sum(&search.window_losses(), &best_windows)
        } else {
            0.0
        };
        search.loss() - best <= LOSS_MARGIN.max(chance)
    };
    let as_good: Vec<(f64, [f64; COUNT])> = searches
        .iter()
        .filter(is_as_good)
        .map(|search| (search.coordinates()[edge].max(0.0), search.coordinates()))
        .collect();
    let smallest = as_good.iter().min_by(|a, b| a.0.total_cmp(&b.0));
    let (least, coordinates) = smallest.map_or((0.0, searches[0].coordinates()), |it| *it);
    let edges = as_good.iter().map(|(edge, _)| edge - least);
    (coordinates, edges.fold(0.0, f64::max) / 2.0)
}

/// Standard deviation of the difference of two losses, from how much it differs from window to
/// window: where a servo's time drifts against the ticks, residuals are more alike than noise is.
fn deviation_of_sum(losses: &[f64], others: &[f64]) -> f64 {
    let count = losses.len() as f64;
    let differences = || losses.iter().zip(others).map(|(loss, other)| loss - other);
    let mean = differences().sum::<f64>() / count;
    let squares: f64 = differences()
        .map(|difference| (difference - mean).powi(2))
        .sum();
    (squares * count / (count - 1.0)).sqrt()
}
