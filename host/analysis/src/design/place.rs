//! Pole placement for state feedback.
//!
//! About upright the joints are decoupled, and the gain that gives a joint two poles is
//! unique: `K = [0 1] [B AB]^-1 p(A)`, Ackermann's formula.

use armbridge_link::message::Setup;
use armbridge_servo::JOINTS;
use nalgebra::{Matrix2, RowVector2, Vector2};

/// Reason why no gain exists.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum PlaceError {
    /// The torque does not move the joint.
    #[error("torque does not move joint {0}: no gain places its poles")]
    Uncontrollable(usize),
}

/// Sum and product of the poles of a joint, as real and imaginary parts in z. `None` unless both
/// are inside the unit circle, and real or conjugate.
#[expect(clippy::float_cmp, reason = "conjugates are given alike")]
pub fn pole_pair([first, second]: [(f64, f64); 2]) -> Option<(f64, f64)> {
    let (sum, product) = (first.0 + second.0, first.0 * second.0 - first.1 * second.1);
    let is_pair = first.1 == -second.1 && (first.1 == 0.0 || first.0 == second.0);
    let is_inside = [first, second].iter().all(|(re, im)| re.hypot(*im) < 1.0);
    (is_pair && is_inside).then_some((sum, product))
}

/// Discrete model of each joint about upright: state and input matrix.
pub(super) fn joints(setup: &Setup) -> [(Matrix2<f64>, Vector2<f64>); JOINTS] {
    let period_s = f64::from(setup.period_us) * 1e-6;
    let arm = setup.arm.map(f64::from).linearise(Vector2::zeros());
    let model = arm.zero_order_hold(period_s);
    let [first, second] = model.joints();
    [
        (first, Vector2::new(model.b.m11, model.b.m31)),
        (second, Vector2::new(model.b.m22, model.b.m42)),
    ]
}

/// Gain, one row per torque, that gives each joint of the set-up's arm two poles with a sum
/// and product.
///
/// # Errors
/// If a torque does not move its joint.
pub fn place(
    setup: &Setup,
    sums_and_products: [(f64, f64); JOINTS],
) -> Result<[[f32; 2 * JOINTS]; JOINTS], PlaceError> {
    let mut gain = [[0.0; 2 * JOINTS]; JOINTS];
    for (joint, (a, b)) in joints(setup).into_iter().enumerate() {
        let (sum, product) = sums_and_products[joint];
        let controllability = Matrix2::from_columns(&[b, a * b]);
        let inverse = controllability.try_inverse();
        let inverse = inverse.ok_or(PlaceError::Uncontrollable(joint + 1))?;
        let polynomial = a * a - a * sum + Matrix2::identity() * product;
        let row = RowVector2::new(0.0, 1.0) * inverse * polynomial;
        gain[joint][joint] = row.x as f32;
        gain[joint][JOINTS + joint] = row.y as f32;
    }
    Ok(gain)
}
