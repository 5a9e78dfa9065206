//! Model errors: torques that the model lacks, tested one at a time.
//!
//! The effect of a small additional torque follows from the equation of motion, linearised
//! about the measured motion. Its reduction of the sum of squares, beyond that of small
//! changes of the model's own parameters, is the square of a standard normal variable if the
//! model is right. The fit without dry friction is predicted likewise.

use nalgebra::{DMatrix, DVector};
use serde::Serialize;

use super::super::arm::{JointModel, KnownParameters};
use super::super::dataset::Trace;
use super::super::fit_result::FitResult;
use super::super::friction_forms::FrictionForm;
use super::super::load::LoadEstimate;
use super::super::quantity::Quantity;
use super::super::stribeck_curve::StribeckCurve;
use super::rollout::Rollout;

/// Number of the model's own torques: viscous and dry friction, motor, its offset, its delay,
/// inertia. Gravity is not among them: the weight is known, and with it the torques would be
/// linearly dependent, by the equation of motion.
const OWN: usize = 6;
const VISCOUS: usize = 0;
const DRY_FRICTION: usize = 1;
const INERTIA: usize = 5;
/// Torques that the model lacks.
const MISSING: [&str; 8] = [
    "dry friction falling up to 0.3 rad/s (Stribeck)",
    "dry friction falling up to 1 rad/s (Stribeck)",
    "dry friction growing with the load on the gears",
    "friction proportional to speed squared",
    "viscous friction by direction",
    "motor torque not proportional to PWM",
    "torque of twice the joint angle",
    "torque of the other joint's acceleration",
];
const ALL: usize = OWN + MISSING.len();
/// Speeds of the first two, in rad/s.
const STRIBECK_RAD_S: [f64; 2] = [0.3, 1.0];
/// The third.
const LOAD: usize = OWN + STRIBECK_RAD_S.len();
/// Significant improvement in noise variances: 5 standard deviations.
pub(super) const SIGNIFICANT: f64 = 25.0;
/// Largest negligible torque in N m.
pub(super) const NEGLIGIBLE_NM: f64 = 2e-3;
/// Ticks on either side over which the other joint's acceleration is measured.
const HALF_WIDTH: usize = 15;

/// Test of a torque that the model lacks.
#[derive(Clone, Debug, Serialize)]
pub struct MissingTorque {
    /// Joint, from 1.
    pub joint: usize,
    /// The torque.
    pub description: &'static str,
    /// Reduction in the sum of squares, in noise variances: about 1 by chance.
    pub improvement: f64,
    /// The torque where it is largest, in N m.
    pub torque_nm: f64,
}

/// Predicted fit without dry friction.
#[derive(Clone, Debug, Serialize)]
pub struct WithoutDryFriction {
    /// Joint, from 1.
    pub joint: usize,
    /// Increase in the sum of squares, in noise variances.
    pub loss_increase: f64,
    /// Root mean square of a residual in counts, with dry friction and without.
    pub rms_counts: [f64; 2],
    /// Viscous friction with dry friction and without.
    pub viscous_nm_s_rad: [f64; 2],
}

/// Normal equations of the torques' amplitudes, summed over windows.
struct NormalEquations {
    /// Products of the torques' effects.
    normal: DMatrix<f64>,
    /// Products of effects and residuals.
    right: DVector<f64>,
    /// Sum of the squared residuals, and their number.
    squares: f64,
    count: f64,
    /// Peak of each torque at unit amplitude.
    peak: [f64; ALL],
}

/// Initial guess of the form of a joint's dry friction that would improve the fit most, beside
/// those that it has, if the improvement is significant; traces are smoothed.
pub(super) fn friction_candidate(
    joint: usize,
    windows: &[&Rollout],
    traces: &[Trace],
    known: &KnownParameters,
    fit: &FitResult,
) -> Option<FrictionForm> {
    let equations = normal_equations(joint, windows, traces, known, fit);
    let own: Vec<usize> = (0..OWN).collect();
    let squares = equations.solve(&own, 0.0).0;
    let limit = squares - SIGNIFICANT * fit.noise_counts.powi(2);
    let stribeck = STRIBECK_RAD_S
        .into_iter()
        .zip(OWN..)
        .map(|(speed_rad_s, column)| {
            let (squares, drop_nm) = equations.fit_with(column);
            let curve = StribeckCurve {
                drop_nm,
                speed_rad_s,
            };
            (squares, drop_nm, FrictionForm::Stribeck(curve))
        });
    let (load_squares, load) = equations.fit_with(LOAD);
    let load_nm = load * equations.peak[LOAD];
    let load = (
        load_squares,
        load_nm,
        FrictionForm::Load(LoadEstimate::guess(load)),
    );
    let candidates = stribeck.chain([load]).filter(|(_, _, form)| match form {
        FrictionForm::Stribeck(_) => known.stribeck[joint].is_none(),
        FrictionForm::Load(_) => known.load[joint] == 0.0,
    });
    let significant = candidates.filter(|(squares, nm, _)| *squares < limit && *nm > NEGLIGIBLE_NM);
    let best = significant.min_by(|a, b| a.0.total_cmp(&b.0));
    best.map(|(_, _, form)| form)
}

/// Tests the model on these windows of a joint; traces are smoothed.
pub(super) fn model_errors(
    joint: usize,
    windows: &[&Rollout],
    traces: &[Trace],
    known: &KnownParameters,
    fit: &FitResult,
) -> (Vec<MissingTorque>, WithoutDryFriction) {
    let equations = normal_equations(joint, windows, traces, known, fit);
    let variance = fit.noise_counts.powi(2);
    let own: Vec<usize> = (0..OWN).collect();
    let squares = equations.solve(&own, 0.0).0;
    let missing_torques = MISSING.into_iter().zip(OWN..).map(|(description, column)| {
        let (less, amplitude) = equations.fit_with(column);
        MissingTorque {
            joint: joint + 1,
            description,
            improvement: (squares - less) / variance,
            torque_nm: (amplitude * equations.peak[column]).abs(),
        }
    });
    let missing_torques = missing_torques.collect();
    let estimate = |quantity| fit.estimate(joint, quantity).0;
    let (coulomb, viscous) = (estimate(Quantity::Coulomb), estimate(Quantity::Viscous));
    let viscous_only: Vec<usize> = own
        .iter()
        .copied()
        .filter(|column| *column != DRY_FRICTION)
        .collect();
    let (without, amplitudes) = equations.solve(&viscous_only, coulomb);
    let dry = WithoutDryFriction {
        joint: joint + 1,
        loss_increase: (without - squares) / variance,
        rms_counts: [squares, without].map(|squares| (squares.max(0.0) / equations.count).sqrt()),
        viscous_nm_s_rad: [viscous, viscous + amplitudes[VISCOUS]],
    };
    (missing_torques, dry)
}

impl NormalEquations {
    /// Sum of squares with one torque beside the model's own, and the torque's amplitude.
    fn fit_with(&self, column: usize) -> (f64, f64) {
        let with: Vec<usize> = (0..OWN).chain([column]).collect();
        let (squares, amplitudes) = self.solve(&with, 0.0);
        (squares, amplitudes[OWN])
    }

    /// Sum of squares with these torques, and the amplitude of each; `dry` is the dry
    /// friction in N m that is removed from the model first.
    fn solve(&self, columns: &[usize], dry: f64) -> (f64, Vec<f64>) {
        let squares = self.squares
            + 2.0 * dry * self.right[DRY_FRICTION]
            + dry * dry * self.normal[(DRY_FRICTION, DRY_FRICTION)];
        let right = |i: usize| self.right[i] + dry * self.normal[(i, DRY_FRICTION)];
        // Normalised columns, so that no torque is lost in rounding.
        let size = |i: usize| self.normal[(i, i)].max(1e-30).sqrt();
        let n = columns.len();
        let matrix = DMatrix::from_fn(n, n, |a, b| {
            let (i, j) = (columns[a], columns[b]);
            self.normal[(i, j)] / (size(i) * size(j))
        });
        let vector = DVector::from_fn(n, |a, _| right(columns[a]) / size(columns[a]));
        let solution = matrix.svd(true, true).solve(&vector, 1e-9);
        let solution = solution.unwrap_or_else(|_| DVector::zeros(n));
        let amplitudes = (0..n).map(|a| solution[a] / size(columns[a])).collect();
        (squares - solution.dot(&vector), amplitudes)
    }
}

/// Normal equations of these windows, with their initial states eliminated.
fn normal_equations(
    joint: usize,
    windows: &[&Rollout],
    traces: &[Trace],
    known: &KnownParameters,
    fit: &FitResult,
) -> NormalEquations {
    let model = JointModel::from_coordinates(known, &fit.coordinates, joint);
    let delay = model.delay_ticks(known);
    let mut equations = NormalEquations {
        normal: DMatrix::zeros(ALL, ALL),
        right: DVector::zeros(ALL),
        squares: 0.0,
        count: 0.0,
        peak: [0.0; ALL],
    };
    for window in windows {
        let sensitivity = TorqueSensitivity {
            model: &model,
            joint,
            known,
            trace: &traces[window.window.trace],
            delay_ticks: delay.round() as i64,
        };
        let effects = sensitivity.counts_per_nm(window, &mut equations.peak);
        let blocks = window.blocks_with(&effects);
        let start = DMatrix::from_fn(blocks.len(), 2, |i, j| blocks[i].0.sensitivity[j]);
        let residuals = DVector::from_fn(blocks.len(), |i, _| blocks[i].0.residual);
        let effects = DMatrix::from_fn(blocks.len(), ALL, |i, j| blocks[i].1[j]);
        let Some(inverse) = (start.transpose() * &start).try_inverse() else {
            continue;
        };
        let projection = inverse * start.transpose();
        let residuals = &residuals - &start * (&projection * &residuals);
        let effects = &effects - &start * (&projection * &effects);
        equations.normal += effects.transpose() * &effects;
        equations.right += effects.transpose() * &residuals;
        equations.squares += residuals.norm_squared();
        equations.count += blocks.len() as f64;
    }
    equations
}

/// Sensitivity of a joint's motion to additional torques.
struct TorqueSensitivity<'a> {
    model: &'a JointModel<f64>,
    joint: usize,
    known: &'a KnownParameters,
    trace: &'a Trace,
    delay_ticks: i64,
}

impl TorqueSensitivity<'_> {
    /// Effect in counts of each torque at unit amplitude, tick by tick.
    fn counts_per_nm(&self, window: &Rollout, peak: &mut [f64; ALL]) -> Vec<[f64; ALL]> {
        let (mut q, mut v) = ([0.0; ALL], [0.0; ALL]);
        let period_s = self.known.period_s;
        let mut before = 0.0;
        let ticks = (window.window.first..).zip(&window.directions);
        ticks
            .map(|(tick, &direction)| {
                let counts = q.map(|q: f64| q / self.known.rad_per_count[self.joint]);
                if direction == 0.0 {
                    // At rest, small torques have no effect.
                    (before, v) = (0.0, [0.0; ALL]);
                    return counts;
                }
                let (torques, [by_q, by_v], inertia) = self.linearise(tick, direction);
                if direction * before < 0.0 {
                    // A joint that reverses later decelerates for longer and accelerates for
                    // less.
                    let load = self.known.load[self.joint] * -torques[LOAD] * direction;
                    let dry = (self.model.dry_friction(0.0) + load) * (direction - before);
                    let after = -torques[INERTIA] * inertia;
                    let factor = (after / (after + dry)).clamp(0.0, 1.0);
                    v = v.map(|v| v * factor);
                }
                before = direction;
                for i in 0..ALL {
                    peak[i] = f64::max(peak[i], torques[i].abs());
                    v[i] += (by_q * q[i] + by_v * v[i] + torques[i]) / inertia * period_s;
                    q[i] += v[i] * period_s;
                }
                counts
            })
            .collect()
    }

    /// Torques at unit amplitude at a tick, derivatives of the joint's torque by angle and
    /// speed, and effective inertia.
    fn linearise(&self, tick: usize, direction: f64) -> ([f64; ALL], [f64; 2], f64) {
        /// Steps of finite differences, in rad and rad/s.
        const STEP: f64 = 1e-4;
        let [q, v] = self.trace.states[tick][self.joint];
        let other = self.trace.states[tick][1 - self.joint];
        let motor = |tick: i64| {
            let pwm = self.trace.pwm_at(tick - self.delay_ticks, self.joint);
            self.model.motor_torque(pwm)
        };
        let (before, torque) = (motor(tick as i64 - 1), motor(tick as i64));
        let torque_at = |q: f64, v: f64| {
            let (passive, inertia) = self.model.passive_dynamics(q, v, other);
            let load = self.model.load_friction(q, v, other, torque);
            let dry = self.model.dry_friction(v) + load;
            (passive - dry * direction, inertia)
        };
        let derivative = |a: (f64, f64), b: (f64, f64)| (b.0 - a.0) / (2.0 * STEP);
        let by_state = [
            derivative(torque_at(q - STEP, v), torque_at(q + STEP, v)),
            derivative(torque_at(q, v - STEP), torque_at(q, v + STEP)),
        ];
        let (own, inertia) = torque_at(q, v);
        let acceleration = (own + torque) / inertia;
        let last = self.trace.states.len() - 1;
        let [from, to] = [
            tick.saturating_sub(HALF_WIDTH),
            (tick + HALF_WIDTH).min(last),
        ];
        let speed = |tick: usize| self.trace.states[tick][1 - self.joint][1];
        let other_acceleration =
            (speed(to) - speed(from)) / ((to - from) as f64 * self.known.period_s);
        let torques = [
            -v,
            -direction,
            torque,
            f64::from(u8::from(torque != 0.0)),
            torque - before,
            -acceleration,
            -direction * (-(v / STRIBECK_RAD_S[0]).powi(2)).exp(),
            -direction * (-(v / STRIBECK_RAD_S[1]).powi(2)).exp(),
            -direction * self.model.gear_torque(q, v, other, torque),
            -v * v.abs(),
            -v.abs(),
            torque * torque.abs(),
            (2.0 * q).sin(),
            other_acceleration,
        ];
        (torques, by_state, inertia)
    }
}
