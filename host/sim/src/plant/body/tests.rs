//! Tests of the body: friction and reversals against closed forms.

use super::*;

const S: u64 = 1_000_000_000;

/// Link 2 of an arm without weight, under this torque for 5 s.
fn turned(friction: Friction, torque_nm: f64) -> State<f64> {
    let arm = Parameters {
        g: 0.0,
        ..Parameters::paper()
    };
    let stops = [[-100.0, 100.0]; JOINTS];
    let at_rest = State::at_rest(Vector2::zeros());
    let mut body = Body::new(arm, [friction; JOINTS], stops, at_rest);
    body.set_torque(0, Vector2::new(0.0, torque_nm));
    body.advance(5 * S);
    body.state(5 * S)
}

#[test]
fn dry_friction_comes_down_with_speed_after_stribeck() {
    let friction = Friction {
        coulomb_nm: 0.04,
        static_nm: 0.06,
        stribeck_rad_s: 0.3,
    };
    let viscous = Parameters::<f64>::paper().b2;
    assert!(turned(friction, 0.0599).dq.y.abs() <= 0.0);
    for torque_nm in [0.08, 0.1, -0.1, 0.2] {
        let speed = turned(friction, torque_nm).dq.y;
        let dry_nm = 0.04 + 0.02 * (-(speed / 0.3).powi(2)).exp();
        let balance_nm = torque_nm - viscous * speed - dry_nm.copysign(speed);
        assert!(balance_nm.abs() < 1e-9, "{torque_nm} N m: {balance_nm}");
        // The jump, which is where this ends at speed, lets it go faster.
        let jump = Friction {
            stribeck_rad_s: 0.0,
            ..friction
        };
        let faster = turned(jump, torque_nm).dq.y;
        assert!(faster.abs() > speed.abs());
        assert!((faster.abs() - (torque_nm.abs() - 0.04) / viscous).abs() < 1e-9);
    }
}

#[test]
fn a_joint_reverses_when_its_speed_is_zero_not_at_the_next_step() {
    let friction = Friction {
        coulomb_nm: 0.04,
        static_nm: 0.06,
        stribeck_rad_s: 0.0,
    };
    let arm = Parameters {
        g: 0.0,
        ..Parameters::paper()
    };
    let stops = [[-100.0, 100.0]; JOINTS];
    let (inertia, torque_nm) = (arm.i2y + arm.m2 * arm.l2 * arm.l2 / 4.0, 0.2);
    let constant_s = inertia / arm.b2;
    // Slides at this speed, until it is pushed the other way as hard.
    let full_rad_s = (torque_nm - friction.coulomb_nm) / arm.b2;
    let slower_rad_s = (torque_nm + friction.coulomb_nm) / arm.b2;
    let until_s = constant_s * (1.0 + full_rad_s / slower_rad_s).ln();
    for us in [0, 13, 50, 87] {
        let at_rest = State::at_rest(Vector2::zeros());
        let mut body = Body::new(arm, [friction; JOINTS], stops, at_rest);
        let from_ns = 20 * S + us * 1_000;
        body.set_torque(0, Vector2::new(0.0, torque_nm));
        body.set_torque(from_ns, Vector2::new(0.0, -torque_nm));
        let speed = body.state(from_ns + S / 10).dq.y;
        let back_s = 0.1 - until_s;
        let expected = -full_rad_s * (1.0 - (-back_s / constant_s).exp());
        assert!(
            back_s > 0.0 && (speed - expected).abs() < 1e-9,
            "{us} us: {speed}"
        );
    }
}
