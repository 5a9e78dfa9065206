//! The paper's identification of joint 1, section 3, repeated on simulated samples: every
//! 45 ms, 2 mrad of noise, 300°/1023 of rounding.
//!
//! The reference has other noise, so estimates may differ from its estimates by their
//! standard errors; quantities that do not depend on the noise (standard errors per noise,
//! correlations, condition numbers) are compared directly.
#![expect(
    clippy::float_cmp,
    reason = "where numbers are compared exactly, exactness is the claim"
)]

use armbridge_control::arm::{Parameters, State};
use armbridge_paper::identification::{
    Fit, FitError, InitialState, JointParameters, PUSH_FROM_RAD, SampledExperiment, Unknown,
    VISCOUS, VISCOUS_COULOMB, VISCOUS_TORQUE, VISCOUS_TORQUE_COULOMB, VISCOUS_TORQUE_INERTIA,
    VirtualArm, fit,
};
use armbridge_servo::JOINTS;
use armbridge_sim::plant::{Body, Friction};
use nalgebra::{DMatrix, DVector, Vector2};
use serde_json::Value;

use crate::paper::reference::{at, number};

/// The paper's constant input in N m.
const PUSH_NM: f64 = -0.3924;
/// Draws of the noise.
const SEEDS: u64 = 10;
/// Unknowns whose common scale no motion identifies.
const SCALE: &[Unknown] = &[
    Unknown::Viscous,
    Unknown::Torque,
    Unknown::Inertia,
    Unknown::Gravity,
];

fn reference(name: &str) -> &'static Value {
    at(&["identification", name])
}

/// Guess away from the true parameters.
fn guess() -> JointParameters {
    JointParameters {
        b1: 0.3,
        torque_nm: -0.35,
        ..JointParameters::from_arm(&Parameters::paper())
    }
}

fn found(sampled: &SampledExperiment, unknowns: &[Unknown]) -> Fit {
    fit(std::slice::from_ref(sampled), unknowns, &guess()).expect("numbers")
}

/// Asserts that two values differ by at most a fraction of the larger one.
fn alike(name: &str, found: f64, expected: f64, share: f64) {
    let error = (found - expected).abs();
    assert!(
        error <= share * found.abs().max(expected.abs()),
        "{name}: {found}, not {expected}"
    );
}

/// Compares fits of samples with several draws of noise with a line of the reference.
/// Derivatives are evaluated at the estimates, so quantities computed from them may differ by
/// the fraction `share`.
fn compare(
    name: &str,
    unknowns: &[Unknown],
    share: f64,
    sampled: impl Fn(u64) -> SampledExperiment,
) {
    let line = reference(name);
    let fits: Vec<Fit> = (1..=SEEDS)
        .map(|seed| found(&sampled(seed), unknowns))
        .collect();
    for (i, unknown) in unknowns.iter().enumerate() {
        let (truth, estimate) = (number(&line["true"][i]), number(&line["est"][i]));
        let deviation = number(&line["sd"][i]);
        let mut sum = 0.0;
        for fit in &fits {
            let value = fit.parameters.get(*unknown);
            sum += value;
            let most = 4.0 * deviation;
            assert!((value - truth).abs() < most, "{name} {unknown:?}: {value}");
            // Of the reference's own draw as well.
            assert!((value - estimate).abs() < 1.5 * most, "{name}: {value}");
            let per_noise = fit.standard_error(*unknown) / fit.rms_rad;
            alike(name, per_noise, deviation / number(&line["rms"]), share);
        }
        let mean = sum / fits.len() as f64;
        let most = 3.0 * deviation / (SEEDS as f64).sqrt();
        assert!((mean - truth).abs() < most, "{name}: {mean} on average");
    }
    for fit in &fits {
        alike(name, fit.condition, number(&line["cond"]), share);
        for (i, a) in unknowns.iter().enumerate() {
            for (j, b) in unknowns.iter().enumerate() {
                let found = fit.correlation(*a, *b).expect("sought");
                let expected = number(&line["corr"][i][j]);
                assert!(
                    (found - expected).abs() < 0.03,
                    "{name} {a:?} {b:?}: {found}"
                );
            }
        }
        // Noise of 2 mrad and what rounding adds.
        alike(name, fit.rms_rad, 0.0025, 0.3);
    }
    println!(
        "{name}: {:?}, condition {:.2}",
        fits[0].parameters, fits[0].condition
    );
}

fn pushed(duration_s: f64) -> impl Fn(u64) -> SampledExperiment {
    move |seed| VirtualArm::paper(0.24, 0.0, seed).constant_input(PUSH_NM, duration_s)
}

fn fallen(start: InitialState) -> impl Fn(u64) -> SampledExperiment {
    move |seed| SampledExperiment {
        start,
        ..VirtualArm::paper(0.24, 0.0, seed).free_fall(0.1, 4.0)
    }
}

#[test]
fn a_constant_input_identifies_friction_and_torque() {
    let name = "ident const input T=3.0 (b,tau)";
    compare(name, VISCOUS_TORQUE, 0.01, pushed(3.0));
    let name = "ident const input T=1.5 (b,tau)";
    compare(name, VISCOUS_TORQUE, 0.01, pushed(1.5));
}

#[test]
fn a_long_constant_input_identifies_the_inertia_and_a_short_one_hardly() {
    let name = "ident const input T=3.0 (b,tau,M11)";
    compare(name, VISCOUS_TORQUE_INERTIA, 0.03, pushed(3.0));
    let name = "ident const input T=1.5 (b,tau,M11)";
    // The reference's own inertia is 1.4 % off here, and slopes fall with it.
    compare(name, VISCOUS_TORQUE_INERTIA, 0.12, pushed(1.5));
}

#[test]
fn a_free_fall_identifies_friction() {
    compare(
        "ident free fall (b), q0 known",
        VISCOUS,
        0.01,
        fallen(InitialState::Known),
    );
    compare(
        "ident free fall (b,q0)",
        VISCOUS,
        0.01,
        fallen(InitialState::AtRest),
    );
    let unknowns = &[Unknown::Viscous, Unknown::Inertia];
    let name = "ident free fall (b,q0,M11)";
    let (line, fit) = (
        reference(name),
        found(&fallen(InitialState::AtRest)(1), unknowns),
    );
    // The reference has the start between the two.
    for (i, unknown) in [(0, Unknown::Viscous), (2, Unknown::Inertia)] {
        let (truth, deviation) = (number(&line["true"][i]), number(&line["sd"][i]));
        assert!((fit.parameters.get(unknown) - truth).abs() < 4.0 * deviation);
        let per_noise = fit.standard_error(unknown) / fit.rms_rad;
        alike(name, per_noise, deviation / number(&line["rms"]), 0.03);
    }
    assert!((fit.starts[0][0] - 0.1).abs() < 4.0 * number(&line["sd"][1]));
    alike(name, fit.condition, number(&line["cond"]), 0.03);
}

/// Condition number of the scale by differences of the bench's motions, forwards.
fn condition_by_differences(duration_s: f64) -> f64 {
    let run = |[b1, torque_nm, inertia, weight]: [f64; 4]| {
        let paper = Parameters::<f64>::paper();
        let arm = Parameters {
            b1: paper.b1 * b1,
            i1x: paper.i1x + paper.mass(Vector2::zeros()).m11 * (inertia - 1.0),
            g: paper.g * weight,
            ..paper
        };
        let initial = State::at_rest(Vector2::new(PUSH_FROM_RAD, 0.0));
        let stops = [[-9.0, 9.0]; JOINTS];
        let mut body = Body::new(arm, [Friction::NONE; JOINTS], stops, initial);
        body.set_torque(0, Vector2::new(PUSH_NM * torque_nm, 0.0));
        let samples = (duration_s / 0.045).ceil() as u64;
        let angle = |k: u64| {
            body.advance(k * 45_000_000);
            body.state(k * 45_000_000).q.x
        };
        (0..samples).map(angle).collect::<Vec<f64>>()
    };
    let (here, step) = (run([1.0; 4]), f64::EPSILON.sqrt());
    let columns = [0, 1, 2, 3].map(|j| {
        let mut at = [1.0; 4];
        at[j] += step;
        let moved = run(at);
        DVector::from_fn(here.len(), |k, _| (moved[k] - here[k]) / step)
    });
    let values = DMatrix::from_columns(&columns).singular_values();
    values.max() / values.min()
}

#[test]
fn no_motion_identifies_the_scale() {
    for (duration_s, name) in [(1.5, "T=1.5"), (3.0, "T=3.0")] {
        let fit = found(&pushed(duration_s)(1), SCALE);
        assert!(fit.condition > 1e9, "{name}: {:e}", fit.condition);
        let words = fit.unidentifiable().expect("unidentifiable parameters");
        assert!(words.contains("weight, measured with a scale"), "{words}");
        // Ratios are identifiable.
        let [b1, torque] = [Unknown::Viscous, Unknown::Torque].map(|u| fit.parameters.get(u));
        alike(name, b1 / torque, 0.24 / PUSH_NM, 0.02);
        println!("{name}: condition {:.1e}, {words}", fit.condition);
        // With differences in place of exact slopes, their noise is what is left of a
        // number that has no end; so it was in the reference.
        let left = condition_by_differences(duration_s);
        println!("{name}: {left:.1e} by differences");
        let line = reference(&format!("ident const input {name} (b,tau,M11,a1)"));
        for condition in [left, number(&line["cond"])] {
            assert!((1e7..1e9).contains(&condition), "{condition:e}");
        }
    }
    assert!(
        found(&pushed(3.0)(1), VISCOUS_TORQUE)
            .unidentifiable()
            .is_none()
    );
}

/// The arm of a line of the reference that has dry friction, and where it was let go.
fn dry(coulomb_nm: f64, seed: u64) -> (VirtualArm, f64) {
    let from_rad = number(&reference(&format!("bias tc={coulomb_nm}"))["q0"]);
    let mut arm = VirtualArm::paper(0.24, coulomb_nm, seed);
    // The reference let go 15 % beyond where static friction does.
    let gravity_nm = JointParameters::from_arm(&arm.arm).gravity_nm;
    arm.friction = Friction {
        static_nm: gravity_nm * (from_rad / 1.15).sin(),
        ..arm.friction
    };
    assert!((arm.breakaway_rad() * 1.15 - from_rad).abs() < 1e-12);
    (arm, from_rad)
}

#[test]
fn dry_friction_is_taken_for_viscous_friction_by_a_fall() {
    for (coulomb_nm, printed) in [(0.04, 0.336), (0.06, 0.369), (0.08, 0.398), (0.1, 0.427)] {
        let line = reference(&format!("bias tc={coulomb_nm}"));
        for seed in 1..=SEEDS {
            let (arm, from_rad) = dry(coulomb_nm, seed);
            let fall = arm.free_fall(from_rad, 4.0);
            let stop_rad = fall.angles_rad.last().copied().flatten().expect("a sample");
            // Rounded, with noise.
            assert!((stop_rad.to_degrees() - number(&line["stop_deg"])).abs() < 0.6);

            let viscous = found(&fall, VISCOUS);
            let b1 = viscous.parameters.b1;
            assert!((b1 - printed).abs() < 1e-3, "{coulomb_nm}: {b1}");
            alike("rms", viscous.rms_rad, number(&line["rms"]), 0.01);

            // With dry friction in the model, both come out.
            let both = found(&fall, VISCOUS_COULOMB);
            let JointParameters {
                b1,
                coulomb_nm: dry_nm,
                ..
            } = both.parameters;
            assert!((b1 - 0.24).abs() < 1e-3, "{coulomb_nm}: {b1}");
            assert!((dry_nm - coulomb_nm).abs() < 4e-4, "{coulomb_nm}: {dry_nm}");
            if seed == 1 {
                println!(
                    "{coulomb_nm} N m: viscous only {:.5}, {b1:.5} and {dry_nm:.5}",
                    viscous.parameters.b1
                );
            }
        }
    }
}

#[test]
fn the_papers_free_fall_comes_of_one_dry_friction() {
    let coulomb_nm = number(reference("tc_for_0p421"));
    for seed in 1..=SEEDS {
        let arm = VirtualArm::paper(0.239, coulomb_nm, seed);
        let fall = arm.paper_fall();
        let b1 = found(&fall, VISCOUS).parameters.b1;
        assert!((b1 - 0.421).abs() < 1e-3, "viscous only: {b1}");
        let JointParameters {
            b1,
            coulomb_nm: dry_nm,
            ..
        } = found(&fall, VISCOUS_COULOMB).parameters;
        assert!((b1 - 0.239).abs() < 1e-3, "with dry friction: {b1}");
        assert!((dry_nm - coulomb_nm).abs() < 4e-4, "dry friction: {dry_nm}");
        // "The system does not reach the actual equilibrium point at 180°."
        let last = fall.angles_rad.last().copied().flatten().expect("a sample");
        let short_deg = 180.0 - last.to_degrees();
        assert!((10.0..11.4).contains(&short_deg), "{short_deg}");
    }
}

#[test]
fn a_constant_input_takes_dry_friction_for_torque() {
    for coulomb_nm in [0.02, 0.04, 0.06, 0.08] {
        let line = reference(&format!("bias tc={coulomb_nm}"));
        for seed in 1..=SEEDS {
            let push = dry(coulomb_nm, seed).0.constant_input(PUSH_NM, 3.0);
            let one = found(&push, VISCOUS_TORQUE);
            let (b1, torque_nm) = (one.parameters.b1, one.parameters.torque_nm);
            let errors =
                [Unknown::Viscous, Unknown::Torque].map(|unknown| one.standard_error(unknown));
            assert!((torque_nm - PUSH_NM - coulomb_nm).abs() < 4.0 * errors[1]);
            assert!((b1 - 0.24).abs() < 4.0 * errors[0], "{coulomb_nm}: {b1}");
            let [expected_b1, expected_nm] =
                ["b1_const", "tau_const"].map(|key| number(&line[key]));
            assert!(
                (torque_nm - expected_nm).abs() < 6.0 * errors[1],
                "{torque_nm}"
            );
            assert!((b1 - expected_b1).abs() < 6.0 * errors[0], "{b1}");

            // One way only, the two are one torque.
            let blind = found(&push, VISCOUS_TORQUE_COULOMB);
            let words = blind.unidentifiable().expect("unidentifiable parameters");
            assert!(words.contains("torque and dry friction"), "{words}");
            let sum_nm = blind.parameters.torque_nm + blind.parameters.coulomb_nm;
            assert!((sum_nm - torque_nm).abs() < errors[1]);
            if seed == 1 {
                println!("{coulomb_nm} N m: b1 {b1:.5}, torque {torque_nm:.5}");
            }
        }
    }
}

/// The reference's fit of the least dry friction stayed at its guess: there, the arm of
/// the guess sticks, and nothing depends on any number.
#[test]
fn a_guess_at_which_the_arm_sticks_is_refused() {
    let line = reference("bias tc=0.02");
    let stayed = ["b1_with_coulomb", "tc_est"].map(|key| number(&line[key]));
    assert_eq!(stayed, [0.3, 0.05]);
    let (arm, from_rad) = dry(0.02, 1);
    let fall = [arm.free_fall(from_rad, 4.0)];
    let stuck = JointParameters {
        coulomb_nm: 0.05,
        ..guess()
    };
    let refusal = fit(&fall, VISCOUS_COULOMB, &stuck).expect_err("sticks");
    assert!(matches!(refusal, FitError::Sticks { .. }), "{refusal}");
    let freed = fit(&fall, VISCOUS_COULOMB, &guess())
        .expect("numbers")
        .parameters;
    assert!((freed.b1 - 0.24).abs() < 1e-3, "{}", freed.b1);
    assert!(
        (freed.coulomb_nm - 0.02).abs() < 4e-4,
        "{}",
        freed.coulomb_nm
    );
}
