//! An arm of one joint: found, checked, held, moved, parked and off, with each firmware.
//!
//! The number of joints is that of the board's arm, [`Parameters::joints`]. The servo of the other
//! joint is not on the bus.

use std::convert::Infallible;

use armbridge_analysis::plan_runner::{PlanError, PlanRunner, Script};
use armbridge_board::bridge::Channels;
use armbridge_control::arm::Parameters;
use armbridge_control::experiment::Signal;
use armbridge_link::experiment::{Experiment, Role};
use armbridge_link::message::{Command, Drive, Mode, Refusal, Sample, Setup};
use armbridge_link::motion::Motion;
use armbridge_servo::{Firmware, Missing};
use armbridge_sim::board::VirtualBoard;
use armbridge_sim::cosim::{Cosim, CosimError};
use armbridge_sim::plant::PlantConfig;
use armbridge_tests::transparent_port::bench;
use armbridge_tests::{calibrations, plant, settling_s};

const FIRMWARES: [Firmware; 3] = [Firmware::Morpheus, Firmware::Stock, Firmware::XSeries];

/// The paper's arm without its second link, and a mass at the end of the first.
fn pendulum<T: armbridge_control::real::Real>() -> Parameters<T> {
    Parameters {
        l1: T::lit(0.2),
        m1: T::lit(0.3),
        l2: T::lit(0.0),
        m2: T::lit(0.0),
        ..Parameters::paper()
    }
}

fn setup(firmware: Firmware) -> Setup {
    Setup {
        arm: pendulum(),
        joints: calibrations(firmware),
        ..Setup::best()
    }
}

fn arm() -> PlantConfig {
    PlantConfig {
        arm: pendulum(),
        ..plant([0.3, 0.0], true)
    }
}

/// Runs this script with one servo.
fn run(
    firmware: Firmware,
    script: Script,
    channels: &mut Channels,
) -> (
    Cosim<VirtualBoard<'_>, PlanRunner>,
    Result<(), CosimError<Infallible, PlanError>>,
) {
    let board = VirtualBoard::new(channels.split()).unwrap();
    let bench = bench(&arm(), [firmware; 2], 1_000_000);
    assert_eq!(bench.servos().len(), 1);
    let mut cosim = Cosim::new(board, bench, PlanRunner::new(script));
    let result = cosim.run();
    (cosim, result)
}

fn regulate(angle_rad: f32) -> Command {
    Command::Regulate([angle_rad, 0.0])
}

#[test]
fn a_pendulum_of_one_servo_is_held_and_moved() {
    for firmware in FIRMWARES {
        let motion = Motion::MinimumJerk {
            to_rad: [0.4, 0.0],
            duration_s: Some(1.0),
        };
        let script = Script {
            commands: vec![(0, regulate(0.0)), (2_000_000, Command::Follow(motion))],
            ..Script::upright(setup(firmware), 4_500_000)
        };
        let mut channels = Channels::new();
        let (cosim, result) = run(firmware, script, &mut channels);
        result.unwrap_or_else(|error| panic!("{firmware:?}: {error:?}"));
        assert_eq!(cosim.host.status().servos.unwrap().firmware, firmware);
        let records = cosim.host.into_parts().0;
        for record in &records {
            assert!(record.input.samples[0].counts().is_some());
            assert_eq!(
                record.input.samples[1],
                Sample::Missing(Missing::NotAsked),
                "{firmware:?}, {record:?}"
            );
            // The joint that is not there has neither torque nor motion.
            assert_eq!(record.output.pwm[1], 1_000);
            let joint_2 = [
                record.output.torque_nm[1],
                record.output.angle_rad[1],
                record.output.speed_rad_s[1],
                record.output.disturbance_nm[1],
            ];
            assert!(joint_2.iter().all(|value| *value == 0.0), "{joint_2:?}");
        }
        let settled_s = settling_s(&records, 0, 0.02).expect("settled");
        let last = records.last().unwrap();
        assert_eq!(last.mode, Mode::Running(Drive::Track));
        let rest = &records[records.len() - 500..];
        let errors = rest
            .iter()
            .map(|record| (record.output.angle_rad[0] - 0.4).abs());
        let off_rad = errors.fold(0.0, f32::max);
        println!("{firmware:?}: settled after {settled_s:.2} s, off by {off_rad:.4} rad");
        assert!(settled_s < 0.6, "{settled_s}");
        assert!(off_rad < 0.005, "{firmware:?}: {off_rad}");
    }
}

#[test]
fn a_command_to_a_joint_that_is_not_there_is_refused() {
    let beyond = |command: Command| {
        let script = Script {
            commands: vec![(0, regulate(0.0)), (500_000, command)],
            ..Script::upright(setup(Firmware::Morpheus), 1_000_000)
        };
        let mut channels = Channels::new();
        match run(Firmware::Morpheus, script, &mut channels).1 {
            Err(CosimError::Host(PlanError::Refused { refusal, .. })) => refusal,
            other => panic!("{command:?}: {other:?}"),
        }
    };
    let motion = Motion::MinimumJerk {
        to_rad: [0.0, 0.1],
        duration_s: Some(1.0),
    };
    // Ends where joint 2 is not asked to go.
    let sinusoid = Motion::Sinusoid {
        centre_rad: [0.0; 2],
        amplitude_rad: [0.1; 2],
        frequency_hz: [0.5; 2],
        phase_rad: [0.0; 2],
        ramp_s: 0.5,
        duration_s: 2.0,
    };
    let experiment = Experiment {
        roles: [Role::Hold, Role::Pwm(Signal::Constant(0.0))],
        duration_s: 0.5,
        angle_rad: [[-0.5, 0.5]; 2],
        speed_rad_s: [2.0; 2],
    };
    for command in [
        Command::Regulate([0.0, 0.1]),
        Command::Torque([0.0, -0.1]),
        Command::Follow(motion),
        Command::Follow(sinusoid),
        Command::Experiment(experiment),
    ] {
        assert!(
            matches!(
                beyond(command),
                Refusal::Beyond {
                    joint: 1,
                    limit: 0.0,
                    ..
                }
            ),
            "{command:?}"
        );
    }
}
