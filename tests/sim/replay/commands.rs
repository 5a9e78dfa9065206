//! Runs without errors: every kind of command.

use armbridge_analysis::plan_runner::Script;
use armbridge_client::event::EventKind;
use armbridge_control::estimate::Config;
use armbridge_control::experiment::Signal;
use armbridge_link::experiment::{Experiment, ExperimentEnd, Role};
use armbridge_link::limits::Limits;
use armbridge_link::message::{Command, Setup, ToBoard, ToHost};
use armbridge_link::motion::{Motion, Via};
use armbridge_tests::tapped_bench::{
    Action, ScriptedHost, assert_all_equal, recorded, replay, tapped_run,
};
use armbridge_tests::{computed_torque, plant};

#[test]
fn the_demo_is_the_same_again() {
    for setup in [Setup::default(), Setup::best()] {
        let script = Script::demo(setup, 2_000_000);
        let report = replay(&recorded(plant([0.30, -0.25], true), 1, script));
        assert_all_equal(&report);
        assert!(report.compared > 2_000, "{}", report.text());
    }
}

/// Motions of all kinds, each of which joins the one before or breaks it off.
fn motions() -> Vec<Command> {
    let mut vias = [None; 8];
    vias[0] = Some(Via {
        at_s: 0.3,
        angle_rad: [0.1, 0.1],
    });
    vias[1] = Some(Via {
        at_s: 0.7,
        angle_rad: [-0.1, 0.2],
    });
    let motions = [
        Motion::MinimumJerk {
            to_rad: [0.2, -0.2],
            duration_s: Some(0.4),
        },
        Motion::MinimumJerk {
            to_rad: [0.0, 0.1],
            duration_s: None,
        },
        Motion::Waypoints(vias),
        Motion::Sinusoid {
            centre_rad: [0.0; 2],
            amplitude_rad: [0.1, 0.1],
            frequency_hz: [1.0, 0.7],
            phase_rad: [0.0, 0.5],
            ramp_s: 0.3,
            duration_s: 1.0,
        },
        Motion::Chirp {
            centre_rad: [0.0; 2],
            amplitude_rad: [0.05, 0.05],
            from_hz: [0.5, 0.5],
            to_hz: [2.0, 1.5],
            ramp_s: 0.2,
            duration_s: 1.0,
        },
    ];
    motions.map(Command::Follow).into()
}

fn set_ups() -> [Setup; 4] {
    let computed_torque = computed_torque(15.0);
    [
        Setup::best(),
        computed_torque,
        Setup {
            estimator: Config::standing(),
            ..computed_torque
        },
        Setup {
            estimator: Config::FiniteDifference { filter_s: 0.01 },
            ..Setup::default()
        },
    ]
}

#[test]
fn every_order_is_taken_where_the_board_took_it() {
    let mut commands = vec![Command::Regulate([0.0; 2])];
    commands.extend(motions());
    for setup in set_ups() {
        commands.push(Command::Configure(setup));
        commands.push(motions()[0]);
    }
    // Torque is refused where it is too much, and a motion that goes too far.
    commands.push(Command::Torque([0.05, -0.05]));
    commands.push(Command::Torque([9.0, 0.0]));
    commands.push(Command::Regulate([0.05, 0.0]));
    commands.push(Command::Follow(Motion::MinimumJerk {
        to_rad: [0.0, 0.0],
        duration_s: Some(0.001),
    }));
    let mut at_us = 1_000_000;
    let mut scheduled: Vec<_> = commands
        .into_iter()
        .map(|command| {
            at_us += 433_210;
            (at_us, command)
        })
        .collect();
    for point in 0..20 {
        at_us += 20_000;
        let stream = Command::Stream {
            at_us: at_us + 150_000,
            angle_rad: [0.002 * point as f32, 0.0],
            speed_rad_s: (point % 2 == 0).then_some([0.1, 0.0]),
        };
        scheduled.push((at_us, stream));
    }
    let script = Script {
        setup: Setup::default(),
        limits: Script::limits(),
        commands: scheduled,
        duration_us: at_us + 500_000,
    };
    let acts = [
        (100_000, Command::Limit(Limits::default())),
        (110_000, Command::Configure(script.setup)),
        (130_000, Command::Save),
        (150_000, Command::Arm { session: 0 }),
    ];
    let acts = acts.into_iter().chain(script.commands);
    let acts = acts.map(|(at_us, command)| (at_us, Action::Command(command)));
    let host = ScriptedHost::new(acts, script.duration_us);
    let report = replay(&tapped_run(
        host,
        plant([0.02, -0.02], true),
        3,
        |_, _, _| {},
    ));
    assert_all_equal(&report);
    // Each was answered, but those that were never taken.
    assert!(report.answers >= 35, "{}", report.text());
}

/// Limits that brake the arm, hold its torque back, and in the end switch it off.
#[test]
fn guards_do_the_same_again() {
    let limits = Limits {
        angle_rad: [0.25, 0.25],
        torque_nm: [0.3, 0.2],
        torque_rate_nm_s: 20.0,
        pwm_counts: 300,
        ..Limits::default()
    };
    let commands = [
        (100_000, Command::Limit(limits)),
        (150_000, Command::Arm { session: 0 }),
        (200_000, Command::Regulate([0.0, 0.0])),
        (600_000, Command::Regulate([0.22, 0.0])),
        (1_000_000, Command::Regulate([0.22, 0.3])),
        (1_500_000, Command::Torque([0.4, 0.4])),
        (2_200_000, Command::ClearFault),
        (2_300_000, Command::Arm { session: 0 }),
        (2_320_000, Command::Torque([0.3, 0.1])),
    ];
    let acts = commands.map(|(at_us, command)| (at_us, Action::Command(command)));
    let host = ScriptedHost::new(acts, 3_000_000);
    let events = tapped_run(host, plant([0.1, -0.1], true), 4, |_, _, _| {});
    let report = replay(&events);
    assert_all_equal(&report);
    let guarded = armbridge_tests::tapped_bench::records(&events)
        .filter(|record| record.output.guards.bits() != 0)
        .count();
    assert!(guarded > 10, "{guarded}");
}

/// The host falls silent in a motion and under constant torque, comes back, falls
/// silent for good; sends goodbye, and hello again.
#[test]
fn silence_has_the_same_effect() {
    let wave = motions()[3];
    let acts = [
        (150_000, Action::Command(Command::Arm { session: 0 })),
        (200_000, Action::Command(wave)),
        (400_000, Action::Silence(300_000)),
        (800_000, Action::Command(Command::Torque([0.02, 0.0]))),
        (900_000, Action::Silence(200_000)),
        (1_200_000, Action::Command(wave)),
        (1_400_000, Action::Silence(800_000)),
        (2_300_000, Action::Command(Command::ClearFault)),
        (2_500_000, Action::Command(Command::Arm { session: 0 })),
        (2_600_000, Action::Command(Command::Regulate([0.0; 2]))),
        (2_700_000, Action::Message(ToBoard::Goodbye)),
        (2_900_000, Action::Command(Command::Arm { session: 0 })),
        (3_000_000, Action::Command(Command::Regulate([0.0; 2]))),
    ];
    let host = ScriptedHost::new(acts, 3_300_000);
    let report = replay(&tapped_run(host, plant([0.02, 0.0], true), 5, |_, _, _| {}));
    assert_all_equal(&report);
}

/// Experiments that end in every way there is.
#[test]
fn experiments_begin_and_end_where_they_did() {
    let plan = |role| Experiment {
        roles: [Role::Hold, role],
        duration_s: 0.3,
        angle_rad: [[-0.5, 0.5]; 2],
        speed_rad_s: [2.0; 2],
    };
    let multisine = Role::Angle(Signal::Multisine {
        amplitude: 0.015,
        lowest_hz: 0.5,
        lines: 3,
        ramp_s: 0.1,
    });
    let push = Role::Pwm(Signal::Constant(300.0));
    let narrow = Experiment {
        angle_rad: [[-0.5, 0.5], [-0.2, 0.2]],
        ..plan(push)
    };
    let slow = Experiment {
        speed_rad_s: [2.0, 0.5],
        ..plan(push)
    };
    let long = Experiment {
        duration_s: 5.0,
        ..plan(Role::Torque(Signal::Constant(0.02)))
    };
    let commands = [
        (150_000, Command::Arm { session: 0 }),
        (200_000, Command::Regulate([0.0; 2])),
        (700_000, Command::Experiment(plan(multisine))),
        (1_200_000, Command::Experiment(plan(Role::Off))),
        (1_300_000, Command::Experiment(narrow)),
        (1_900_000, Command::Regulate([0.0; 2])),
        (2_400_000, Command::Experiment(slow)),
        (2_900_000, Command::Regulate([0.0; 2])),
        (3_400_000, Command::Experiment(long)),
    ];
    let acts = commands.map(|(at_us, command)| (at_us, Action::Command(command)));
    let acts = acts
        .into_iter()
        .chain([(3_700_000, Action::Silence(2_000_000))]);
    let host = ScriptedHost::new(acts, 4_500_000);
    let events = tapped_run(host, plant([0.0, 0.0], true), 8, |_, _, _| {});
    let ends = events.iter().filter_map(|event| match event.kind {
        EventKind::Received(_, ToHost::Concluded(conclusion)) => Some(conclusion.end),
        _ => None,
    });
    let ends: Vec<_> = ends.collect();
    assert!(
        matches!(
            ends[..],
            [
                ExperimentEnd::Finished,
                ExperimentEnd::Replaced,
                ExperimentEnd::Angle { joint: 1, .. },
                ExperimentEnd::Speed { joint: 1, .. },
                ExperimentEnd::HostQuiet,
            ]
        ),
        "{ends:?}"
    );
    let report = replay(&events);
    assert_all_equal(&report);
    assert_eq!(report.answers, 9, "{}", report.text());
    // A different end is recorded.
    let mut other = events;
    for event in &mut other {
        if let EventKind::Received(_, ToHost::Record(record)) = &mut event.kind
            && let Some(events) = &mut record.output.events
            && let Some(ExperimentEnd::Angle { value_rad, .. }) = &mut events.experiment_end
        {
            *value_rad += 1e-3;
        }
    }
    let report = replay(&other);
    assert_eq!((report.differing, report.answers_differing), (1, 0));
    assert_eq!(report.first.unwrap().field, "experiment_end");
}
