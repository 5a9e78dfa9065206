//! Equations (1) to (4): the effect of the printed Coriolis matrix on energy, and
//! the equilibria.
//!
//! Without friction and torque, energy is conserved. Its drift over a fast
//! motion of both joints shows whether a Coriolis term is correct, without a derivation.

use core::f64::consts::PI;

use armbridge_control::arm::{Parameters, State};
use nalgebra::{Vector2, Vector4};

use super::chart::{CORRECTED, Chart, Curve, Figure, MODEL, PLACED, Subplot, WRONG};
use super::claim::{Claim, Number, Rule};
use super::text::{digits, number};

/// Initial state of the motion: angles in rad, speeds in rad/s.
const START: [f64; 4] = [0.5, 0.6, 2.0, -3.0];
const STEP_S: f64 = 1e-3;
const STEPS: u32 = 3000;
/// Tolerance of the Runge-Kutta integration over those steps, in J.
const ROUNDING_J: f64 = 1e-9;
/// Smallest drift that is an error of the model, in J: 2 % of the energy.
const WRONG_J: f64 = 0.01;

/// A reading of (4).
#[derive(Clone, Copy, Debug)]
struct Reading {
    /// `Co = -B`: the sign of a Lagrangian derivation.
    sign_corrected: bool,
    /// `M2 L2^2/4` instead of `L2/4`.
    dimension_corrected: bool,
}

/// Results of the run.
#[derive(Clone, Debug)]
pub struct Dynamics {
    /// Largest drift in J with (4) as printed, with only its sign corrected, with
    /// only its `L2/4` corrected, and with both.
    pub drift_j: [f64; 4],
    energy_j: f64,
    drifts: [Vec<(f64, f64)>; 4],
    /// Both stiffnesses in N m/rad about each of the four equilibria.
    pub stiffness: [[f64; 2]; 4],
    /// Largest gravity torque in N m at the equilibria.
    pub largest_torque_nm: f64,
}

/// Angles of joints 1 and 2 in rad at which gravity exerts no torque.
const EQUILIBRIA: [[f64; 2]; 4] = [[0.0, 0.0], [PI, 0.0], [0.0, PI], [PI, PI]];

impl Dynamics {
    /// Simulates the motion with each reading.
    pub fn compute() -> Self {
        let readings = [(false, false), (true, false), (false, true), (true, true)];
        let arm = Parameters {
            b1: 0.0,
            b2: 0.0,
            ..Parameters::table_1().with_mass_as_printed()
        };
        let drifts = readings.map(|(sign_corrected, dimension_corrected)| {
            drift(
                &arm,
                Reading {
                    sign_corrected,
                    dimension_corrected,
                },
            )
        });
        let worst =
            |drift: &Vec<(f64, f64)>| drift.iter().map(|(_, d)| d.abs()).fold(0.0, f64::max);
        let full = Parameters::paper();
        let stiffness = EQUILIBRIA.map(|q| {
            let slope = full.gravity_slope(Vector2::from(q));
            [slope.m11, slope.m22]
        });
        let torque = EQUILIBRIA.map(|q| full.gravity(Vector2::from(q)).amax());
        Self {
            drift_j: [0, 1, 2, 3].map(|i| worst(&drifts[i])),
            energy_j: arm.energy(&State::from_vector(Vector4::from(START))),
            drifts,
            stiffness,
            largest_torque_nm: torque.into_iter().fold(0.0, f64::max),
        }
    }

    /// The claims about (1) to (4).
    pub fn claims(&self) -> Vec<Claim> {
        vec![self.coriolis(), self.equilibria()]
    }

    fn coriolis(&self) -> Claim {
        let [printed, sign, dimension, both] = self.drift_j;
        let drift = |quantity, found, rule| Number::new(quantity, "J", found, rule);
        let name = "Energy drift, ";
        Claim {
            id: "coriolis",
            title: "Equation (4): the Coriolis matrix",
            paper: "The Coriolis matrix is B of (4); (1) subtracts Co(q, q̇) q̇ from the \
                    torque, with Co = B."
                .into(),
            finding: format!(
                "Without friction and torque, the arm's energy of {} J must stay constant. With B \
                 as printed it drifts by up to {} J within {} s. With the sign reversed and M₂L₂²/4 \
                 instead of L₂/4, the drift is {} J, which is rounding.",
                number(self.energy_j, 4),
                number(printed, 3),
                number(f64::from(STEPS) * STEP_S, 0),
                digits(both, 2),
            ),
            explanation: format!(
                "B contains two errors. The sign: (4) gives the term as it appears on the \
                 right-hand side of the equation of motion, but (1) subtracts it. The dimension: \
                 L₂/4 in B(2,1) is a length among moments of inertia; it should read M₂L₂²/4, as \
                 in B(1,1). Correcting only one leaves a drift: {} J with only the sign corrected, \
                 {} J with only the dimension corrected.",
                number(sign, 3),
                number(dimension, 3),
            ),
            remedy:
                "Set Co = −B with M₂L₂²/4. The library uses Christoffel symbols, which give the \
                     same torque and make dM/dt − 2 Co skew-symmetric."
                    .into(),
            printed: vec![drift(
                format!("{name}(4) as printed"),
                printed,
                Rule::AtMost(ROUNDING_J),
            )],
            reading: vec![
                drift(format!("{name}both mended"), both, Rule::AtMost(ROUNDING_J)),
                drift(
                    format!("{name}only the sign corrected"),
                    sign,
                    Rule::AtLeast(WRONG_J),
                ),
                drift(
                    format!("{name}only the dimension corrected"),
                    dimension,
                    Rule::AtLeast(WRONG_J),
                ),
            ],
            figures: vec![self.figure()],
        }
    }

    fn figure(&self) -> Figure {
        let curves = [
            ("as printed", WRONG),
            ("sign mended", PLACED),
            ("L₂/4 mended", MODEL),
            ("both", CORRECTED),
        ];
        let curves = curves
            .into_iter()
            .zip(&self.drifts)
            .map(|((name, stroke), points)| Curve::new(name, stroke, points.clone()));
        Figure {
            name: "energy",
            paper_figure: None,
            caption:
                "Energy of the arm of Table 1, relative to its initial energy, in free motion \
                      of both joints, for four readings of (4). The correct one gives a horizontal \
                      line."
                    .into(),
            chart: Chart {
                title: "Energy without friction and torque",
                x_title: "time (s)",
                x: [0.0, f64::from(STEPS) * STEP_S],
                panels: vec![Subplot::new("", "energy gained (J)", curves.collect())],
            },
        }
    }

    fn equilibria(&self) -> Claim {
        let [up, down, ..] = self.stiffness;
        let saddles = self.stiffness.iter().filter(|s| s[0] * s[1] < 0.0).count();
        let stiffness = |quantity, found, rule| Number::new(quantity, "N m/rad", found, rule);
        Claim {
            id: "equilibria",
            title: "The equilibria",
            paper: "The arm has four equilibria; upright is unstable, hanging down is stable."
                .into(),
            finding: format!(
                "The gravity torque vanishes at (0, 0), (π, 0), (0, π) and (π, π), where it is at \
                 most {} N m. The stiffness of gravity is {} and {} N m/rad about upright, and {} \
                 and {} N m/rad about hanging down.",
                digits(self.largest_torque_nm, 1),
                number(up[0], 4),
                number(up[1], 4),
                number(down[0], 4),
                number(down[1], 4),
            ),
            explanation: format!(
                "This holds with each row of (2) halved: the 2 printed below each row is a \
                 denominator. The other {saddles} equilibria are saddles, stable for one joint \
                 only; the paper calls them unattainable."
            ),
            remedy: "No correction is needed.".into(),
            printed: vec![
                Number::new(
                    "Largest gravity torque at the four equilibria",
                    "N m",
                    self.largest_torque_nm,
                    Rule::AtMost(1e-12),
                ),
                stiffness(
                    "Larger stiffness about upright",
                    up[0].max(up[1]),
                    Rule::AtMost(0.0),
                ),
                stiffness(
                    "Smaller stiffness about hanging down",
                    down[0].min(down[1]),
                    Rule::AtLeast(0.0),
                ),
            ],
            reading: Vec::new(),
            figures: Vec::new(),
        }
    }
}

/// Energy gained over time, in J.
fn drift(arm: &Parameters<f64>, reading: Reading) -> Vec<(f64, f64)> {
    let mut state = State::from_vector(Vector4::from(START));
    let start_j = arm.energy(&state);
    (0..=STEPS)
        .map(|i| {
            let point = (f64::from(i) * STEP_S, arm.energy(&state) - start_j);
            state = runge_kutta(&state, |x| acceleration(arm, x, reading));
            point
        })
        .collect()
}

/// A fourth-order Runge-Kutta step of `ddq = acceleration(state)`.
fn runge_kutta(
    state: &State<f64>,
    acceleration: impl Fn(&State<f64>) -> Vector2<f64>,
) -> State<f64> {
    let slope = |x| {
        let state = State::from_vector(x);
        let ddq = acceleration(&state);
        State {
            q: state.dq,
            dq: ddq,
        }
        .to_vector()
    };
    let x = state.to_vector();
    let k1 = slope(x);
    let k2 = slope(x + k1 * (STEP_S / 2.0));
    let k3 = slope(x + k2 * (STEP_S / 2.0));
    let k4 = slope(x + k3 * STEP_S);
    State::from_vector(x + (k1 + k2 * 2.0 + k3 * 2.0 + k4) * (STEP_S / 6.0))
}

/// Acceleration by (1) without friction and torque, with Co from a reading of (4).
fn acceleration(arm: &Parameters<f64>, state: &State<f64>, reading: Reading) -> Vector2<f64> {
    let State { q, dq } = *state;
    let link = arm.m2 * arm.l2 * arm.l2 / 4.0;
    let spread = arm.i2x - arm.i2z;
    let coupling = arm.l1 * arm.l2 * arm.m2 * q.y.sin();
    let quarter = if reading.dimension_corrected {
        link
    } else {
        arm.l2 / 4.0
    };
    let b11 = dq.y * ((2.0 * q.y).sin() * (link + spread) + coupling);
    let b21 = -dq.x * ((2.0 * q.y).sin() / 2.0 * (spread + quarter) + coupling / 2.0);
    let b = Vector2::new(b11, b21) * dq.x;
    let coriolis = if reading.sign_corrected { -b } else { b };
    (-coriolis - arm.gravity(q)).component_div(&arm.mass(q).diagonal())
}
