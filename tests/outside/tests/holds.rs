//! The loop holds the arm, and switches the motors off when its servos fall silent.

use armbridge_link::message::{Fault, Settings};
use armbridge_outside::Loop;
use armbridge_servo::Pwm;

#[test]
fn the_arm_is_held_until_its_servos_fall_silent() {
    let target = [0.3, -0.25];
    let mut control = Loop::new(&Settings::default(), [0.0, 0.0]).unwrap();
    control.regulate(target).unwrap();
    for tick in 0..4_000 {
        let output = control.tick(true);
        assert_eq!(output.fault(), None, "tick {tick}");
    }
    for (angle, target) in control.angle_rad().into_iter().zip(target) {
        // Four encoder counts.
        assert!((angle - target).abs() < 0.02, "{angle} rad, not {target}");
    }

    let fault = (0..100).find_map(|_| control.tick(false).fault());
    assert_eq!(
        fault.map(|violation| violation.fault),
        Some(Fault::ServoSilent)
    );
    for _ in 0..2_000 {
        assert_eq!(control.tick(false).pwm, [Pwm::OFF.counts(); 2]);
    }
    let fallen = control.angle_rad().into_iter().zip(target);
    assert!(
        fallen
            .map(|(angle, target)| (angle - target).abs())
            .fold(0.0, f32::max)
            > 0.5
    );
}
