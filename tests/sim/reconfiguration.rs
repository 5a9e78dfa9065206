//! Set-ups and sources of the reference taken over while the arm moves, and refused.

use armbridge_analysis::plan_runner::Script;
use armbridge_board::bridge::Channels;
use armbridge_control::estimate::Config;
use armbridge_link::message::{Command, Controller, Drive, Gains, Record, Setup};
use armbridge_link::motion::Motion;
use armbridge_sim::cosim::CosimError;
use armbridge_sim::plant::PlantConfig;
use armbridge_tests::{bench_run, plant, records};

/// Controller, estimator and gains are replaced while the arm swings: the torque
/// goes on as if nothing had happened, and the arm is moved as before.
#[test]
fn a_setup_taken_over_in_mid_motion_makes_no_step_in_the_torque() {
    let config = PlantConfig {
        noise_lsb_rms: 0.0,
        ..plant([0.0, 0.0], false)
    };
    let best = Setup::best();
    let paper = Setup {
        estimator: Config::standing(),
        friction_nm: [0.0; 2],
        ..Setup::default()
    };
    let wave = Motion::Sinusoid {
        centre_rad: [0.0; 2],
        amplitude_rad: [0.3, -0.3],
        frequency_hz: [0.5; 2],
        phase_rad: [0.0; 2],
        ramp_s: 0.8,
        duration_s: 6.0,
    };
    let script = |switches: &[(u64, Setup)]| {
        let mut commands = vec![
            (0, Command::Regulate([0.0; 2])),
            (300_000, Command::Follow(wave)),
        ];
        let configures = switches.iter();
        commands.extend(configures.map(|(at_us, setup)| (*at_us, Command::Configure(*setup))));
        Script {
            setup: best,
            limits: Script::limits(),
            commands,
            duration_us: 5_000_000,
        }
    };
    let largest_step = |records: &[Record]| {
        let moving = records
            .windows(2)
            .filter(|two| two[1].mode.drive() == Some(Drive::Track));
        moving
            .flat_map(|two| [0, 1].map(|j| two[1].output.pwm[j].abs_diff(two[0].output.pwm[j])))
            .max()
            .unwrap()
    };
    let left_alone = records(config, 1, script(&[]));
    let switched = records(
        config,
        1,
        script(&[(2_000_000, paper), (3_100_000, best), (4_000_000, paper)]),
    );
    assert!(switched.iter().all(|record| record.timing.missed == 0));
    assert!(
        largest_step(&switched) <= largest_step(&left_alone) + 3,
        "PWM steps by {}, left alone by {}",
        largest_step(&switched),
        largest_step(&left_alone)
    );
    let away = switched
        .iter()
        .filter(|record| record.mode.drive() == Some(Drive::Track));
    let error = away
        .flat_map(|r| [0, 1].map(|j| (r.output.angle_rad[j] - r.output.reference_rad[j]).abs()));
    let worst = error.fold(0.0, f32::max);
    assert!(worst < 0.05, "{worst}");
}

#[test]
fn a_constant_torque_is_left_without_a_step() {
    let config = PlantConfig {
        noise_lsb_rms: 0.0,
        ..plant([0.0, 0.0], false)
    };
    let script = Script {
        setup: Setup::best(),
        limits: Script::limits(),
        commands: vec![
            (0, Command::Torque([0.15, -0.15])),
            (150_000, Command::Regulate([0.0, 0.0])),
        ],
        duration_us: 2_000_000,
    };
    let records = records(config, 1, script);
    let change = records
        .windows(2)
        .find(|two| {
            two[0].mode.drive() == Some(Drive::Torque)
                && two[1].mode.drive() == Some(Drive::Regulate)
        })
        .unwrap();
    for joint in 0..2 {
        let step = change[1].output.pwm[joint].abs_diff(change[0].output.pwm[joint]);
        // A hundredth of what is faded out, and what a tick's motion changes;
        // the whole of it would be hundreds of counts.
        assert!(step <= 12, "{change:?}");
    }
    let last = records.last().unwrap();
    assert!(
        last.output.angle_rad.iter().all(|q| q.abs() < 0.01),
        "{last:?}"
    );
}

#[test]
fn a_gain_that_would_let_the_arm_fall_is_refused_with_its_eigenvalue() {
    let weak = [[0.3, 0.0, 0.1, 0.0], [0.0, 0.3, 0.0, 0.1]];
    let setup = Setup {
        controller: Controller::StateFeedback(Gains::Given(weak)),
        ..Setup::default()
    };
    let mut channels = Channels::new();
    let script = Script::upright(setup, 1_000_000);
    let mut run = bench_run(&mut channels, plant([0.1, 0.0], false), 1, script);
    let Err(CosimError::Host(error)) = run.run() else {
        panic!("accepted");
    };
    // Gravity pushes joint 1 by 0.57 N m/rad, and 0.3 do not hold it:
    // s^2 + 11.06 s - 8.80 = 0 has a root at 0.745 per second, 1.00075 a tick.
    assert_eq!(
        error.to_string(),
        "the board refused `configure`: the closed loop would grow: eigenvalue 1.0007, \
         magnitude 1.0007; it must be below 1"
    );
}
