//! Poles of the closed loop.

use nalgebra::{Complex, Matrix3};
use serde::Serialize;

use super::model::{LinearLoop, Observer};

/// Magnitude in z below which a pole is a delay.
const DELAY_RADIUS: f64 = 1e-6;

/// An eigenvalue, or a conjugate pair.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Pole {
    /// Real part, in z.
    pub re: f64,
    /// Imaginary part, in z, not negative; if above 0, the conjugate is a pole too.
    pub im: f64,
    /// Magnitude: decay factor per period.
    pub radius: f64,
    /// Natural frequency in rad/s of the equivalent continuous pole, `|ln z| / T`.
    pub natural_rad_s: f64,
    /// Damping ratio of that pole, `-Re(ln z) / |ln z|`; 1 for a real pole that decays.
    pub damping: f64,
}

/// Poles of the loop, in order of natural frequency.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Poles {
    /// Poles of the arm under full state feedback.
    pub controller: Vec<Pole>,
    /// Poles of the estimation error, joint by joint; none for an estimator whose error
    /// depends on the controller.
    pub estimator: Vec<Pole>,
    /// Poles of the loop, if controller and estimator cannot be separated.
    pub together: Vec<Pole>,
}

impl Pole {
    fn from_discrete(z: Complex<f64>, period_s: f64) -> Self {
        let radius = z.re.hypot(z.im);
        let (decay, turn) = (-radius.ln() / period_s, z.im.atan2(z.re) / period_s);
        let natural_rad_s = decay.hypot(turn);
        Self {
            re: z.re,
            im: z.im,
            radius,
            natural_rad_s,
            damping: decay / natural_rad_s,
        }
    }
}

impl Poles {
    pub(super) fn from_loop(system: &LinearLoop) -> Self {
        let discrete = &system.discrete;
        let poles = |z: &[Complex<f64>]| poles(z, system.period_s);
        if system.observers.iter().all(|observer| observer.is_separate) {
            let error_poles = |observer: &Observer| poles(&error_eigenvalues(observer));
            // The torque of a joint without integral action is a pole at 0.
            let regulated = system.integral.closed_loop(discrete, &system.gain);
            Self {
                controller: poles(regulated.complex_eigenvalues().as_slice()),
                estimator: system.observers.iter().flat_map(error_poles).collect(),
                together: Vec::new(),
            }
        } else {
            Self {
                together: poles(system.closed().complex_eigenvalues().as_slice()),
                ..Self::default()
            }
        }
    }

    /// All poles with the name of their group.
    pub fn all(&self) -> impl Iterator<Item = (&'static str, &Pole)> {
        let named = |name| move |pole| (name, pole);
        let controller = self.controller.iter().map(named("controller"));
        let estimator = self.estimator.iter().map(named("estimator"));
        let together = self.together.iter().map(named("loop"));
        controller.chain(estimator).chain(together)
    }
}

fn error_eigenvalues(observer: &Observer) -> Vec<Complex<f64>> {
    let memory: Matrix3<f64> = observer.memory.fixed_view::<3, 3>(0, 0).into_owned();
    memory.complex_eigenvalues().as_slice().to_vec()
}

fn poles(eigenvalues: &[Complex<f64>], period_s: f64) -> Vec<Pole> {
    let mut poles: Vec<Pole> = eigenvalues
        .iter()
        // The upper pole of a pair represents both.
        .filter(|z| z.im >= 0.0 && z.re.hypot(z.im) > DELAY_RADIUS)
        .map(|z| Pole::from_discrete(*z, period_s))
        .collect();
    poles.sort_by(|a, b| a.natural_rad_s.total_cmp(&b.natural_rad_s));
    poles
}
