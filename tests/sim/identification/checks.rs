//! What a fit says of itself holds: the right model leaves noise, a wrong one is told.
//!
//! Simulated, as all here.

use core::f64::consts::TAU;

use armbridge_analysis::identify::{
    Checks, Found, Known, Prior, Quantity, Tally, Trace, forecast, identify, without_the_last,
};
use armbridge_shared::JOINTS;
use armbridge_sim::plant::PlantConfig;

use super::bad_data::swing;
use super::hands::{Hands, LEAD_S};
use super::{believed, servos};

/// Half a minute of an arm's swinging, fitted.
struct Fitted {
    known: Known,
    prior: Prior,
    traces: [Trace; 1],
    found: Found,
}

fn fitted(config: &PlantConfig) -> Fitted {
    fitted_in(config, swing(config, 30.0, |_, _| ()))
}

fn fitted_in(config: &PlantConfig, trace: Trace) -> Fitted {
    let setup = believed(config);
    let known = Known {
        lead_s: LEAD_S,
        ..Known::of(&setup)
    };
    let prior = Prior::of(&setup, 0.01);
    let traces = [trace];
    let found = identify(&traces, &Tally::of_traces(&traces), &known, &prior).unwrap();
    Fitted {
        known,
        prior,
        traces,
        found,
    }
}

impl Fitted {
    fn checks(&self) -> Checks {
        let checks = Checks::of(&self.found, &self.traces, &self.known, &self.prior);
        println!("{}", checks.text());
        checks
    }
}

#[test]
fn the_right_model_leaves_noise_and_says_what_is_not_told() {
    let mut fitted = fitted(&PlantConfig::drawn(5, 0.4));
    assert_eq!(fitted.found.stribeck, [None; JOINTS]);
    let checks = fitted.checks();
    for whiteness in &checks.whiteness {
        assert!(whiteness.is_white(), "{whiteness:?}");
        assert!((0.95..1.1).contains(&whiteness.rms_counts), "{whiteness:?}");
    }
    for form in &checks.forms {
        assert!(form.improvement < 25.0, "{form:?}");
    }
    without_dry_friction_is_far_worse(&checks);
    let scale = checks
        .untold
        .iter()
        .find(|untold| untold.what.starts_with("scale of all torques"));
    let settled = &scale.expect("the scale is not told").settled_by;
    assert_eq!(settled, "the arm's weight, known to 1.0 %");
    let again = without_the_last(&fitted.found, &checks, &fitted.known, &fitted.prior);
    for forecast in again.unwrap_or_default() {
        assert!((0.95..1.2).contains(&forecast.rms_counts), "{forecast:?}");
    }
    // A third more viscous friction than there is leaves more than noise, of this joint.
    fitted.found.at[Quantity::Viscous.at(0)] += 0.3;
    let [one, other] = [0, 1].map(|joint| fitted.checks().whiteness[joint].is_white());
    assert!(!one && other);
}

fn without_dry_friction_is_far_worse(checks: &Checks) {
    for dry in &checks.dry {
        assert!(dry.worse > 1_000.0, "{dry:?}");
    }
}

/// So slowly that nothing but sliding one way tells dry friction from viscous.
fn slow_swing(config: &PlantConfig, seconds: f64, seed: u64) -> Trace {
    let mut hands = Hands::on(config, servos(&believed(config)), seed);
    hands.go([0.0, 0.0]);
    let slow = |t: f64, amplitude: f64, hz: f64| {
        let (sin, cos) = (TAU * hz * t).sin_cos();
        let amplitude = amplitude * (t / 2.0).min(1.0);
        [amplitude * sin, amplitude * TAU * hz * cos]
    };
    hands.track(seconds, |t| [slow(t, 0.5, 0.2), slow(t, 0.7, 0.15)]);
    hands.trace
}

#[test]
fn without_dry_friction_a_slow_joint_seems_to_have_another_viscous_one() {
    let config = PlantConfig::drawn(5, 0.4);
    let checks = fitted_in(&config, slow_swing(&config, 30.0, 98)).checks();
    without_dry_friction_is_far_worse(&checks);
    for dry in &checks.dry {
        let [with, without] = dry.viscous;
        assert!((without / with - 1.0).abs() > 0.1, "{dry:?}");
    }
}

#[test]
fn a_log_held_out_is_forecast_to_less_than_a_count() {
    let config = PlantConfig::drawn(5, 0.4);
    let mut fitted = fitted(&config);
    // Another motion, and other noise.
    let held_out = [slow_swing(&config, 15.0, 99)];
    let rms = |fitted: &Fitted| {
        let forecasts = forecast(&fitted.found, &held_out, &fitted.known);
        for forecast in &forecasts {
            println!("{forecast:?}");
            assert!(
                forecast.longest_s > 1.5 && forecast.slid_s > 8.0,
                "{forecast:?}"
            );
            assert!(
                forecast.unstable_s.is_some_and(|s| (0.1..3.0).contains(&s)),
                "{forecast:?}"
            );
        }
        [0, 1].map(|joint: usize| (forecasts[joint].model_counts, forecasts[joint].rms_counts))
    };
    for (model, rms) in rms(&fitted) {
        assert!(model < 0.6 && rms < 1.25, "{model} of {rms}");
    }
    fitted.found.at[Quantity::Viscous.at(1)] += 0.3;
    let [_, (model, _)] = rms(&fitted);
    assert!(model > 1.0, "{model}");
}

#[test]
fn friction_that_falls_with_speed_is_found() {
    const SPEED_RAD_S: f64 = 0.5;
    let mut config = PlantConfig::drawn(5, 0.4);
    for friction in &mut config.friction {
        friction.static_nm = 2.5 * friction.coulomb_nm;
        friction.stribeck_rad_s = SPEED_RAD_S;
    }
    let fitted = fitted(&config);
    let found = &fitted.found;
    let is_right = |[value, error]: [f64; 2], truth: f64| {
        println!("{value:.4} ± {error:.4} for {truth:.4}");
        assert!((value - truth).abs() < 3.0 * error && error < 0.1 * truth);
    };
    for joint in 0..JOINTS {
        let truth = config.friction[joint];
        let of = found.stribeck[joint].expect("dry friction that falls");
        let drop_nm = truth.static_nm - truth.coulomb_nm;
        is_right([of.drop_nm, of.drop_error_nm], drop_nm);
        is_right([of.speed_rad_s, of.speed_error_rad_s], SPEED_RAD_S);
        let coulomb = found.number(joint, Quantity::Coulomb);
        is_right(coulomb.into(), truth.coulomb_nm);
        let viscous = found.number(joint, Quantity::Viscous);
        is_right(viscous.into(), [config.arm.b1, config.arm.b2][joint]);
    }
    let warnings = fitted.checks().warnings;
    let lacks = warnings
        .iter()
        .find(|warning| warning.contains("the model lacks"));
    assert_eq!(lacks, None);
}
