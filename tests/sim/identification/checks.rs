//! Checks of a fit on simulated data: the right model leaves white noise, model errors are
//! detected.

use core::f64::consts::TAU;

use armbridge_analysis::identify::{
    Checks, FitResult, KnownParameters, Prior, Quantity, Tally, Trace, forecast, holdout_forecasts,
    identify,
};
use armbridge_servo::JOINTS;
use armbridge_sim::plant::PlantConfig;

use super::bad_data::swing;
use super::tracking_loop::{LEAD_S, TrackingLoop};
use super::{prior_setup, servos};

/// Fit of half a minute of swinging.
struct Fitted {
    known: KnownParameters,
    prior: Prior,
    traces: [Trace; 1],
    fit: FitResult,
}

fn fitted(config: &PlantConfig) -> Fitted {
    fitted_in(config, swing(config, 30.0, |_, _| ()))
}

fn fitted_in(config: &PlantConfig, trace: Trace) -> Fitted {
    let setup = prior_setup(config);
    let known = KnownParameters {
        lead_s: LEAD_S,
        ..KnownParameters::from_setup(&setup)
    };
    let prior = Prior::from_setup(&setup, 0.01);
    let traces = [trace];
    let fit = identify(&traces, &Tally::from_traces(&traces), &known, &prior).unwrap();
    Fitted {
        known,
        prior,
        traces,
        fit,
    }
}

impl Fitted {
    fn checks(&self) -> Checks {
        let checks = Checks::new(&self.fit, &self.traces, &self.known, &self.prior);
        println!("{}", checks.text());
        checks
    }
}

#[test]
fn the_right_model_leaves_white_noise_and_an_unidentifiable_scale() {
    let mut fitted = fitted(&PlantConfig::drawn(5, 0.4));
    assert_eq!(fitted.fit.stribeck, [None; JOINTS]);
    assert_eq!(fitted.fit.load, [None; JOINTS]);
    let checks = fitted.checks();
    for whiteness in &checks.whiteness {
        assert!(whiteness.is_white(), "{whiteness:?}");
        assert!((0.95..1.1).contains(&whiteness.rms_counts), "{whiteness:?}");
    }
    for missing in &checks.missing_torques {
        assert!(missing.improvement < 25.0, "{missing:?}");
    }
    without_dry_friction_is_far_worse(&checks);
    let scale = checks
        .unidentifiable
        .iter()
        .find(|combination| combination.description.starts_with("scale of all torques"));
    let prior = &scale.expect("an unidentifiable scale").fixed_by;
    assert_eq!(prior, "the arm's weight, known to 1.0 %");
    let forecasts = holdout_forecasts(&fitted.fit, &checks, &fitted.known, &fitted.prior);
    for forecast in forecasts.unwrap_or_default() {
        assert!((0.95..1.2).contains(&forecast.rms_counts), "{forecast:?}");
    }
    // With a third more viscous friction, this joint's residuals are not white.
    fitted.fit.coordinates[Quantity::Viscous.index(0)] += 0.3;
    let [first, second] = [0, 1].map(|joint| fitted.checks().whiteness[joint].is_white());
    assert!(!first && second);
}

fn without_dry_friction_is_far_worse(checks: &Checks) {
    for dry in &checks.without_dry_friction {
        assert!(dry.loss_increase > 1_000.0, "{dry:?}");
    }
}

/// A slow swing: only sliding in one direction distinguishes dry friction from viscous.
fn slow_swing(config: &PlantConfig, seconds: f64, seed: u64) -> Trace {
    let mut arm_loop = TrackingLoop::on(config, servos(&prior_setup(config)), seed);
    arm_loop.go([0.0, 0.0]);
    let slow = |t: f64, amplitude: f64, hz: f64| {
        let (sin, cos) = (TAU * hz * t).sin_cos();
        let amplitude = amplitude * (t / 2.0).min(1.0);
        [amplitude * sin, amplitude * TAU * hz * cos]
    };
    arm_loop.track(seconds, |t| [slow(t, 0.5, 0.2), slow(t, 0.7, 0.15)]);
    arm_loop.trace
}

#[test]
fn without_dry_friction_a_slow_joint_gets_another_viscous_friction() {
    let config = PlantConfig::drawn(5, 0.4);
    let checks = fitted_in(&config, slow_swing(&config, 30.0, 98)).checks();
    without_dry_friction_is_far_worse(&checks);
    for dry in &checks.without_dry_friction {
        let [with, without] = dry.viscous_nm_s_rad;
        assert!((without / with - 1.0).abs() > 0.1, "{dry:?}");
    }
}

#[test]
fn a_held_out_log_is_forecast_to_less_than_a_count() {
    let config = PlantConfig::drawn(5, 0.4);
    let mut fitted = fitted(&config);
    // Another motion, and other noise.
    let held_out = [slow_swing(&config, 15.0, 99)];
    let rms = |fitted: &Fitted| {
        let forecasts = forecast(&fitted.fit, &held_out, &fitted.known);
        for forecast in &forecasts {
            println!("{forecast:?}");
            assert!(
                forecast.longest_s > 1.5 && forecast.sliding_s > 8.0,
                "{forecast:?}"
            );
            assert!(
                forecast
                    .unstable_time_constant_s
                    .is_some_and(|s| (0.1..3.0).contains(&s)),
                "{forecast:?}"
            );
        }
        [0, 1].map(|joint: usize| {
            (
                forecasts[joint].model_rms_counts,
                forecasts[joint].rms_counts,
            )
        })
    };
    for (model, rms) in rms(&fitted) {
        assert!(model < 0.6 && rms < 1.25, "{model} of {rms}");
    }
    fitted.fit.coordinates[Quantity::Viscous.index(1)] += 0.3;
    let [_, (model, _)] = rms(&fitted);
    assert!(model > 1.0, "{model}");
}

#[test]
fn a_stribeck_curve_is_identified() {
    const SPEED_RAD_S: f64 = 0.5;
    let mut config = PlantConfig::drawn(5, 0.4);
    for friction in &mut config.friction {
        friction.static_nm = 2.5 * friction.coulomb_nm;
        friction.stribeck_rad_s = SPEED_RAD_S;
    }
    let fitted = fitted(&config);
    let fit = &fitted.fit;
    let is_right = |[value, error]: [f64; 2], truth: f64| {
        println!("{value:.4} ± {error:.4} for {truth:.4}");
        assert!((value - truth).abs() < 3.0 * error && error < 0.1 * truth);
    };
    for joint in 0..JOINTS {
        let truth = config.friction[joint];
        let curve = fit.stribeck[joint].expect("a Stribeck curve");
        assert_eq!(fit.load[joint], None);
        let drop_nm = truth.static_nm - truth.coulomb_nm;
        is_right([curve.drop_nm, curve.drop_error_nm], drop_nm);
        is_right([curve.speed_rad_s, curve.speed_error_rad_s], SPEED_RAD_S);
        let coulomb = fit.estimate(joint, Quantity::Coulomb);
        is_right(coulomb.into(), truth.coulomb_nm);
        let viscous = fit.estimate(joint, Quantity::Viscous);
        is_right(viscous.into(), [config.arm.b1, config.arm.b2][joint]);
    }
    let warnings = fitted.checks().warnings;
    let missing = warnings
        .iter()
        .find(|warning| warning.contains("the model lacks"));
    assert_eq!(missing, None);
}

/// Load friction of an XL330, from its recordings.
const LOAD: f64 = 0.17;

#[test]
fn friction_that_grows_with_the_load_is_identified() {
    let mut config = PlantConfig::drawn(5, 0.4);
    for friction in &mut config.friction {
        friction.load = LOAD;
    }
    let fitted = fitted(&config);
    let fit = &fitted.fit;
    let is_right = |[value, error]: [f64; 2], truth: f64, share: f64| {
        println!("{value:.4} ± {error:.4} for {truth:.4}");
        assert!((value - truth).abs() < 3.0 * error && error < share * truth);
    };
    for joint in 0..JOINTS {
        let truth = config.friction[joint];
        let load = fit.load[joint].expect("load friction");
        is_right([load.load, load.error], LOAD, 0.1);
        let estimate = |quantity| fit.estimate(joint, quantity).into();
        is_right(estimate(Quantity::Coulomb), truth.coulomb_nm, 0.2);
        let viscous = [config.arm.b1, config.arm.b2][joint];
        is_right(estimate(Quantity::Viscous), viscous, 0.1);
        let gain = config.joints[joint].gain_counts_per_nm;
        is_right(estimate(Quantity::Gain), gain, 0.1);
        assert_eq!(fit.stribeck[joint], None);
    }
    let warnings = fitted.checks().warnings;
    let missing = warnings
        .iter()
        .find(|warning| warning.contains("the model lacks"));
    assert_eq!(missing, None);
}
