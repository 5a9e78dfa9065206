//! Whether the model has the right form: torques that it lacks, tried one by one.
//!
//! A small torque more moves a joint a little more, which follows from the equation of
//! motion made linear about what was measured. How much of the errors such a torque takes
//! away, beyond what the model's own numbers could by being a little different, is a
//! number whose square is that of a standard normal one if the model is right. The same
//! way it follows what would be found without dry friction in the model.

use nalgebra::{DMatrix, DVector};
use serde::Serialize;

use super::super::arm::{Joint, Known};
use super::super::dataset::Trace;
use super::super::fit_result::Found;
use super::super::quantity::Quantity;
use super::super::stribeck_curve::Falling;
use super::rollout::Followed;

/// Torques that the model has: viscous and dry friction, motor, its offset, its delay,
/// inertia. Gravity is not among them: the weight is known, and without it all of them
/// together would be nothing, the equation of motion itself.
const OWN: usize = 6;
const VISCOUS: usize = 0;
const DRY: usize = 1;
const INERTIA: usize = 5;
/// Torques that it lacks.
const MISSING: [&str; 7] = [
    "dry friction falling up to 0.3 rad/s (Stribeck)",
    "dry friction falling up to 1 rad/s (Stribeck)",
    "friction proportional to speed squared",
    "viscous friction by direction",
    "motor torque not proportional to PWM",
    "torque of twice the joint angle",
    "torque of the other joint's acceleration",
];
const ALL: usize = OWN + MISSING.len();
/// Speeds of the first two.
const FALLS_RAD_S: [f64; 2] = [0.3, 1.0];
/// Improvement in variances that is not by chance: 5 standard deviations.
pub(super) const SURE: f64 = 25.0;
/// Torque in N m below which a missing one is of no matter.
pub(super) const SMALL_NM: f64 = 2e-3;
/// Ticks on either side over which the other joint's acceleration is taken.
const AROUND: usize = 15;

/// How much better the logs were explained by a torque that the model has not.
#[derive(Clone, Debug, Serialize)]
pub struct Form {
    /// From 1.
    pub joint: usize,
    /// The torque.
    pub what: &'static str,
    /// Reduction in the sum of squares, in noise variances: about 1 by chance.
    pub improvement: f64,
    /// The torque where it is largest, in N m.
    pub torque_nm: f64,
}

/// What would become of the fit without dry friction.
#[derive(Clone, Debug, Serialize)]
pub struct Dry {
    /// From 1.
    pub joint: usize,
    /// Increase in the sum of squares, in noise variances.
    pub worse: f64,
    /// Root mean square of an error in counts, with dry friction and without.
    pub rms_counts: [f64; 2],
    /// Viscous friction in N m s/rad with dry friction, and what takes its place without.
    pub viscous: [f64; 2],
}

/// Sums over windows, of torques' effects and of errors.
struct Sums {
    /// Products of the effects.
    normal: DMatrix<f64>,
    /// Products with the errors.
    right: DVector<f64>,
    /// Squares of the errors, and their number.
    squares: f64,
    count: f64,
    /// The largest of each torque, per unit.
    most: [f64; ALL],
}

/// How a joint's dry friction falls with speed, if a torque that does surely explains its
/// windows better; roughly, and only for those that are explained.
pub(super) fn falling(
    joint: usize,
    windows: &[&Followed],
    traces: &[Trace],
    known: &Known,
    found: &Found,
) -> Option<Falling> {
    let sums = sums(joint, windows, traces, known, found);
    let own: Vec<usize> = (0..OWN).collect();
    let rest = sums.rest(&own, 0.0).0;
    let least = rest - SURE * found.noise_counts.powi(2);
    let tried = FALLS_RAD_S
        .into_iter()
        .zip(OWN..)
        .map(|(speed_rad_s, column)| {
            let (less, drop_nm) = sums.rest_with(column);
            let falling = Falling {
                drop_nm,
                speed_rad_s,
            };
            (less, falling)
        });
    let sure = tried.filter(|(less, falling)| *less < least && falling.drop_nm > SMALL_NM);
    let best = sure.min_by(|a, b| a.0.total_cmp(&b.0));
    best.map(|(_, falling)| falling)
}

/// Of the windows of a joint that are explained.
pub(super) fn forms(
    joint: usize,
    windows: &[&Followed],
    traces: &[Trace],
    known: &Known,
    found: &Found,
) -> (Vec<Form>, Dry) {
    let sums = sums(joint, windows, traces, known, found);
    let variance = found.noise_counts.powi(2);
    let own: Vec<usize> = (0..OWN).collect();
    let rest = sums.rest(&own, 0.0).0;
    let forms = MISSING.into_iter().zip(OWN..).map(|(what, column)| {
        let (less, number) = sums.rest_with(column);
        Form {
            joint: joint + 1,
            what,
            improvement: (rest - less) / variance,
            torque_nm: (number * sums.most[column]).abs(),
        }
    });
    let forms = forms.collect();
    let number = |quantity| found.number(joint, quantity).0;
    let (coulomb, viscous) = (number(Quantity::Coulomb), number(Quantity::Viscous));
    let rough: Vec<usize> = own
        .iter()
        .copied()
        .filter(|column| *column != DRY)
        .collect();
    let (without, numbers) = sums.rest(&rough, coulomb);
    let dry = Dry {
        joint: joint + 1,
        worse: (without - rest) / variance,
        rms_counts: [rest, without].map(|rest| (rest.max(0.0) / sums.count).sqrt()),
        viscous: [viscous, viscous + numbers[VISCOUS]],
    };
    (forms, dry)
}

impl Sums {
    /// What is left of the errors when one torque that the model lacks explains them beside its
    /// own, and how much of it.
    fn rest_with(&self, column: usize) -> (f64, f64) {
        let with: Vec<usize> = (0..OWN).chain([column]).collect();
        let (less, numbers) = self.rest(&with, 0.0);
        (less, numbers[OWN])
    }

    /// Reduction of the errors by these torques, and the share of each; `dry` is the share
    /// of dry friction that is taken out of the model first.
    fn rest(&self, columns: &[usize], dry: f64) -> (f64, Vec<f64>) {
        let squares =
            self.squares + 2.0 * dry * self.right[DRY] + dry * dry * self.normal[(DRY, DRY)];
        let right = |i: usize| self.right[i] + dry * self.normal[(i, DRY)];
        // Torques of one size each, so that none is lost in rounding.
        let size = |i: usize| self.normal[(i, i)].max(1e-30).sqrt();
        let n = columns.len();
        let matrix = DMatrix::from_fn(n, n, |a, b| {
            let (i, j) = (columns[a], columns[b]);
            self.normal[(i, j)] / (size(i) * size(j))
        });
        let vector = DVector::from_fn(n, |a, _| right(columns[a]) / size(columns[a]));
        let solution = matrix.svd(true, true).solve(&vector, 1e-9);
        let solution = solution.unwrap_or_else(|_| DVector::zeros(n));
        let numbers = (0..n).map(|a| solution[a] / size(columns[a])).collect();
        (squares - solution.dot(&vector), numbers)
    }
}

fn sums(
    joint: usize,
    windows: &[&Followed],
    traces: &[Trace],
    known: &Known,
    found: &Found,
) -> Sums {
    let model = Joint::of(known, &found.at, joint);
    let delay = model.delay_ticks(known);
    let mut sums = Sums {
        normal: DMatrix::zeros(ALL, ALL),
        right: DVector::zeros(ALL),
        squares: 0.0,
        count: 0.0,
        most: [0.0; ALL],
    };
    for window in windows {
        let effect = Effect {
            model: &model,
            joint,
            known,
            trace: &traces[window.window.trace],
            delay_ticks: delay.round() as i64,
        };
        let effects = effect.of(window, &mut sums.most);
        let blocks = window.blocks_with(&effects);
        let start = DMatrix::from_fn(blocks.len(), 2, |i, j| blocks[i].0.slope[j]);
        let errors = DVector::from_fn(blocks.len(), |i, _| blocks[i].0.error);
        let more = DMatrix::from_fn(blocks.len(), ALL, |i, j| blocks[i].1[j]);
        let Some(inverse) = (start.transpose() * &start).try_inverse() else {
            continue;
        };
        let onto = inverse * start.transpose();
        let errors = &errors - &start * (&onto * &errors);
        let more = &more - &start * (&onto * &more);
        sums.normal += more.transpose() * &more;
        sums.right += more.transpose() * &errors;
        sums.squares += errors.norm_squared();
        sums.count += blocks.len() as f64;
    }
    sums
}

/// How torques more would move a joint.
struct Effect<'a> {
    model: &'a Joint<f64>,
    joint: usize,
    known: &'a Known,
    trace: &'a Trace,
    delay_ticks: i64,
}

impl Effect<'_> {
    /// Counts for 1 N m of each torque, tick by tick.
    fn of(&self, window: &Followed, most: &mut [f64; ALL]) -> Vec<[f64; ALL]> {
        let (mut q, mut v) = ([0.0; ALL], [0.0; ALL]);
        let period_s = self.known.period_s;
        let mut before = 0.0;
        let ticks = (window.window.first..).zip(&window.ways);
        ticks
            .map(|(tick, &way)| {
                let counts = q.map(|q: f64| q / self.known.rad_per_count[self.joint]);
                if way == 0.0 {
                    // It stands, whatever pushes a little more.
                    (before, v) = (0.0, [0.0; ALL]);
                    return counts;
                }
                let (torques, [by_q, by_v], mass) = self.at(tick, way);
                if way * before < 0.0 {
                    // A joint that turns round later is slowed for longer and pushed on for
                    // less.
                    let dry = self.model.dry(0.0) * (way - before);
                    let after = -torques[INERTIA] * mass;
                    let less = (after / (after + dry)).clamp(0.0, 1.0);
                    v = v.map(|v| v * less);
                }
                before = way;
                for i in 0..ALL {
                    most[i] = f64::max(most[i], torques[i].abs());
                    v[i] += (by_q * q[i] + by_v * v[i] + torques[i]) / mass * period_s;
                    q[i] += v[i] * period_s;
                }
                counts
            })
            .collect()
    }

    /// The torques per unit at a tick, how the joint's own depends on angle and speed, and
    /// what it accelerates.
    fn at(&self, tick: usize, way: f64) -> ([f64; ALL], [f64; 2], f64) {
        /// Steps over which a slope is taken, in rad and rad/s.
        const STEP: f64 = 1e-4;
        let [q, v] = self.trace.smooth[tick][self.joint];
        let other = self.trace.smooth[tick][1 - self.joint];
        let push = |q: f64, v: f64| {
            let (push, mass) = self.model.push(q, v, other);
            (push - self.model.dry(v) * way, mass)
        };
        let slope = |a: (f64, f64), b: (f64, f64)| (b.0 - a.0) / (2.0 * STEP);
        let by = [
            slope(push(q - STEP, v), push(q + STEP, v)),
            slope(push(q, v - STEP), push(q, v + STEP)),
        ];
        let motor = |tick: i64| {
            let pwm = self.trace.pwm_at(tick - self.delay_ticks, self.joint);
            self.model.torque(pwm)
        };
        let (before, torque) = (motor(tick as i64 - 1), motor(tick as i64));
        let (own, mass) = push(q, v);
        let acceleration = (own + torque) / mass;
        let last = self.trace.smooth.len() - 1;
        let [from, to] = [tick.saturating_sub(AROUND), (tick + AROUND).min(last)];
        let speed = |tick: usize| self.trace.smooth[tick][1 - self.joint][1];
        let others = (speed(to) - speed(from)) / ((to - from) as f64 * self.known.period_s);
        let torques = [
            -v,
            -way,
            torque,
            f64::from(u8::from(torque != 0.0)),
            torque - before,
            -acceleration,
            -way * (-(v / FALLS_RAD_S[0]).powi(2)).exp(),
            -way * (-(v / FALLS_RAD_S[1]).powi(2)).exp(),
            -v * v.abs(),
            -v.abs(),
            torque * torque.abs(),
            (2.0 * q).sin(),
            others,
        ];
        (torques, by, mass)
    }
}
