//! Why an experiment may not be, or not from here.

use armbridge_board::bridge::permits;
use armbridge_client::event::Event;
use armbridge_control::experiment::{Flaw, Signal};
use armbridge_link::experiment::{Experiment, Measure, Objection, Role};
use armbridge_link::limits::Limits;
use armbridge_link::message::{Command, Drive, Refusal, Settings, Setup};
use armbridge_tests::tapped_bench::{Action, records};

use super::{BEGIN_US, ENVELOPE, during, experiment, heard_at, refusals};

/// Refused for this; the arm goes on with what it did.
#[track_caller]
fn objection(angle_rad: [f32; 2], plan: Experiment) -> Objection {
    // Long enough to see that it does not begin: one of the plans would take ten minutes.
    let acts = [(BEGIN_US, Action::Command(Command::Experiment(plan)))];
    let events = heard_at(angle_rad, &acts, BEGIN_US + 1_500_000);
    assert!(during(&events).is_empty());
    let last = records(&events).last().unwrap();
    assert_eq!(last.mode.drive(), Some(Drive::Regulate));
    let [Refusal::Experiment(objection)] = refusals(&events)[..] else {
        panic!("{:?}", refusals(&events));
    };
    // A host can know before.
    let foreseen = permits(&Settings::default(), &plan, angle_rad);
    let kind = |objection: &Objection| std::mem::discriminant(objection);
    assert_eq!(foreseen.as_ref().map_err(kind), Err(kind(&objection)));
    objection
}

fn wave(amplitude: f32, frequency_hz: f32, ramp_s: f32) -> Signal<f32> {
    Signal::Sinusoid {
        offset: 0.0,
        amplitude,
        frequency_hz,
        ramp_s,
    }
}

#[test]
fn numbers_that_make_no_experiment() {
    let plans = [
        (
            experiment([Role::Hold; 2], 601.0),
            Objection::Duration { value_s: 601.0 },
        ),
        (
            Experiment {
                angle_rad: [[-1.0, 1.0], [0.5, -0.5]],
                ..ENVELOPE
            },
            Objection::Envelope { joint: 1 },
        ),
        (
            Experiment {
                speed_rad_s: [0.0, 1.0],
                ..ENVELOPE
            },
            Objection::Envelope { joint: 0 },
        ),
        (
            experiment([Role::Torque(wave(f32::NAN, 1.0, 0.0)), Role::Hold], 1.0),
            Objection::Signal {
                joint: 0,
                flaw: Flaw::NotFinite,
            },
        ),
        (
            experiment([Role::Hold, Role::Torque(wave(0.1, 1.0, 0.6))], 1.0),
            Objection::Signal {
                joint: 1,
                flaw: Flaw::Ramp,
            },
        ),
        (
            experiment([Role::Hold, Role::Angle(wave(0.1, 1.0, 0.0))], 1.0),
            Objection::Rough { joint: 1 },
        ),
        (
            experiment([Role::Hold, Role::Angle(Signal::Constant(0.1))], 1.0),
            Objection::Rough { joint: 1 },
        ),
        (
            experiment([Role::Pwm(Signal::Constant(-1_001.0)), Role::Hold], 1.0),
            Objection::Beyond {
                joint: 0,
                measure: Measure::Pwm,
                value: -1_001.0,
                limit: 1_000.0,
            },
        ),
        (
            experiment([Role::Hold, Role::Torque(wave(1.3, 1.0, 0.0))], 1.0),
            Objection::Beyond {
                joint: 1,
                measure: Measure::Torque,
                value: 1.3,
                limit: 1.25,
            },
        ),
    ];
    for (plan, expected) in plans {
        let objection_found = objection([0.0, 0.0], plan);
        assert_eq!(objection_found, expected, "{plan:?}");
    }
}

#[test]
fn an_arm_that_is_elsewhere() {
    let plan = Experiment {
        angle_rad: [[-0.3, 0.3], [-1.0, 1.0]],
        ..ENVELOPE
    };
    let Objection::Outside {
        joint,
        angle_rad,
        within_rad,
    } = objection([0.5, 0.0], plan)
    else {
        panic!();
    };
    assert_eq!((joint, within_rad), (0, [-0.3, 0.3]));
    assert!((angle_rad - 0.5).abs() < 0.07, "{angle_rad}");
}

/// The table of the farthest edge: 0.1 rad before the limit an arm is stopped, and it
/// takes 0.15 s to be slowed from below 2 rad/s.
#[test]
fn an_envelope_that_reaches_where_the_arm_is_braked() {
    for (speed, farthest) in [(0.5, 1.325), (2.0, 1.1), (4.0, 0.7), (6.0, 0.1)] {
        let plan = |edge: f32| Experiment {
            angle_rad: [[-0.05, 0.05], [-edge, 0.05]],
            speed_rad_s: [1.0, speed],
            ..ENVELOPE
        };
        let settings = Settings::default();
        assert_eq!(
            permits(&settings, &plan(farthest - 0.001), [0.0; 2]),
            Ok(())
        );
        let Objection::Edge {
            joint,
            edge_rad,
            speed_rad_s,
            farthest_rad,
        } = objection([0.0, 0.0], plan(farthest + 0.001))
        else {
            panic!();
        };
        assert_eq!((joint, speed_rad_s), (1, speed));
        assert!((edge_rad + farthest).abs() < 0.002 && (farthest_rad - farthest).abs() < 1e-4);
    }
}

#[test]
fn an_angle_that_sweeps_too_far_or_too_fast() {
    let swept = |signal, from: [f32; 2]| {
        objection(from, experiment([Role::Hold, Role::Angle(signal)], 4.0))
    };
    let Objection::Beyond {
        joint,
        measure,
        value,
        limit,
    } = swept(wave(0.6, 0.2, 1.0), [0.0, 0.5])
    else {
        panic!();
    };
    assert_eq!((joint, measure, limit), (1, Measure::Angle, 1.0));
    assert!((value - 1.1).abs() < 1e-5, "{value}");
    let Objection::Beyond { measure, limit, .. } = swept(wave(0.5, 1.0, 2.0), [0.0, 0.0]) else {
        panic!();
    };
    assert_eq!((measure, limit), (Measure::Speed, 2.5));
    let Objection::Beyond { measure, limit, .. } = swept(wave(0.1, 3.0, 2.0), [0.0, 0.0]) else {
        panic!();
    };
    assert_eq!((measure, limit), (Measure::Acceleration, 20.0));
}

/// Limits that are in force count, not only those that no host can move.
#[test]
fn more_than_the_limits_in_force() {
    let limits = Limits {
        torque_nm: [0.3; 2],
        pwm_counts: 400,
        speed_rad_s: [2.0; 2],
        ..Limits::default()
    };
    let settings = Settings {
        limits,
        ..Settings::default()
    };
    let slow = |role| Experiment {
        roles: [Role::Hold, role],
        speed_rad_s: [1.0; 2],
        ..ENVELOPE
    };
    for (plan, measure) in [
        (slow(Role::Torque(Signal::Constant(-0.4))), Measure::Torque),
        (slow(Role::Pwm(Signal::Constant(401.0))), Measure::Pwm),
        (ENVELOPE, Measure::Speed),
    ] {
        let permit = permits(&settings, &plan, [0.0; 2]);
        assert!(
            matches!(permit, Err(Objection::Beyond { measure: found, .. }) if found == measure),
            "{permit:?}"
        );
        let is_due_to_limits = permits(&Settings::default(), &plan, [0.0; 2]).is_ok();
        assert!(is_due_to_limits);
    }
}

#[test]
fn an_arm_that_moves_faster_than_the_experiment_allows() {
    let slow = Experiment {
        speed_rad_s: [2.5, 0.2],
        ..ENVELOPE
    };
    let events = heard_at(
        [0.0, 0.0],
        &[
            (BEGIN_US, Action::Command(Command::Torque([0.0, 0.3]))),
            (
                BEGIN_US + 150_000,
                Action::Command(Command::Experiment(slow)),
            ),
        ],
        BEGIN_US + 200_000,
    );
    let refused = refusals(&events);
    assert!(
        matches!(
            refused[..],
            [Refusal::Experiment(Objection::Moving {
                joint: 1,
                limit_rad_s: 0.2,
                ..
            })]
        ),
        "{refused:?}"
    );
}

/// Not armed, and a set-up that is replaced meanwhile.
#[test]
fn what_the_supervisor_refuses() {
    let outcome = |acts: &[(u64, Action)]| -> (Vec<Refusal>, Vec<Event>) {
        let events = heard_at([0.0, 0.0], acts, BEGIN_US + 400_000);
        (refusals(&events), events)
    };
    let plan = experiment([Role::Hold; 2], 5.0);
    let (disarmed, _) = outcome(&[
        (BEGIN_US, Action::Command(Command::Idle)),
        (
            BEGIN_US + 100_000,
            Action::Command(Command::Experiment(plan)),
        ),
    ]);
    assert_eq!(disarmed, [Refusal::Disarmed]);
    let (replaced, events) = outcome(&[
        (BEGIN_US, Action::Command(Command::Experiment(plan))),
        (
            BEGIN_US + 100_000,
            Action::Command(Command::Configure(Setup::best())),
        ),
    ]);
    assert_eq!(replaced, [Refusal::NotIdle]);
    let last = records(&events).last().unwrap();
    assert_eq!(last.mode.drive(), Some(Drive::Experiment));
}
