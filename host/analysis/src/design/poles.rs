//! Where the poles of the closed loop are.

use nalgebra::{Complex, Matrix3};
use serde::Serialize;

use super::model::{Loop, Observer};

/// Smaller in z, and a pole is a delay.
const NOTHING: f64 = 1e-6;

/// An eigenvalue, or a conjugate pair of them.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Pole {
    /// Real part, in z.
    pub re: f64,
    /// Imaginary part, in z, not negative; if above 0, the conjugate is a pole too.
    pub im: f64,
    /// Distance from 0: what is left after each period.
    pub radius: f64,
    /// Natural frequency in rad/s of the continuous pole that it samples, `|ln z| / T`.
    pub natural_rad_s: f64,
    /// Its damping ratio, `-Re(ln z) / |ln z|`; 1 for a real pole that decays.
    pub damping: f64,
}

/// The poles of the loop, fast ones last.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Poles {
    /// Of the arm under the gain, were the state known.
    pub controller: Vec<Pole>,
    /// Of the estimation error, joint by joint; none for an estimator whose error depends
    /// on the controller.
    pub estimator: Vec<Pole>,
    /// Of both together, where they cannot be separated.
    pub together: Vec<Pole>,
}

impl Pole {
    fn of(z: Complex<f64>, period_s: f64) -> Self {
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
    pub(super) fn of(parts: &Loop) -> Self {
        let discrete = &parts.discrete;
        let one = |z: &[Complex<f64>]| poles(z, parts.period_s);
        if parts.observers.iter().all(|observer| observer.is_separate) {
            let regulated = discrete.a - discrete.b * parts.gain;
            let of_joint = |observer: &Observer| one(&errors(observer));
            Self {
                controller: one(regulated.complex_eigenvalues().as_slice()),
                estimator: parts.observers.iter().flat_map(of_joint).collect(),
                together: Vec::new(),
            }
        } else {
            Self {
                together: one(parts.closed().complex_eigenvalues().as_slice()),
                ..Self::default()
            }
        }
    }

    /// All of them, and whose they are.
    pub fn all(&self) -> impl Iterator<Item = (&'static str, &Pole)> {
        let named = |name| move |pole| (name, pole);
        let controller = self.controller.iter().map(named("controller"));
        let estimator = self.estimator.iter().map(named("estimator"));
        let together = self.together.iter().map(named("loop"));
        controller.chain(estimator).chain(together)
    }
}

fn errors(observer: &Observer) -> Vec<Complex<f64>> {
    let memory: Matrix3<f64> = observer.memory.fixed_view::<3, 3>(0, 0).into_owned();
    memory.complex_eigenvalues().as_slice().to_vec()
}

fn poles(eigenvalues: &[Complex<f64>], period_s: f64) -> Vec<Pole> {
    let mut poles: Vec<Pole> = eigenvalues
        .iter()
        // Of a pair the upper one stands for both.
        .filter(|z| z.im >= 0.0 && z.re.hypot(z.im) > NOTHING)
        .map(|z| Pole::of(*z, period_s))
        .collect();
    poles.sort_by(|a, b| a.natural_rad_s.total_cmp(&b.natural_rad_s));
    poles
}
