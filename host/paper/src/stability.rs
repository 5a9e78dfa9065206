//! Linear theory of LQR with an observer: poles of the closed loop, and its
//! stiffness about upright.
//!
//! The plant is the arm discretised exactly; the observer uses (7). An unmodelled
//! period of delay adds the torque in force to the state:
//!
//! ```text
//! x   <- Ad x + Bd u          u = -K x^, with delay that of the previous step
//! x^  <- (A - B K - L C) x^ + L C x
//! ```

use armbridge_control::arm::{Discrete, Parameters};
use armbridge_control::controller::Lqr;
use armbridge_servo::JOINTS;
use nalgebra::{Complex, Matrix2x4, Matrix4, Matrix4x2, SMatrix, Vector2};

use super::observers::exact_model;
use super::printed::PERIOD_S;

/// Observer gain on angle and speed, for each joint.
pub(crate) type Gain = [[f64; 2]; JOINTS];

/// Spectral radius of the loop of arm, observer and printed K.
pub(crate) fn spectral_radius(gain: &Gain, delayed: bool) -> f64 {
    let plant = exact_model();
    let k: Matrix2x4<f64> = Lqr::paper().gain;
    let (observer, l_c) = observer(gain);
    let mut closed_loop = SMatrix::<f64, 10, 10>::zeros();
    closed_loop.fixed_view_mut::<4, 4>(0, 0).copy_from(&plant.a);
    closed_loop.fixed_view_mut::<4, 4>(4, 0).copy_from(&l_c);
    closed_loop
        .fixed_view_mut::<4, 4>(4, 4)
        .copy_from(&observer);
    // Rows and columns 8 and 9 are the torque computed in the previous step.
    closed_loop.fixed_view_mut::<2, 4>(8, 4).copy_from(&-k);
    if delayed {
        closed_loop.fixed_view_mut::<4, 2>(0, 8).copy_from(&plant.b);
    } else {
        closed_loop
            .fixed_view_mut::<4, 4>(0, 4)
            .copy_from(&(-plant.b * k));
    }
    largest_modulus(closed_loop.complex_eigenvalues().as_slice())
}

/// Spectral radius with speeds by differences; the state is x and the last angles.
pub(crate) fn spectral_radius_of_differences() -> f64 {
    let plant = exact_model();
    let k: Matrix2x4<f64> = Lqr::paper().gain;
    let on_speed = k.fixed_view::<2, 2>(0, 2) / PERIOD_S;
    let mut feedback = Matrix2x4::zeros();
    feedback
        .fixed_view_mut::<2, 2>(0, 0)
        .copy_from(&(k.fixed_view::<2, 2>(0, 0) + on_speed));
    let mut closed_loop = SMatrix::<f64, 6, 6>::zeros();
    closed_loop
        .fixed_view_mut::<4, 4>(0, 0)
        .copy_from(&(plant.a - plant.b * feedback));
    closed_loop
        .fixed_view_mut::<4, 2>(0, 4)
        .copy_from(&(plant.b * on_speed));
    closed_loop
        .fixed_view_mut::<2, 2>(4, 0)
        .fill_with_identity();
    largest_modulus(closed_loop.complex_eigenvalues().as_slice())
}

/// Static gain in N m/rad of controller and observer from a constant angle to torque:
/// `K (I - A + B K + L C)^-1 L`. None if the matrix is singular.
pub(crate) fn static_gain(gain: &Gain) -> Option<[f64; JOINTS]> {
    let k: Matrix2x4<f64> = Lqr::paper().gain;
    let (observer, _) = observer(gain);
    let inverse = (Matrix4::identity() - observer).try_inverse()?;
    let torque = k * inverse * matrix(gain);
    Some([torque.m11, torque.m22])
}

/// Stiffness of gravity about upright in N m/rad, positive.
pub(crate) fn gravity_stiffness() -> [f64; JOINTS] {
    let slope = Parameters::<f64>::paper().gravity_slope(Vector2::zeros());
    [-slope.m11, -slope.m22]
}

/// `A - B K - L C` and `L C`.
fn observer(gain: &Gain) -> (Matrix4<f64>, Matrix4<f64>) {
    let Discrete { a, b } = Discrete::paper();
    let l_c = matrix(gain) * Matrix2x4::identity();
    (a - b * Lqr::paper().gain - l_c, l_c)
}

fn matrix(gain: &Gain) -> Matrix4x2<f64> {
    let [[q1, v1], [q2, v2]] = *gain;
    Matrix4x2::new(q1, 0.0, 0.0, q2, v1, 0.0, 0.0, v2)
}

fn largest_modulus(poles: &[Complex<f64>]) -> f64 {
    let sizes = poles.iter().map(|pole| pole.re.hypot(pole.im));
    sizes.fold(0.0, f64::max)
}
