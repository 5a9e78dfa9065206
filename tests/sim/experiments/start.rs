//! From what an experiment may begin: rest, motion, and motors that were off.

use armbridge_control::experiment::Signal;
use armbridge_link::experiment::{ExperimentEnd, Role};
use armbridge_link::message::{Command, Drive, Record};
use armbridge_link::motion::Motion;
use armbridge_tests::tapped_bench::{Action, ScriptedHost, records, tapped_run};

use super::{BEGIN_US, arm_at, conclusions, during, experiment, heard_at, refusals};

/// The controller holds the arm where it is, with the first torque.
#[test]
fn from_armed() {
    let plan = experiment([Role::Hold, Role::Torque(Signal::Constant(0.03))], 0.5);
    let acts = [
        (150_000, Action::Command(Command::Arm { session: 0 })),
        (300_000, Action::Command(Command::Experiment(plan))),
    ];
    let host = ScriptedHost::new(acts, 1_000_000);
    let events = tapped_run(host, arm_at([0.3, -0.2]), 1, |_, _, _| {});
    assert_eq!(refusals(&events), []);
    let ticks = during(&events);
    assert_eq!(ticks.len(), 500);
    // It falls until then, and its estimator begins anew with a sample that has noise.
    let apart_rad = ticks[0].output.reference_rad[0] - ticks[0].output.angle_rad[0];
    assert!(apart_rad.abs() < 0.02, "{apart_rad}");
    let bits = |record: &Record| record.output.reference_rad[0].to_bits();
    assert!(ticks.iter().all(|record| bits(record) == bits(&ticks[0])));
    let ends: Vec<_> = conclusions(&events).iter().map(|it| it.end).collect();
    assert_eq!(ends, [ExperimentEnd::Finished]);
}

/// In the middle of a motion the joints that are held are braked, without a step.
#[test]
fn from_a_motion() {
    let motion = Motion::MinimumJerk {
        to_rad: [0.6, -0.6],
        duration_s: Some(1.0),
    };
    let wave = Signal::Sinusoid {
        offset: 0.0,
        amplitude: 0.05,
        frequency_hz: 1.0,
        ramp_s: 0.5,
    };
    let plan = experiment([Role::Hold, Role::Angle(wave)], 2.0);
    let acts = [
        (BEGIN_US, Action::Command(Command::Follow(motion))),
        // Half way.
        (
            BEGIN_US + 550_000,
            Action::Command(Command::Experiment(plan)),
        ),
    ];
    let events = heard_at([0.0, 0.0], &acts, BEGIN_US + 3_500_000);
    assert_eq!(refusals(&events), []);
    let ticks = during(&events);
    assert_eq!(ticks.len(), 2_000);
    let speed = ticks[0].output.reference_speed_rad_s;
    assert!(speed[0] > 0.8 && speed[1] < -0.8, "{speed:?}");
    assert!(ticks.last().unwrap().output.reference_speed_rad_s[0].abs() < 1e-3);
    let driven = records(&events).filter(|record| {
        matches!(
            record.mode.drive(),
            Some(Drive::Track | Drive::Experiment | Drive::Hold)
        )
    });
    let driven: Vec<_> = driven.collect();
    for two in driven.windows(2) {
        for joint in 0..2 {
            let angle = two[1].output.reference_rad[joint] - two[0].output.reference_rad[joint];
            let speed = two[1].output.reference_speed_rad_s[joint]
                - two[0].output.reference_speed_rad_s[joint];
            // 2 rad/s and 25 rad/s^2 for a tick.
            assert!(angle.abs() < 2e-3 && speed.abs() < 2.5e-2, "{two:?}");
        }
    }
}
