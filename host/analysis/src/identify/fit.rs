//! The fit: initial guess, search in windows of growing length, covariance of the
//! parameters, and static friction.

use armbridge_servo::JOINTS;
use nalgebra::SMatrix;

use super::arm::KnownParameters;
use super::cost::{BLOCK, INITIAL_STATES};
use super::dataset::{Trace, encoder_noise_counts};
use super::fit_result::FitResult;
use super::initial_guess::{InitialGuessError, initial_guess};
use super::load::LoadEstimate;
use super::prior::Prior;
use super::quantity::{COUNT, Quantity};
use super::search::{ErrorModel, Search};
use super::stage::{LOSS_MARGIN, Stage};
use super::stiction::StaticFrictionFit;

/// Longest windows of each stage, in ticks: in short ones a wrong parameter leads less far
/// astray, long ones are more sensitive to a right one.
const STAGES: [usize; 3] = [400, 1_000, 1_000];
/// Least initial variance of a residual, in counts squared: noise of a count, rounded.
const VARIANCE_COUNTS2: f64 = 1.0 + 1.0 / 12.0;
/// Initial guess of the friction in N m per N m that the gears transmit, where there is any: that of
/// an XL330 (`armbridge identify pendulum`).
const TYPICAL_LOAD: f64 = 0.17;
/// Standard deviations of a window's mean square beyond which it is an outlier.
const OUTLIER_SIGMAS: f64 = 4.0;

/// Fits the parameters to these traces.
///
/// # Errors
/// If there is no initial guess.
pub(super) fn fit(
    traces: &[Trace],
    known: &KnownParameters,
    prior: &Prior,
) -> Result<FitResult, InitialGuessError> {
    let noise_counts = encoder_noise_counts(traces, known.joints).max(VARIANCE_COUNTS2.sqrt());
    let mut result = FitResult {
        coordinates: initial_guess(traces, known, &prior.mean)?,
        covariance: SMatrix::zeros(),
        deviation_without_weight: [0.0; COUNT],
        noise_counts,
        stribeck: [None; JOINTS],
        load: [None; JOINTS],
        static_friction: [None; JOINTS],
        window_fits: Vec::new(),
        outlier_limit_counts2: noise_counts.powi(2),
    };
    let mut ambiguity = [0.0; COUNT];
    for (number, len) in STAGES.into_iter().enumerate() {
        let traces = result.smoothed(traces, known);
        let variance_counts2 = result.noise_counts.powi(2);
        result.outlier_limit_counts2 =
            variance_counts2 * (1.0 + OUTLIER_SIGMAS * (2.0 * BLOCK as f64 / len as f64).sqrt());
        let with_friction = known.with_friction(&result);
        let stage = Stage {
            window_fits: Stage::window_fits(&traces, len),
            traces: &traces,
            known: &with_friction,
            prior,
            errors: ErrorModel {
                variance_counts2,
                outlier_limit_counts2: result.outlier_limit_counts2,
            },
        };
        let is_last = number + 1 == STAGES.len();
        if number == 0 {
            result.begin(&stage);
            continue;
        }
        let mut search = stage.search(result.coordinates).minimise();
        if number == 1 || (is_last && result.has_friction_form()) {
            let dead_zones = stage.fit_dead_zones(search.coordinates(), is_last);
            ambiguity = dead_zones.ambiguity;
            search = stage.search(dead_zones.coordinates).minimise();
        }
        result.update(&search, prior);
        if number == 1 {
            (0..known.joints).for_each(|joint| result.select_friction(&stage, joint));
        }
        if is_last {
            result.finish(&stage, search);
        }
    }
    for (i, ambiguity) in ambiguity.into_iter().enumerate() {
        result.covariance[(i, i)] += f64::powi(ambiguity, 2);
    }
    let static_friction = StaticFrictionFit {
        traces: &result.smoothed(traces, known),
        known: &known.with_friction(&result),
        coordinates: &result.coordinates,
        covariance: &result.covariance,
        noise_counts: result.noise_counts,
    };
    result.static_friction = static_friction.estimate();
    Ok(result)
}

impl FitResult {
    /// The first stage: of several initial guesses, the one that explains the logs best.
    fn begin(&mut self, stage: &Stage<'_>) {
        let linear = stage.search(self.coordinates).minimise();
        // With hardly a window of a free arm, linear least squares begins far off.
        let from_prior = stage.search(stage.prior.mean).minimise_briefly();
        let without_load = if from_prior.loss() < linear.loss() {
            from_prior
        } else {
            linear
        };
        // Friction that grows with the load is no small addition: without it gains and dry friction
        // go far astray.
        let known = KnownParameters {
            load: [TYPICAL_LOAD; JOINTS],
            ..*stage.known
        };
        let loaded = Stage {
            known: &known,
            window_fits: stage.window_fits.clone(),
            ..*stage
        };
        let with_load = loaded.search(without_load.coordinates()).minimise();
        if with_load.loss() + LOSS_MARGIN < without_load.loss() {
            for load in self.load.iter_mut().take(known.joints) {
                *load = Some(LoadEstimate::guess(TYPICAL_LOAD));
            }
            self.update(&with_load, stage.prior);
            (0..known.joints).for_each(|joint| self.refit_load(stage, joint));
        } else {
            self.update(&without_load, stage.prior);
        }
    }

    /// Ends the last stage: fits the forms of dry friction of both joints, then all parameters
    /// again, and the uncertainty of edges where there is no dead zone.
    fn finish(&mut self, stage: &Stage<'_>, search: Search<'_>) {
        let has_form = self.has_friction_form();
        let added = [0, 1].map(|joint| self.refit_friction(stage, joint));
        let known = stage.known.with_friction(self);
        let stage = Stage {
            known: &known,
            window_fits: stage.window_fits.clone(),
            ..*stage
        };
        let search = if has_form {
            stage.search(self.coordinates).minimise()
        } else {
            search
        };
        self.update(&search, stage.prior);
        self.covariance += added.iter().sum::<SMatrix<f64, COUNT, COUNT>>();
        let edges = Quantity::dead_zone_edges().filter(|edge| search.coordinates()[*edge] <= 0.0);
        let absent =
            edges.filter_map(|edge| Some((edge, stage.no_dead_zone_deviation(&search, edge)?)));
        for (edge, deviation) in absent {
            self.covariance.row_mut(edge).fill(0.0);
            self.covariance.column_mut(edge).fill(0.0);
            self.covariance[(edge, edge)] = deviation.powi(2);
        }
    }

    /// Takes over the result of a search.
    fn update(&mut self, search: &Search<'_>, prior: &Prior) {
        self.coordinates = search.coordinates();
        self.window_fits = search.window_fits().to_vec();
        let information = search.information();
        self.covariance = covariance(&information, &search.scatter());
        self.deviation_without_weight = deviation_without_weight(information, prior);
        let limit = self.outlier_limit_counts2;
        let explained = self
            .window_fits
            .iter()
            .filter(|fit| fit.is_explained(limit));
        let (squares, count) = explained.fold((0.0, 0), |(squares, count), window_fit| {
            (
                squares + window_fit.squares,
                count + window_fit.count.saturating_sub(INITIAL_STATES),
            )
        });
        if count > 0 {
            self.noise_counts = (squares / count as f64).sqrt();
        }
    }
}

/// Standard deviations without the prior of the weight: gravity as uncertain as the other
/// relative parameters.
fn deviation_without_weight(
    mut information: SMatrix<f64, COUNT, COUNT>,
    prior: &Prior,
) -> [f64; COUNT] {
    for joint in 0..JOINTS {
        let [gravity, inertia] = [Quantity::Gravity, Quantity::Inertia].map(|q| q.index(joint));
        let less = prior.deviation[gravity].powi(-2) - prior.deviation[inertia].powi(-2);
        information[(gravity, gravity)] -= less;
    }
    let covariance = information.try_inverse();
    core::array::from_fn(|i| covariance.map_or(f64::INFINITY, |c| c[(i, i)].max(0.0).sqrt()))
}

/// Covariance if residuals are noise, increased where the windows' gradients scatter more
/// than noise does.
fn covariance(
    information: &SMatrix<f64, COUNT, COUNT>,
    scatter: &SMatrix<f64, COUNT, COUNT>,
) -> SMatrix<f64, COUNT, COUNT> {
    let Some(plain) = information.try_inverse() else {
        return SMatrix::from_diagonal_element(f64::INFINITY);
    };
    let robust = plain * scatter * plain;
    let increase =
        SMatrix::<f64, COUNT, 1>::from_fn(|i, _| (robust[(i, i)] / plain[(i, i)]).max(1.0).sqrt());
    plain.component_mul(&(increase * increase.transpose()))
}
