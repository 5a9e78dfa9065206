//! Ends of experiments: once, for a reason, and never with a motor left driven.

use armbridge_client::event::Event;
use armbridge_control::experiment::Signal;
use armbridge_link::experiment::{Experiment, ExperimentEnd, Role};
use armbridge_link::message::{Command, Drive, Fault, Mode, Record, ToBoard};
use armbridge_tests::tapped_bench::{Action, records};

use super::{BEGIN_US, after, conclusions, during, experiment, heard_at, heard_of, refusals};

const PUSH: [Role; 2] = [Role::Hold, Role::Pwm(Signal::Constant(250.0))];

/// Braked, held and at rest, and a host can go on as usual.
#[track_caller]
fn assert_held(events: &[Event]) {
    let rest = after(events);
    let first = rest.first().unwrap();
    assert_eq!(first.mode, Mode::Running(Drive::Hold));
    let held = rest
        .iter()
        .take_while(|record| record.mode.drive() == Some(Drive::Hold));
    let last: &Record = held.last().unwrap();
    assert!(last.tick > first.tick + 500, "{last:?}");
    for joint in 0..2 {
        assert!(last.output.reference_speed_rad_s[joint].abs() < 1e-9);
        assert!(last.output.speed_rad_s[joint].abs() < 0.1, "{last:?}");
        let error = last.output.angle_rad[joint] - last.output.reference_rad[joint];
        assert!(error.abs() < 0.1, "{last:?}");
    }
}

fn only_end(events: &[Event]) -> ExperimentEnd {
    assert_eq!(refusals(events), []);
    let ends = conclusions(events);
    assert_eq!(ends.len(), 1, "{ends:?}");
    ends[0].end
}

#[test]
fn when_its_time_is_over() {
    let events = heard_of([0.1, 0.1], experiment(PUSH, 0.2));
    assert_eq!(only_end(&events), ExperimentEnd::Finished);
    assert_eq!(during(&events).len(), 200);
    assert_held(&events);
}

#[test]
fn when_a_joint_leaves_the_envelope() {
    let plan = Experiment {
        angle_rad: [[-1.0, 1.0], [-0.3, 0.3]],
        ..experiment(PUSH, 2.0)
    };
    let events = heard_of([0.0, 0.0], plan);
    let ExperimentEnd::Angle { joint, value_rad } = only_end(&events) else {
        panic!("{:?}", conclusions(&events));
    };
    assert_eq!(joint, 1);
    assert!((0.3..0.32).contains(&value_rad), "{value_rad}");
    // Until the tick before, it was inside.
    assert!(
        during(&events)
            .iter()
            .all(|record| record.output.angle_rad[1] <= 0.3)
    );
    assert_held(&events);
}

#[test]
fn when_a_joint_is_too_fast() {
    let plan = Experiment {
        speed_rad_s: [2.5, 0.6],
        ..experiment(PUSH, 2.0)
    };
    let events = heard_of([0.0, 0.0], plan);
    let ExperimentEnd::Speed { joint, value_rad_s } = only_end(&events) else {
        panic!("{:?}", conclusions(&events));
    };
    assert_eq!(joint, 1);
    assert!((0.6..0.9).contains(&value_rad_s), "{value_rad_s}");
    assert_held(&events);
}

/// The host is silent: after `hold_ms` it is braked and held, after `silence_ms` torque
/// goes off, as in every drive.
#[test]
fn when_the_host_is_quiet() {
    let plan = experiment([Role::Hold, Role::Pwm(Signal::Constant(30.0))], 60.0);
    let acts = [
        (BEGIN_US, Action::Command(Command::Experiment(plan))),
        (BEGIN_US + 500_000, Action::Silence(5_000_000)),
    ];
    let events = heard_at([0.0, 0.0], &acts, BEGIN_US + 2_000_000);
    assert_eq!(only_end(&events), ExperimentEnd::HostQuiet);
    let lasted_ms = during(&events).len();
    // The last heartbeat was up to 25 ms before.
    assert!((575..=601).contains(&lasted_ms), "{lasted_ms}");
    let rest = after(&events);
    let held = rest
        .iter()
        .filter(|record| record.mode == Mode::Running(Drive::Hold));
    assert!((390..=410).contains(&held.count()));
    let last = rest.last().unwrap();
    assert_eq!(last.mode, Mode::Fault(Fault::HostSilent));
    assert_eq!(last.input.pwm_in_force, [1_000; 2]);
}

#[test]
fn when_the_host_wants_something_else() {
    let plan = experiment(PUSH, 5.0);
    let other = experiment([Role::Hold, Role::Hold], 0.2);
    for command in [
        Command::Regulate([0.0, 0.0]),
        Command::Torque([0.0, 0.0]),
        Command::Idle,
        Command::Experiment(other),
    ] {
        let acts = [
            (BEGIN_US, Action::Command(Command::Experiment(plan))),
            // Sent again: nothing changes.
            (
                BEGIN_US + 50_000,
                Action::Command(Command::Experiment(plan)),
            ),
            (BEGIN_US + 100_000, Action::Command(command)),
        ];
        let events = heard_at([0.0, 0.0], &acts, BEGIN_US + 1_000_000);
        let ends: Vec<_> = conclusions(&events).iter().map(|it| it.end).collect();
        let mut expected = vec![ExperimentEnd::Replaced];
        if let Command::Experiment(_) = command {
            expected.push(ExperimentEnd::Finished);
        }
        assert_eq!(ends, expected, "{command:?}");
        let mode = records(&events).last().unwrap().mode;
        let is_as_wanted = match command {
            Command::Regulate(_) => mode == Mode::Running(Drive::Regulate),
            Command::Torque(_) => mode == Mode::Running(Drive::Torque),
            Command::Idle => mode == Mode::Idle,
            _ => mode == Mode::Running(Drive::Hold),
        };
        assert!(is_as_wanted, "{command:?}: {mode:?}");
    }
}

/// A fault, a stop and a goodbye switch off, as always; there is no other word of it.
#[test]
fn when_torque_goes_off() {
    let plan = experiment(PUSH, 5.0);
    for message in [ToBoard::Stop, ToBoard::Goodbye] {
        let acts = [
            (BEGIN_US, Action::Command(Command::Experiment(plan))),
            (BEGIN_US + 100_000, Action::Message(message)),
        ];
        let events = heard_at([0.0, 0.0], &acts, BEGIN_US + 500_000);
        assert_eq!(conclusions(&events), []);
        let last_experiment = during(&events).last().copied().unwrap();
        let next = records(&events).filter(|record| record.tick > last_experiment.tick + 1);
        assert!(
            next.into_iter()
                .all(|record| record.input.pwm_in_force == [1_000; 2])
        );
    }
}
