//! Equations (10) and (12): the gains that the paper's own models and weights give.

use armbridge_control::arm::Discrete;
use armbridge_control::controller::{Lqr, Weights};
use armbridge_control::design::placement::{Poles, prediction_gain};
use armbridge_servo::JOINTS;
use nalgebra::{Matrix2, Matrix2x4, Vector2};

use super::claim::{Claim, Number, Rule};
use super::printed::{GAIN_DECIMALS, OBSERVER, POLES};
use super::text::list;
use super::{DesignError, JOINT_NAMES};

/// Results of the run.
#[derive(Clone, Debug)]
pub struct Gains {
    /// Optimal gain for (7) and (8).
    pub k: Matrix2x4<f64>,
    /// Observer gains on angle and speed for the printed poles, in the pairing
    /// that comes nearest to (12).
    pub placed: [Vector2<f64>; JOINTS],
    /// Poles of that pairing.
    pub placed_poles: [[f64; 2]; JOINTS],
    /// Poles of the observer with (12), larger first.
    pub poles_of_12: [[f64; 2]; JOINTS],
    /// Pole pairs on a grid of 0.05 whose gains, cut to two decimals, are (12).
    pub slow_poles: [Vec<[f64; 2]>; JOINTS],
    /// Gains of the first of those pairs.
    pub slow: [Vector2<f64>; JOINTS],
}

/// Step of the grid of poles: poles chosen by hand have few digits.
const GRID: f64 = 0.05;

/// Two poles for each joint.
type PolePairs = [[f64; 2]; JOINTS];

/// All pairings of the printed poles, two for each joint.
const PAIRINGS: [[usize; 4]; 6] = [
    [0, 1, 2, 3],
    [0, 2, 1, 3],
    [0, 3, 1, 2],
    [1, 2, 0, 3],
    [1, 3, 0, 2],
    [2, 3, 0, 1],
];

impl Gains {
    /// Solves the Riccati equation and places poles.
    ///
    /// # Errors
    ///
    /// See [`DesignError`].
    pub fn compute() -> Result<Self, DesignError> {
        let model = Discrete::paper();
        let joints = model.joints();
        let (placed_poles, placed) = nearest_pairing(&joints)?;
        let slow_poles = [0, 1].map(|j| pairs_that_give(&joints[j], OBSERVER[j]));
        let slow = |j: usize| match slow_poles[j].first() {
            Some(poles) => gain(&joints[j], *poles),
            None => Ok(Vector2::repeat(f64::NAN)),
        };
        Ok(Self {
            k: Lqr::design(&model, &Weights::paper())?.gain,
            placed,
            placed_poles,
            poles_of_12: [0, 1].map(|j| poles(&joints[j], OBSERVER[j])),
            slow: [slow(0)?, slow(1)?],
            slow_poles,
        })
    }

    /// The claims about (10) and (12).
    pub fn claims(&self) -> Vec<Claim> {
        vec![self.lqr_claim(), self.observer_claim()]
    }

    fn lqr_claim(&self) -> Claim {
        let printed = Lqr::<f64>::paper().gain;
        let places = [(0, 0), (0, 2), (1, 1), (1, 3)];
        let values = places.map(|at| self.k[at]);
        let coupling = self.k.map_with_location(
            |row, column, k| {
                if column % JOINTS == row { 0.0 } else { k.abs() }
            },
        );
        let mut numbers: Vec<_> = places
            .iter()
            .map(|&(row, column)| {
                let entry = format!("K({},{}) of (10)", row + 1, column + 1);
                let rule = Rule::CutsTo(printed[(row, column)], GAIN_DECIMALS);
                Number::new(entry, "", self.k[(row, column)], rule)
            })
            .collect();
        numbers.push(Number::new(
            "Largest gain between different joints",
            "",
            coupling.max(),
            Rule::AtMost(1e-9),
        ));
        Claim {
            id: "lqr",
            title: "Equation (10): the LQR gain",
            paper: format!(
                "With (7), Q = diag({}) and R = diag({}) the gain is (10).",
                list(&Weights::<f64>::paper().q, 0),
                list(&Weights::<f64>::paper().r, 0),
            ),
            finding: format!(
                "The Riccati equation with (7) and (8) gives {}. Cut to two decimals, this is (10).",
                list(&values, 4)
            ),
            explanation: format!(
                "The printed gain is cut, not rounded: rounded, it would read {}. No other weights \
                 are needed.",
                list(&values, 2)
            ),
            remedy: "No correction is needed; the board computes the gain with all digits.".into(),
            printed: numbers,
            reading: Vec::new(),
            figures: Vec::new(),
        }
    }

    fn observer_claim(&self) -> Claim {
        let numbers = |poles: [[f64; 2]; JOINTS], gains: [Vector2<f64>; JOINTS]| {
            let mut numbers = Vec::new();
            for joint in 0..JOINTS {
                for (entry, state) in ["angle", "speed"].into_iter().enumerate() {
                    numbers.push(Number::new(
                        format!(
                            "L of (12) on {state}, {}, poles {}",
                            JOINT_NAMES[joint],
                            list(&poles[joint], 2)
                        ),
                        "",
                        gains[joint][entry],
                        Rule::CutsTo(OBSERVER[joint][entry], GAIN_DECIMALS),
                    ));
                }
            }
            numbers
        };
        let slow_poles = [0, 1].map(|j| {
            let first = self.slow_poles[j].first();
            first.copied().unwrap_or([f64::NAN; 2])
        });
        let mut reading = numbers(slow_poles, self.slow);
        reading.push(Number::new(
            format!("Pole pairs on a grid of {GRID} that give (12), both joints"),
            "",
            (self.slow_poles[0].len() * self.slow_poles[1].len()) as f64,
            Rule::Within(1.0, 0.0),
        ));
        Claim {
            id: "observer-gain",
            title: "Equation (12): the observer gain",
            paper: format!(
                "Pole placement with p = [{}] gives (12).",
                POLES.map(|p| p.to_string()).join(" ")
            ),
            finding: format!(
                "(12) places the poles at {} for joint 1 and {} for joint 2, far from p. The poles \
                 p need gains several times as large: {} and {} for the pairing nearest to (12).",
                list(&self.poles_of_12[0], 4),
                list(&self.poles_of_12[1], 4),
                list(self.placed[0].as_slice(), 2),
                list(self.placed[1].as_slice(), 2),
            ),
            explanation: format!(
                "Of all pole pairs on a grid of {GRID}, only {{{}}} for joint 1 and {{{}}} for \
                 joint 2 give (12), cut to two decimals like (10); their exact gains are {} and \
                 {}. Therefore p and (12) belong to two designs, and (12) is a slow one.",
                list(&slow_poles[0], 2),
                list(&slow_poles[1], 2),
                list(self.slow[0].as_slice(), 4),
                list(self.slow[1].as_slice(), 4),
            ),
            remedy: format!(
                "About upright the joints are decoupled: pole placement is two problems of two \
                 states, each with a unique gain. For {{{}}} on joint 1 and {{{}}} on joint 2 the \
                 gains are {} and {}.",
                list(&self.placed_poles[0], 2),
                list(&self.placed_poles[1], 2),
                list(self.placed[0].as_slice(), 4),
                list(self.placed[1].as_slice(), 4),
            ),
            printed: numbers(self.placed_poles, self.placed),
            reading,
            figures: Vec::new(),
        }
    }
}

/// Pairing of the printed poles whose gains are nearest to (12), and the gains.
fn nearest_pairing(
    joints: &[Matrix2<f64>; JOINTS],
) -> Result<(PolePairs, [Vector2<f64>; JOINTS]), DesignError> {
    let mut nearest: Option<(f64, PolePairs, _)> = None;
    for pairing in PAIRINGS {
        let [a, b, c, d] = pairing.map(|i| POLES[i]);
        let poles = [[a, b], [c, d]];
        let gains = [gain(&joints[0], poles[0])?, gain(&joints[1], poles[1])?];
        let distance = (0..JOINTS)
            .map(|j| (gains[j] - Vector2::from(OBSERVER[j])).amax())
            .fold(0.0, f64::max);
        if nearest.is_none_or(|(least, ..)| distance < least) {
            nearest = Some((distance, poles, gains));
        }
    }
    // There are six pairings, so there is a nearest one.
    nearest
        .map(|(_, poles, gains)| (poles, gains))
        .ok_or(DesignError::Pairing)
}

fn gain(a: &Matrix2<f64>, [p1, p2]: [f64; 2]) -> Result<Vector2<f64>, DesignError> {
    Ok(prediction_gain(a, Poles::Real(p1, p2))?)
}

/// Pairs p1 <= p2 on the grid whose gains, cut to two decimals, are the printed ones.
fn pairs_that_give(a: &Matrix2<f64>, printed: [f64; 2]) -> Vec<[f64; 2]> {
    let last = (1.0 / GRID).round() as u32;
    let grid = |i: u32| f64::from(i) / f64::from(last);
    let pairs = (1..last).flat_map(|i| (i..last).map(move |j| [grid(i), grid(j)]));
    let gives = |poles: &[f64; 2]| {
        gain(a, *poles).is_ok_and(|l| {
            (0..2).all(|entry| Rule::CutsTo(printed[entry], GAIN_DECIMALS).holds(l[entry]))
        })
    };
    pairs.filter(gives).collect()
}

/// Both poles of a joint's observer, larger first; NaN if complex.
fn poles(a: &Matrix2<f64>, [l_angle, l_speed]: [f64; 2]) -> [f64; 2] {
    let error = a - Matrix2::new(l_angle, 0.0, l_speed, 0.0);
    let (half, product) = (error.trace() / 2.0, error.determinant());
    let root = (half * half - product).sqrt();
    [half + root, half - root]
}
