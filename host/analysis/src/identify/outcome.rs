//! Settings of a board that has the arm that was found.

use armbridge_shared::JOINTS;
use armbridge_shared::arm::Parameters;
use armbridge_shared::link::message::Settings;

use super::fit_result::Found;
use super::quantity::Quantity;

/// Numbers that no arm can have.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error(
    "what was found is no arm with these lengths: masses {m1_kg:.3} and {m2_kg:.3} kg, inertias \
     {i1x_kg_m2:.4} and {i2y_kg_m2:.4} kg m²; measure arm.l1_m, arm.l2_m and the masses again"
)]
pub struct NoArm {
    m1_kg: f64,
    m2_kg: f64,
    i1x_kg_m2: f64,
    i2y_kg_m2: f64,
}

/// The same settings with the arm that was found: masses by their weight, the inertias of
/// the geared rotors by what is left, friction, and the servos' calibration. A board has one
/// number for a joint's dry friction, that at speed: how it falls up to there is left out.
///
/// # Errors
/// If there is no such arm.
pub fn settings(before: &Settings, found: &Found) -> Result<Settings, NoArm> {
    let number = |joint: usize, quantity: Quantity| found.number(joint, quantity).0;
    let arm = before.setup.arm.map(f64::from);
    let m2 = 2.0 * number(1, Quantity::Gravity) / (arm.g * arm.l2);
    let m1 = 2.0 * (number(0, Quantity::Gravity) / (arm.g * arm.l1) - m2);
    let links = m1 * arm.l1 * arm.l1 / 4.0 + arm.i2z + m2 * arm.l1 * arm.l1;
    let arm = Parameters {
        m1,
        m2,
        i1x: number(0, Quantity::Inertia) - links,
        i2y: number(1, Quantity::Inertia) - m2 * arm.l2 * arm.l2 / 4.0,
        b1: number(0, Quantity::Viscous),
        b2: number(1, Quantity::Viscous),
        ..arm
    };
    if !arm.is_valid() {
        return Err(NoArm {
            m1_kg: arm.m1,
            m2_kg: arm.m2,
            i1x_kg_m2: arm.i1x,
            i2y_kg_m2: arm.i2y,
        });
    }
    let mut after = *before;
    after.setup.arm = arm.map(|number| number as f32);
    for joint in 0..JOINTS {
        let servo = &mut after.setup.joints[joint];
        servo.zero_count = number(joint, Quantity::Zero) as f32;
        servo.gain_counts_per_nm = number(joint, Quantity::Gain) as f32;
        servo.offset_counts = number(joint, Quantity::Offset) as f32;
        after.setup.friction_nm[joint] = number(joint, Quantity::Coulomb) as f32;
    }
    Ok(after)
}
