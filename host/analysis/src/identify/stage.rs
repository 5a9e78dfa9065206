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

/// Loss by which a larger dead zone must beat a smaller one, and by which an absent dead
/// zone is detected: the square of [`LOSS_SIGMAS`].
const LOSS_MARGIN: f64 = 9.0;
/// The same in standard deviations.
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
    /// joint: the other joint's motion has no information on it.
    pub(super) fn fit_dead_zones(&self, mut coordinates: [f64; COUNT]) -> DeadZoneFit {
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
            let (best, range) = smallest_dead_zone(edge, searches);
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
fn smallest_dead_zone(edge: usize, mut searches: Vec<Search<'_>>) -> ([f64; COUNT], f64) {
    searches.sort_by(|a, b| a.loss().total_cmp(&b.loss()));
    let limit = searches[0].loss() + LOSS_MARGIN;
    let as_good = searches.iter().take_while(|search| search.loss() <= limit);
    let edges: Vec<f64> = as_good
        .map(|search| search.coordinates()[edge].max(0.0))
        .collect();
    let sizes = edges.iter().enumerate();
    let smallest = sizes.min_by(|a, b| a.1.total_cmp(b.1));
    let (index, least) = smallest.map_or((0, 0.0), |(index, least)| (index, *least));
    let range = edges.iter().map(|edge| edge - least).fold(0.0, f64::max) / 2.0;
    (searches[index].coordinates(), range)
}
