//! Comparison of margins with simulations of loops perturbed by them, with the shared
//! estimator and the exact linear arm, tick by tick.

use armbridge_control::arm::Parameters;
use armbridge_control::controller::{ComputedTorque, Controller as Law, Lqr};
use armbridge_control::estimate::{Config, Estimator, Tuning};
use armbridge_control::trajectory::Reference;
use armbridge_link::message::{Controller, Gains, Setup};
use armbridge_servo::JOINTS;
use nalgebra::{Complex, Matrix2, Vector2, Vector4};

use super::model::LinearLoop;
use super::*;

/// Set-ups of every kind of controller and estimator, at short and long periods.
fn setups() -> Vec<(&'static str, Setup)> {
    let default = Setup::default();
    let frictionless = |config: Config<f32>| match config {
        Config::Kalman(tuning) => Config::Kalman(Tuning {
            coulomb_nm: 0.0,
            ..tuning
        }),
        other => other,
    };
    vec![
        ("default", default),
        (
            "kalman",
            Setup {
                estimator: frictionless(Config::kalman()),
                friction_nm: [0.0; JOINTS],
                ..Setup::best()
            },
        ),
        (
            "difference, computed torque",
            Setup {
                controller: Controller::ComputedTorque {
                    natural_rad_s: [15.0, 20.0],
                    damping: [1.0, 0.8],
                },
                estimator: Config::FiniteDifference { filter_s: 0.01 },
                ..default
            },
        ),
        (
            "paper, 45 ms",
            Setup {
                period_us: 45_000,
                controller: Controller::StateFeedback(Gains::Paper),
                ..default
            },
        ),
        (
            "coupled, 5 ms",
            Setup {
                period_us: 5_000,
                controller: Controller::StateFeedback(Gains::Given([
                    [2.5, 0.6, 0.3, 0.05],
                    [-0.5, 2.0, 0.0, 0.25],
                ])),
                ..default
            },
        ),
    ]
}

/// Error of the torques, joint by joint.
#[derive(Clone, Copy)]
struct TorqueError {
    gain: [f64; JOINTS],
    delay_s: [f64; JOINTS],
}

const NO_ERROR: TorqueError = TorqueError {
    gain: [1.0; JOINTS],
    delay_s: [0.0; JOINTS],
};

/// Whether a small deviation grows under a torque error: the linear arm is stepped between
/// changes of the torques, under the shared estimator and control law.
fn grows(setup: &Setup, wrong: TorqueError) -> bool {
    const LONGEST_S: f64 = 200.0;
    const BEGIN: f64 = 1e-7;

    let system = LinearLoop::from_setup(setup).unwrap();
    let period_s = system.period_s;
    let (estimator, law, arm) = double(setup);
    let mut estimate = estimator.at_rest(Vector2::zeros());
    // The Kalman filter's gain settles first.
    for _ in 0..(30.0 / period_s) as u32 {
        estimator.correct(&mut estimate, [Some(0.0); JOINTS]);
        estimator.advance(&arm, &mut estimate, Vector2::zeros());
    }
    let mut state = Vector4::new(BEGIN, -BEGIN, 0.0, 0.0);
    let mut torques = vec![Vector2::zeros(); 500];
    // The first half is over before a slow pole shows.
    let quarter = (LONGEST_S / period_s) as usize / 4;
    let mut peaks = [0.0_f64; 4];
    for tick in 0..4 * quarter {
        let prior = estimate.state();
        let rest = Reference::at_rest(Vector2::zeros());
        let demand = law.demand(&arm, &prior, &rest, law.feed_forward(&arm, &rest));
        let requested = demand.torque_nm - estimate.disturbance();
        torques.rotate_right(1);
        torques[0] = requested;
        estimator.correct(&mut estimate, [Some(state[0]), Some(state[1])]);
        estimator.advance(&arm, &mut estimate, requested);
        state = advance(&system, state, &torques, wrong);
        let size = state.norm();
        // Larger than any transient, or decayed.
        if size > 1e4 * BEGIN {
            return true;
        }
        if size < 1e-7 * BEGIN && requested.norm() < 1e-6 * BEGIN {
            return false;
        }
        peaks[tick / quarter] = peaks[tick / quarter].max(size);
    }
    peaks[3] > peaks[2]
}

/// State of the arm a period later; torques, the latest first, act with the error's gain and
/// delay.
fn advance(
    system: &LinearLoop,
    mut state: Vector4<f64>,
    torques: &[Vector2<f64>],
    wrong: TorqueError,
) -> Vector4<f64> {
    let periods = wrong.delay_s.map(|s| (s / system.period_s).floor());
    let late_s = [0, 1].map(|j| wrong.delay_s[j] - periods[j] * system.period_s);
    let cut_s = late_s[0].max(late_s[1]);
    for (length_s, is_first) in [(cut_s, true), (system.period_s - cut_s, false)] {
        let acting = Vector2::from_fn(|j, _| {
            let before = usize::from(is_first && late_s[j] > 0.0);
            wrong.gain[j] * torques[periods[j] as usize + before][j]
        });
        state = system.arm.zero_order_hold(length_s).step(state, acting);
    }
    state
}

/// Estimator, control law and arm in double precision.
fn double(setup: &Setup) -> (Estimator<f64>, Law<f64>, Parameters<f64>) {
    let arm = setup.arm.map(f64::from);
    let period_s = f64::from(setup.period_us) * 1e-6;
    let config = match setup.estimator {
        Config::FiniteDifference { filter_s } => Config::FiniteDifference {
            filter_s: f64::from(filter_s),
        },
        Config::Luenberger { form, poles_45ms } => Config::Luenberger {
            form,
            poles_45ms: poles_45ms.map(|poles| poles.map(f64::from)),
        },
        Config::Gain { form, gain } => Config::Gain {
            form,
            gain: gain.map(|row| row.map(f64::from)),
        },
        Config::Kalman(tuning) => Config::Kalman(Tuning {
            angle_rad: f64::from(tuning.angle_rad),
            acceleration: f64::from(tuning.acceleration),
            disturbance: f64::from(tuning.disturbance),
            coulomb_nm: f64::from(tuning.coulomb_nm),
            slide_rad_s: f64::from(tuning.slide_rad_s),
        }),
    };
    let law = match setup.controller {
        Controller::ComputedTorque {
            natural_rad_s,
            damping,
        } => {
            let tuning = armbridge_control::controller::Tuning {
                natural_rad_s: natural_rad_s.map(f64::from),
                damping: damping.map(f64::from),
            };
            Law::ComputedTorque(ComputedTorque::new(&tuning, period_s).unwrap())
        }
        Controller::StateFeedback(_) => {
            let [first, second] = Design::from_setup(setup).unwrap().gain;
            Law::StateFeedback(Lqr::of_rows(first, second))
        }
    };
    (config.build(&arm, period_s).unwrap(), law, arm)
}

#[test]
fn a_torque_wrong_by_a_margin_is_the_edge() {
    for (name, setup) in setups() {
        let design = Design::from_setup(&setup).unwrap();
        assert!(design.is_stable && !grows(&setup, NO_ERROR), "{name}");
        for joint in 0..JOINTS {
            let margins = design.margins.joints[joint];
            let gain = |factor: f64| {
                let mut gain = NO_ERROR.gain;
                gain[joint] = factor;
                TorqueError { gain, ..NO_ERROR }
            };
            let delay = |s: f64| {
                let mut delay_s = NO_ERROR.delay_s;
                delay_s[joint] = s;
                TorqueError {
                    delay_s,
                    ..NO_ERROR
                }
            };
            let [low, high] = margins.gain.map(Option::unwrap);
            assert!(!grows(&setup, gain(low * 1.01)), "{name}: {low}");
            assert!(grows(&setup, gain(low * 0.99)), "{name}: {low}");
            assert!(!grows(&setup, gain(high * 0.99)), "{name}: {high}");
            assert!(grows(&setup, gain(high * 1.01)), "{name}: {high}");
            let s = margins.delay_s.unwrap();
            assert!(!grows(&setup, delay(s * 0.99)), "{name}: {s}");
            assert!(grows(&setup, delay(s * 1.01)), "{name}: {s}");
        }
    }
}

/// Growth per period of a loop with complex factors on its torques.
fn complex_growth(system: &LinearLoop, factors: [Complex<f64>; JOINTS]) -> f64 {
    let real = |x: f64| Complex::new(x, 0.0);
    let factors = Matrix2::from_diagonal(&factors.into());
    let feedback = system.input.map(real) * factors * system.output.map(real);
    let mut power = system.open.map(real) - feedback;
    let (mut logarithm, mut weight) = (0.0, 1.0);
    for _ in 0..30 {
        let norm = power.iter().map(Complex::norm_sqr).sum::<f64>().sqrt();
        logarithm += weight * norm.ln();
        power /= real(norm);
        power *= power;
        weight *= 0.5;
    }
    logarithm.exp()
}

fn polar(radius: f64, angle_rad: f64) -> Complex<f64> {
    let (sin, cos) = angle_rad.sin_cos();
    Complex::new(radius * cos, radius * sin)
}

#[test]
fn a_turn_by_the_phase_margin_is_the_edge() {
    for (name, setup) in setups() {
        let system = LinearLoop::from_setup(&setup).unwrap();
        let design = Design::from_setup(&setup).unwrap();
        for joint in 0..JOINTS {
            let margin = design.margins.joints[joint].phase.unwrap().margin_deg;
            let grows = |degrees: f64| {
                let mut factors = [polar(1.0, 0.0); JOINTS];
                factors[joint] = polar(1.0, degrees.to_radians());
                complex_growth(&system, factors) > 1.0
            };
            assert!(!grows(margin * 0.99) && !grows(-margin * 0.99), "{name}");
            assert!(grows(margin * 1.01) || grows(-margin * 1.01), "{name}");
        }
    }
}

#[test]
fn inside_the_disc_nothing_grows_and_just_outside_something_does() {
    let one = polar(1.0, 0.0);
    let factor = |d: Complex<f64>| (one + d * 0.5) / (one - d * 0.5);
    for (name, setup) in setups() {
        let system = LinearLoop::from_setup(&setup).unwrap();
        let margins = Design::from_setup(&setup).unwrap().margins;
        let alpha = margins.disc.alpha;
        let around = |size: f64| {
            (0..24 * 24).map(move |i| {
                let angle = |i: usize| i as f64 * core::f64::consts::TAU / 24.0;
                [
                    factor(polar(size, angle(i / 24))),
                    factor(polar(size, angle(i % 24))),
                ]
            })
        };
        for factors in around(0.99 * alpha) {
            assert!(
                complex_growth(&system, factors) < 1.0,
                "{name}: {factors:?}"
            );
        }
        // Joints that do not couple have no margin left: the disc is not too small.
        if !name.starts_with("coupled") {
            let grows = (0..720).any(|i| {
                let angle = f64::from(i) * core::f64::consts::TAU / 720.0;
                let wrong = factor(polar(1.02 * alpha, angle));
                let alone = [[wrong, one], [one, wrong]];
                alone
                    .iter()
                    .any(|factors| complex_growth(&system, *factors) > 1.0)
            });
            assert!(grows, "{name}");
        }
        // Neither joint alone can have less than both together; where the worst is at
        // rest, as much, found another way.
        let [low, high] = margins.disc.gain;
        for joint in margins.joints {
            assert!(
                joint.gain[0].unwrap() <= low * 1.0001 && joint.gain[1].unwrap() >= high,
                "{name}"
            );
            assert!(
                joint.phase.unwrap().margin_deg >= margins.disc.phase_deg,
                "{name}"
            );
        }
        assert!(margins.sensitivity >= 1.0 && margins.sensitivity >= 1.0 / alpha - 0.5);
    }
}

#[test]
fn the_poles_are_those_that_were_asked_for() {
    let setup = Setup::default();
    let system = LinearLoop::from_setup(&setup).unwrap();
    // 20 rad/s, damped by 0.7, and two real poles.
    let (natural, damping, period_s) = (20.0, 0.7, system.period_s);
    let (decay, turn): (f64, f64) = (
        (-damping * natural * period_s).exp(),
        natural * f64::sqrt(1.0 - damping * damping) * period_s,
    );
    let gain = place(
        &setup,
        [
            (2.0 * decay * turn.cos(), decay * decay),
            (0.98 + 0.95, 0.98 * 0.95),
        ],
    );
    let controller = Controller::StateFeedback(Gains::Given(gain.unwrap()));
    let design = Design::from_setup(&Setup {
        controller,
        ..setup
    })
    .unwrap();
    let found: Vec<(f64, f64)> = design
        .poles
        .controller
        .iter()
        .map(|pole| (pole.natural_rad_s, pole.damping))
        .collect();
    let expected = [
        (20.0, 0.7),
        (-f64::ln(0.98) / period_s, 1.0),
        (-f64::ln(0.95) / period_s, 1.0),
    ];
    assert_eq!(found.len(), expected.len());
    for (found, expected) in found.iter().zip(expected) {
        let is_near = |a: f64, b: f64| (a - b).abs() < 2e-3 * b;
        assert!(
            is_near(found.0, expected.0) && is_near(found.1, expected.1),
            "{found:?}"
        );
    }
    // The default observer: time constants of 45 ms / ln 20 and 45 ms / ln(1/0.06).
    let times: Vec<f64> = design
        .poles
        .estimator
        .iter()
        .map(|p| 1e3 / p.natural_rad_s)
        .collect();
    for (time, expected) in times.iter().zip([15.995, 15.021, 15.995, 15.021]) {
        assert!((time - expected).abs() < 1e-2, "{times:?}");
    }
    assert_eq!(times.len(), 4);
}

#[test]
fn what_no_board_runs_with_is_refused() {
    let gain = [[0.0; 4]; 2];
    let controller = Controller::StateFeedback(Gains::Given(gain));
    let setup = Setup {
        controller,
        ..Setup::default()
    };
    assert!(matches!(
        Design::from_setup(&setup),
        Err(Refusal::Unstable { .. })
    ));
}
