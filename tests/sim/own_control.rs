//! Control of a user's own: observer gain and poles, integral action, on the bench.

use armbridge_analysis::monte_carlo::{Maneuver, Outcome, Trial};
use armbridge_board::bridge::settings_refusal;
use armbridge_control::arm::Parameters;
use armbridge_control::design::placement::Poles;
use armbridge_control::estimate::{Config, Estimator, Form};
use armbridge_link::frame::Encoder;
use armbridge_link::message::{Controller, Gains, Limits, Refusal, Settings, Setup, ToHost};
use armbridge_sim::plant::PlantConfig;
use armbridge_tests::{plant, records};

fn refusal(setup: Setup) -> Option<Refusal> {
    settings_refusal(&Settings {
        setup,
        ..Settings::default()
    })
}

/// The gains in the current form that the board places for poles.
fn placed(config: Config<f32>) -> [[f32; 2]; 2] {
    let estimator = config.build(&Parameters::paper(), 0.001).unwrap();
    let Estimator::Luenberger(observer) = estimator else {
        panic!("{estimator:?}")
    };
    observer.gains().map(Into::into)
}

#[test]
fn a_gain_that_is_the_placed_one_runs_the_same_to_the_bit() {
    let poles_45ms = [
        Poles::Conjugate { re: 0.2, im: 0.1 },
        Poles::Real(0.05, 0.06),
    ];
    let form = Form::Current;
    let by_poles = Config::Luenberger { form, poles_45ms };
    let given = Config::Gain {
        form,
        gain: placed(by_poles),
    };
    let of = |estimator| {
        let setup = Setup {
            estimator,
            ..Setup::default()
        };
        let script = armbridge_analysis::plan_runner::Script::demo(setup, 1_000_000);
        records(plant([0.30, -0.25], true), 1, script)
    };
    let (ours, theirs) = (of(by_poles), of(given));
    assert!(ours.len() > 900);
    assert_eq!(ours, theirs);
}

#[test]
fn what_grows_is_refused_with_its_eigenvalue() {
    let default = Setup::default();
    // Corrects the angle by more than twice what it is off.
    let estimator = Config::Gain {
        form: Form::Current,
        gain: [[2.5, 0.0], [0.05, 1.0]],
    };
    let refused = refusal(Setup {
        estimator,
        ..default
    });
    let Some(Refusal::UnstableObserver { re, im }) = refused else {
        panic!("{refused:?}")
    };
    assert!((1.4..1.6).contains(&re.hypot(im)), "{re} {im}");
    let poles_45ms = [Poles::Conjugate { re: 0.8, im: 0.7 }, Poles::Real(0.1, 0.1)];
    let estimator = Config::Luenberger {
        form: Form::Current,
        poles_45ms,
    };
    assert!(matches!(
        refusal(Setup {
            estimator,
            ..default
        }),
        Some(Refusal::UnstableObserver { .. })
    ));
    // The default loop has a stiffness of about 1 N m/rad and a time constant of 0.2 s.
    for (integral, is_stable) in [(0.01, true), (0.5, true), (1.0, true), (100.0, false)] {
        let refused = refusal(Setup {
            integral: [integral; 2],
            ..default
        });
        match refused {
            None => assert!(is_stable, "{integral}"),
            Some(Refusal::Unstable { re, im }) => {
                assert!(!is_stable && re.hypot(im) > 1.0, "{integral}: {re} {im}");
            }
            other => panic!("{other:?}"),
        }
    }
    let controller = Controller::StateFeedback(Gains::Design {
        q: [1e38, 15.0, 1.0, 1.0],
        r: [10.0; 2],
    });
    assert_eq!(
        refusal(Setup {
            controller,
            ..default
        }),
        Some(Refusal::OutOfRange)
    );
}

/// Motors whose zero is off by 15 counts, 18 mN m: the law alone rests off by that torque over
/// its stiffness, with integral action by nothing.
#[test]
fn integral_action_takes_a_constant_error_to_zero() {
    let config = PlantConfig {
        pwm_offset_counts: 15.0 + 15.0,
        noise_lsb_rms: 1.0,
        ..plant([0.1, -0.1], false)
    };
    let rest = |integral: f32| {
        let setup = Setup {
            integral: [integral; 2],
            ..Setup::default()
        };
        let task: Maneuver = "upright".parse().unwrap();
        let trial = Trial::new(config, task.script(setup, 12.0).unwrap());
        let run = trial.run(1).unwrap();
        let outcome = Outcome::from_run(&trial, 1, &run);
        assert_eq!(outcome.fault, None, "{outcome:?}");
        outcome.mean_error_mrad
    };
    let (without, with) = (rest(0.0), rest(1.0));
    println!("at rest off by {without:?} mrad without and {with:?} mrad with integral action");
    for joint in 0..2 {
        assert!(without[joint].abs() > 8.0, "{without:?}");
        assert!(with[joint].abs() < 1.0, "{with:?}");
    }
}

/// The longest settings that a board has fit into a frame.
#[test]
fn the_longest_valid_settings_are_a_frame() {
    let setup = Setup {
        period_us: 100_000,
        controller: Controller::StateFeedback(Gains::Given([[1.1; 4]; 2])),
        estimator: Config::kalman(),
        integral: [0.123_456; 2],
        friction_nm: [0.123_456; 2],
        friction_load_percent: [50; 2],
        ..Setup::default()
    };
    let limits = Limits {
        lost_ms: 100,
        quiet_ms: u16::MAX,
        setpoint_age_ms: u16::MAX,
        client_silence_ms: u16::MAX,
        torque_age_ms: 10_000,
        stream_age_ms: 10_000,
        ..Limits::default()
    };
    let mut encoder = Encoder::default();
    let (_, frame) = encoder.encode(&ToHost::Settings(Settings { setup, limits }));
    assert!(frame.len() > 230, "{}", frame.len());
}
