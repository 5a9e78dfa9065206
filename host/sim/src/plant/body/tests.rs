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
        load: 0.0,
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
        load: 0.0,
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

/// Dry friction of which a sixth of the transmitted torque is a part.
const LOADED: Friction = Friction {
    coulomb_nm: 0.01,
    static_nm: 0.015,
    stribeck_rad_s: 0.0,
    load: 0.17,
};

#[test]
fn a_loaded_joint_breaks_away_where_the_torques_on_both_ends_of_its_gears_say() {
    let arm = Parameters::paper();
    let leaning = State::at_rest(Vector2::new(0.0, -0.8));
    let weight_nm = arm.gravity(leaning.q).y;
    assert!(weight_nm > 0.1, "{weight_nm} N m");
    let Friction {
        static_nm, load, ..
    } = LOADED;
    // |motor - weight| = static + load |motor + weight|, lifting and lowering.
    let lifts_nm = (weight_nm * (1.0 + load) + static_nm) / (1.0 - load);
    let lowers_nm = (weight_nm * (1.0 - load) - static_nm) / (1.0 + load);
    // A push that takes the weight off the motor leaves gears without load; one that takes the
    // place of the weight loads them as the weight did.
    for (g, push_nm) in [(arm.g, 0.0), (0.0, -weight_nm)] {
        let arm = Parameters { g, ..arm };
        for (motor_nm, direction) in [
            (lifts_nm + 1e-6, 1.0),
            (lifts_nm - 1e-6, 0.0),
            (lowers_nm + 1e-6, 0.0),
            (lowers_nm - 1e-6, -1.0),
        ] {
            let stops = [[-100.0, 100.0]; JOINTS];
            let mut body = Body::new(arm, [LOADED; JOINTS], stops, leaning);
            body.set_torques(0, Vector2::new(0.0, motor_nm), Vector2::new(0.0, push_nm));
            let speed = body.state(S / 50).dq.y;
            let moves = if speed == 0.0 { 0.0 } else { speed.signum() };
            assert_eq!(moves.to_bits(), f64::to_bits(direction), "{motor_nm} N m");
        }
    }
}

#[test]
fn a_loaded_joint_at_speed_loses_its_share_of_the_torque() {
    let arm = Parameters::<f64>::paper();
    for torque_nm in [0.05, 0.2, -0.2] {
        let speed = turned(LOADED, torque_nm).dq.y;
        // What is left of the motor's torque after its back-EMF turns the gears.
        let gears_nm = torque_nm - arm.b2 * speed;
        let friction_nm = (LOADED.coulomb_nm + LOADED.load * gears_nm.abs()).copysign(speed);
        assert!(
            (gears_nm - friction_nm).abs() < 1e-9,
            "{torque_nm} N m: {speed}"
        );
    }
}

#[test]
fn the_reported_friction_of_a_loaded_joint_balances_it() {
    let arm = Parameters::paper();
    let leaning = State::at_rest(Vector2::new(0.0, -0.8));
    let stops = [[-100.0, 100.0]; JOINTS];
    let mut body = Body::new(arm, [LOADED; JOINTS], stops, leaning);
    let weight_nm = arm.gravity(leaning.q).y;
    for motor_nm in [weight_nm, 0.9 * weight_nm, 1.2 * weight_nm] {
        body.set_torque(0, Vector2::new(0.0, motor_nm));
        let (state, friction_nm) = body.state_and_friction(S);
        assert_eq!(state, leaning);
        let left_nm = motor_nm - weight_nm + friction_nm.y;
        assert!(left_nm.abs() < 1e-12, "{motor_nm} N m: {left_nm}");
    }
}
