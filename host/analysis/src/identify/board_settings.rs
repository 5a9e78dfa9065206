//! Settings of a board with the identified arm.

use armbridge_control::arm::Parameters;
use armbridge_link::message::{FRICTION_LOAD_PERCENT_MAX, Settings};
use armbridge_servo::JOINTS;

use super::fit_result::FitResult;
use super::quantity::Quantity;

/// Parameters without a physical arm.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error(
    "no arm with these lengths has the identified parameters: masses {m1_kg:.3} and {m2_kg:.3} \
     kg, inertias {i1x_kg_m2:.4} and {i2y_kg_m2:.4} kg m²; measure arm.l1_m, arm.l2_m and the \
     masses again"
)]
pub struct UnphysicalArm {
    m1_kg: f64,
    m2_kg: f64,
    i1x_kg_m2: f64,
    i2y_kg_m2: f64,
}

/// The same settings with the identified arm: masses from the gravity torques, inertias of
/// the geared rotors from the remaining inertia, friction, and the servos' calibration. A
/// board has one parameter for a joint's dry friction, that at speed: the Stribeck curve is
/// left out, and the load friction is in whole percent.
///
/// # Errors
/// If the arm is not physical.
pub fn identified_settings(before: &Settings, fit: &FitResult) -> Result<Settings, UnphysicalArm> {
    let estimate = |joint: usize, quantity: Quantity| fit.estimate(joint, quantity).0;
    let arm = before.setup.arm.map(f64::from);
    let joints = arm.joints();
    let is_two = joints == JOINTS;
    let m2 = if is_two {
        2.0 * estimate(1, Quantity::Gravity) / (arm.g * arm.l2)
    } else {
        0.0
    };
    let m1 = 2.0 * (estimate(0, Quantity::Gravity) / (arm.g * arm.l1) - m2);
    let links = m1 * arm.l1 * arm.l1 / 4.0 + arm.i2z + m2 * arm.l1 * arm.l1;
    let arm = Parameters {
        m1,
        m2,
        i1x: estimate(0, Quantity::Inertia) - links,
        b1: estimate(0, Quantity::Viscous),
        ..arm
    };
    let arm = if is_two {
        Parameters {
            i2y: estimate(1, Quantity::Inertia) - m2 * arm.l2 * arm.l2 / 4.0,
            b2: estimate(1, Quantity::Viscous),
            ..arm
        }
    } else {
        arm
    };
    if !arm.is_valid() {
        return Err(UnphysicalArm {
            m1_kg: arm.m1,
            m2_kg: arm.m2,
            i1x_kg_m2: arm.i1x,
            i2y_kg_m2: arm.i2y,
        });
    }
    let mut after = *before;
    after.setup.arm = arm.map(|value| value as f32);
    for joint in 0..joints {
        let servo = &mut after.setup.joints[joint];
        servo.zero_count = estimate(joint, Quantity::Zero) as f32;
        servo.gain_counts_per_nm = estimate(joint, Quantity::Gain) as f32;
        servo.offset_counts = estimate(joint, Quantity::Offset) as f32;
        after.setup.friction_nm[joint] = estimate(joint, Quantity::Coulomb) as f32;
        let percent = fit.load[joint].map_or(0.0, |it| 100.0 * it.load).round() as u8;
        after.setup.friction_load_percent[joint] = percent.min(FRICTION_LOAD_PERCENT_MAX);
    }
    Ok(after)
}
