//! Equation (5).

use armbridge_control::actuator::Joint;
use armbridge_servo::Pwm;

use super::reference::{at, list, number};

#[test]
fn every_actuator_vector_in_f64_and_f32() {
    let rows = list(at(&["actuator_vectors", "rows"]));
    assert_eq!(rows.len(), 27);
    for row in rows {
        let torque = number(&row["tau"]);
        let counts = row["pwm_round_half_up_clamped"].as_u64().unwrap() as u16;
        let back = number(&row["tau_of_pwm_linear"]);
        let pwm = Pwm::new(counts).unwrap();
        assert_eq!(Joint::<f64>::paper().pwm(torque), Ok(pwm), "{row}");
        assert_eq!(Joint::<f32>::paper().pwm(torque as f32), Ok(pwm), "{row}");
        assert!((Joint::<f64>::paper().torque(pwm) - back).abs() < 1e-15);
        let single = f64::from(Joint::<f32>::paper().torque(pwm));
        assert!((single - back).abs() < 2e-7);
    }
}

#[test]
fn one_count_is_the_reference_angle() {
    let joint = Joint::<f64>::paper();
    let lsb = number(at(&["constants", "LSB_rad"]));
    assert!((joint.angle(513) - lsb).abs() < 1e-17);
    assert_eq!(joint.angle(512), 0.0);
}
