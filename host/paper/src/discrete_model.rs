//! Equation (7): the discrete model, and the arm from which it was computed.

use armbridge_control::arm::{Discrete, Parameters};
use nalgebra::Vector2;

use super::claim::{Claim, Number, Rule};
use super::printed::{MODEL_DECIMALS, PERIOD_S};
use super::text::{list, number};

/// Half of the last digit of (7).
const HALF_DIGIT: f64 = 0.5e-4;

/// Results of the run.
#[derive(Clone, Debug)]
pub struct DiscreteModel {
    /// Euler model of Table 1 with (3) as printed.
    pub printed: Discrete<f64>,
    /// Euler model of the arm that reproduces (7).
    pub reading: Discrete<f64>,
    /// Inertias I1x in kg m^2 that round to (7), with (3) as printed.
    pub i1x_printed: [f64; 2],
    /// Inertias I1x in kg m^2 that round to (7), with `M1 L1^2/4` in (3).
    pub i1x_reading: [f64; 2],
    /// Inertias I2y in kg m^2 that round to (7).
    pub i2y: [f64; 2],
    /// Largest error of an entry of A and of B by Euler's method.
    pub euler_error: [f64; 2],
    /// Poles of (7), joint by joint, and those of the exact model.
    pub poles: [[f64; 4]; 2],
}

impl DiscreteModel {
    /// Linearises and discretises.
    pub fn compute() -> Self {
        let arm = Parameters::<f64>::paper();
        let upright = Vector2::zeros();
        let linear = arm.linearise(upright);
        let (reading, exact) = (linear.euler(PERIOD_S), linear.zero_order_hold(PERIOD_S));
        let literal = Parameters::table_1().with_mass_as_printed();
        let model_7 = Discrete::<f64>::paper();
        let stiffness = arm.gravity_slope(upright);
        let mass = arm.mass(upright);

        let first = [model_7.a.m31, model_7.a.m33, model_7.b.m31];
        let second = [model_7.a.m42, model_7.a.m44, model_7.b.m42];
        let m11 = inertia_interval(first, -stiffness.m11, arm.b1);
        let m22 = inertia_interval(second, -stiffness.m22, arm.b2);
        let other_terms = mass.m11 - arm.i1x;
        let missing_term = arm.i1x - arm.with_mass_as_printed().i1x;
        Self {
            printed: literal.linearise(upright).euler(PERIOD_S),
            reading,
            i1x_printed: m11.map(|m| m - (other_terms - missing_term)),
            i1x_reading: m11.map(|m| m - other_terms),
            i2y: m22.map(|m| m - (mass.m22 - arm.i2y)),
            euler_error: [(reading.a - exact.a).amax(), (reading.b - exact.b).amax()],
            poles: [model_7, exact].map(|model| poles(&model)),
        }
    }

    /// The claim about (7).
    pub fn claims(&self) -> Vec<Claim> {
        let i1x = Parameters::<f64>::table_1().i1x;
        let inertia = |quantity, interval: [f64; 2], rule| {
            // The midpoint represents an interval of one digit in the sixth place.
            let middle = f64::midpoint(interval[0], interval[1]);
            Number::new(quantity, "kg m²", middle, rule)
        };
        let mut reading = entries(&self.reading);
        reading.push(inertia(
            "I1x used for (7), (3) with M₁L₁²/4",
            self.i1x_reading,
            Rule::RoundsTo(i1x, 4),
        ));
        reading.push(inertia(
            "I2y used for (7)",
            self.i2y,
            Rule::RoundsTo(i1x, 4),
        ));
        vec![Claim {
            id: "model",
            title: "Equation (7): the discrete model",
            paper: format!(
                "Linearised at 0 and discretised with Ts = {PERIOD_S} s, the arm of Table 1 \
                 gives (7)."
            ),
            finding: format!(
                "Table 1 with (3) as printed gives A(3,1) = {} instead of {}; {} of the {} entries \
                 compared disagree. With M₁L₁²/4 added to M(1,1) and I1x = I2y = {} kg m², forward \
                 Euler reproduces every entry of (7) to its last digit.",
                number(self.printed.a.m31, 4),
                Discrete::<f64>::paper().a.m31,
                entries(&self.printed).iter().filter(|n| !n.holds()).count(),
                entries(&self.printed).len(),
                Parameters::<f64>::paper().i1x,
            ),
            explanation: format!(
                "(3) lacks M₁L₁²/4, the inertia of link 1's mass at half its length, although G of \
                 (2) contains that mass. With the term, the digits of (7) place I1x between {} and {} kg m², which Table 1 \
                 rounds to {i1x}, and I2y between {} and {}. Without it, I1x would lie between {} \
                 and {}, which rounds to {}. The authors' program therefore contains the term.",
                number(self.i1x_reading[0], 8),
                number(self.i1x_reading[1], 8),
                number(self.i2y[0], 8),
                number(self.i2y[1], 8),
                number(self.i1x_printed[0], 8),
                number(self.i1x_printed[1], 8),
                number(self.i1x_printed[0], 4),
            ),
            remedy: format!(
                "Use the exact zero-order hold. At 45 ms, Euler's method is in error by up to {} in \
                 A and {} in B: it gives the poles {}, where the exact ones are {}.",
                number(self.euler_error[0], 3),
                number(self.euler_error[1], 3),
                list(&self.poles[0], 3),
                list(&self.poles[1], 3),
            ),
            printed: entries(&self.printed),
            reading,
            figures: Vec::new(),
        }]
    }
}

/// The entries other than 0, 1 and the period.
fn entries(model: &Discrete<f64>) -> Vec<Number> {
    let model_7 = Discrete::<f64>::paper();
    [
        ("A(3,1) of (7)", model.a.m31, model_7.a.m31),
        ("A(3,3) of (7)", model.a.m33, model_7.a.m33),
        ("A(4,2) of (7)", model.a.m42, model_7.a.m42),
        ("A(4,4) of (7)", model.a.m44, model_7.a.m44),
        ("B(3,1) of (7)", model.b.m31, model_7.b.m31),
        ("B(4,2) of (7)", model.b.m42, model_7.b.m42),
    ]
    .map(|(entry, found, printed)| {
        Number::new(entry, "", found, Rule::RoundsTo(printed, MODEL_DECIMALS))
    })
    .into()
}

/// Interval of the inertia in kg m^2 for which Euler's entries of one joint round to the
/// printed ones: `stiffness T/M`, `1 - b T/M` and `T/M`.
fn inertia_interval([angle, speed, torque]: [f64; 3], stiffness: f64, damping: f64) -> [f64; 2] {
    let interval = |numerator: f64, entry: f64| {
        [HALF_DIGIT, -HALF_DIGIT].map(|half| numerator * PERIOD_S / (entry + half))
    };
    let intervals = [
        interval(stiffness, angle),
        interval(damping, 1.0 - speed),
        interval(1.0, torque),
    ];
    intervals
        .into_iter()
        .fold([0.0, f64::INFINITY], |[low, high], next| {
            [f64::max(low, next[0]), f64::min(high, next[1])]
        })
}

/// Larger and smaller pole of joint 1, then of joint 2; all poles are real.
fn poles(model: &Discrete<f64>) -> [f64; 4] {
    let [first, second] = model.joints().map(|joint| {
        let values = joint.complex_eigenvalues().map(|value| value.re);
        [values.max(), values.min()]
    });
    [first[0], first[1], second[0], second[1]]
}
