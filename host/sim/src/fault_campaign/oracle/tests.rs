//! Violations that the oracle must see, each on a board that commits it.

use super::super::driver::HostFault;
use super::super::run::run_case;
use super::super::set_up::{Bus, SetUp};
use super::*;
use crate::plant::MotorFault;
use armbridge_board::bridge::Channels;
use armbridge_link::message::{OffReport, OffState, StopSource};
use armbridge_servo::Firmware;

/// The first single of this kind, with this work, on Morpheus servos at 1 kHz.
fn case_of(kind: Kind, activity: Activity) -> Case {
    let index = Kind::ALL.iter().position(|other| *other == kind).unwrap();
    let case = Case::new(2 * index as u64);
    let bus = Bus::new(Firmware::Morpheus, 1_000_000);
    let injections = case.injections.iter().map(|injection| Injection {
        origin: Origin::Ready,
        after_us: 300_000,
        ..*injection
    });
    Case {
        bus,
        set_up: bus.set_ups(activity)[0],
        activity,
        friction: !activity.is_balanced(),
        is_tight: false,
        noise_counts: 1.0,
        is_obstructed: false,
        initial_rad: [0.1, -0.1],
        injections: injections.collect(),
        ..case
    }
}

/// Checks a case on a board that was set up for another case, after a change that is not
/// part of the case.
fn checked(case: &Case, set_up: &Case, done: impl FnOnce(&mut Fixture<'_>)) -> Outcome {
    let (mut channels, mut spare) = (Channels::new(), Channels::new());
    let fixture = Fixture::new(set_up, [channels.split(), spare.split()]).unwrap();
    let mut trace = Trace::off();
    let mut runner = CaseRunner::new(case, fixture, &mut trace);
    assert!(runner.bring_up());
    runner.run_until(runner.fixture.now_us() + 100_000, |_| false);
    done(&mut runner.fixture);
    runner.observe_injections();
    runner.check_fault();
    runner.check_motors();
    runner.outcome
}

/// Whether a violated requirement has these words.
fn has(outcome: &Outcome, words: &str) -> bool {
    outcome.failures.iter().any(|why| why.contains(words))
}

#[test]
fn a_motor_that_stays_on_is_seen() {
    let stop = case_of(Kind::StopHost, Activity::Regulate);
    assert_eq!(checked(&stop, &stop, |_| ()).failures, [""; 0]);
    let deafened = checked(&stop, &stop, |fixture| fixture.cosim.bench.deafen(0, true));
    assert!(deafened.stop_ms > 1_000.0, "{deafened:?}");
    assert!(has(&deafened, "was on for"), "{deafened:?}");
}

#[test]
fn a_motor_of_a_silent_client_that_stays_on_is_seen() {
    let hang = case_of(Kind::ClientHang, Activity::Port);
    let ended = checked(&hang, &hang, |_| ());
    assert_eq!(ended.failures, [""; 0]);
    let deafened = checked(&hang, &hang, |fixture| fixture.cosim.bench.deafen(1, true));
    assert!(has(&deafened, "was on for"), "{deafened:?}");
}

#[test]
fn a_torque_that_outlives_its_command_is_seen() {
    let case = |is_tight| Case {
        is_tight,
        is_obstructed: true,
        ..case_of(Kind::HostHeartbeats, Activity::Torque)
    };
    let ended = checked(&case(false), &case(false), |_| ());
    assert_eq!((ended.failures.as_slice(), ended.fault), (&[][..], None));
    let outlived = checked(&case(true), &case(false), |_| ());
    assert!(has(&outlived, "outlived"), "{outlived:?}");
}

#[test]
fn a_board_with_other_limits_is_seen() {
    let case = |is_tight| Case {
        to_rad: [1.2; JOINTS],
        is_tight,
        ..case_of(Kind::Goodbye, Activity::Regulate)
    };
    let outcome = checked(&case(true), &case(false), |fixture| {
        fixture.cosim.board.max_deviation = 10;
    });
    for words in ["counts from off", "was sent at", "N m, 0.8 allowed"] {
        assert!(has(&outcome, words), "{outcome:?}");
    }
}

#[test]
fn an_arm_that_is_driven_against_the_table_is_seen() {
    let stop = case_of(Kind::StopHost, Activity::Regulate);
    let outcome = checked(&stop, &stop, |fixture| {
        // The board knows nothing of what drives the arm.
        let fault = MotorFault {
            gain: 1.0,
            offset_counts: 900.0,
        };
        fixture.cosim.bench.fail_motor(0, fault);
        fixture.cosim.bench.deafen(0, true);
    });
    assert!(has(&outcome, "driven against its stop"), "{outcome:?}");
    assert!(outcome.contact_rad_s > 1.0, "{outcome:?}");
}

#[test]
fn an_arm_that_is_thrown_is_seen_and_one_that_falls_is_not() {
    let stop = case_of(Kind::StopHost, Activity::Regulate);
    let fallen = checked(&stop, &stop, |_| ());
    assert!(
        fallen.contact_rad_s > 1.0 && fallen.failures.is_empty(),
        "{fallen:?}"
    );
    let thrown = checked(&stop, &stop, |fixture| {
        let start_ns = fixture.now_us() * 1_000 + 220_000_000;
        fixture.cosim.bench.push(crate::plant::Push {
            joint: 0,
            torque_nm: 3.0,
            start_ns,
            duration_ns: 1_000_000_000,
        });
    });
    assert!(has(&thrown, "was thrown"), "{thrown:?}");
}

/// A deaf servo keeps its motor on; the board cannot know it, and must not say otherwise.
#[test]
fn a_motor_that_is_on_and_reported_as_off_is_seen() {
    let stop = case_of(Kind::StopHost, Activity::Regulate);
    let reported = |state| {
        let (mut channels, mut spare) = (Channels::new(), Channels::new());
        let fixture = Fixture::new(&stop, [channels.split(), spare.split()]).unwrap();
        let mut trace = Trace::off();
        let mut runner = CaseRunner::new(&stop, fixture, &mut trace);
        assert!(runner.bring_up());
        runner.run_until(runner.fixture.now_us() + 100_000, |_| false);
        runner.fixture.cosim.bench.deafen(0, true);
        runner.observe_injections();
        runner.fixture.cosim.board.off_report = Some(OffReport {
            stops: 1,
            joints: [state; JOINTS],
        });
        runner.run_until(runner.fixture.now_us() + 100_000, |_| false);
        has(&runner.outcome, "motor 0 was on and reported as off")
    };
    assert!(reported(OffState::Off) && !reported(OffState::OutOfReach));
}

#[test]
fn an_arm_far_from_its_reference_is_seen() {
    let goodbye = case_of(Kind::HostGarbage, Activity::Regulate);
    assert_eq!(checked(&goodbye, &goodbye, |_| ()).failures, [""; 0]);
    let outcome = checked(&goodbye, &goodbye, |fixture| {
        let fault = crate::faults::sensor::SensorFault::Offset {
            counts: 0.0,
            counts_per_s: 100.0,
        };
        fixture.cosim.bench.fail_sensor(1, fault);
    });
    assert!(has(&outcome, "from its reference"), "{outcome:?}");
    assert!(outcome.far_ms > 50.0, "{outcome:?}");
}

#[test]
fn a_session_that_goes_on_after_its_end_is_seen() {
    let hello = case_of(Kind::HostHello, Activity::Regulate);
    let garbage = case_of(Kind::HostGarbage, Activity::Regulate);
    assert_eq!(checked(&hello, &hello, |_| ()).failures, [""; 0]);
    let (mut channels, mut spare) = (Channels::new(), Channels::new());
    let fixture = Fixture::new(&garbage, [channels.split(), spare.split()]).unwrap();
    let mut trace = Trace::off();
    let mut runner = CaseRunner::new(&garbage, fixture, &mut trace);
    assert!(runner.bring_up());
    runner.ended_us = Some(runner.fixture.now_us());
    runner.observe_injections();
    assert!(has(&runner.outcome, "still armed"), "{:?}", runner.outcome);
}

#[test]
fn a_wrong_name_and_a_missing_one_are_seen() {
    let goodbye = case_of(Kind::Goodbye, Activity::Regulate);
    assert!(checked(&goodbye, &goodbye, |_| ()).is_fault_expected);
    let stopped = checked(&goodbye, &goodbye, |fixture| {
        fixture.cosim.is_stop_pressed = true;
    });
    let pin = Fault::EmergencyStop(StopSource::Pin).name();
    assert_eq!(
        (stopped.fault.as_deref(), stopped.is_fault_expected),
        (Some(pin), false)
    );
    // A host that is gone cannot stop anything.
    let stop = case_of(Kind::StopHost, Activity::Idle);
    let ignored = checked(&stop, &stop, |fixture| {
        fixture.driver().inject(HostFault::Silent);
    });
    assert_eq!((ignored.fault, ignored.is_fault_expected), (None, false));
}

/// An arm that floats stays where it is, and is led by a hand, without a failure; a push that moves
/// it, and a motor that drives it against its stop, are failures.
#[test]
fn an_arm_that_floats_away_or_is_driven_is_seen() {
    let mut stop = case_of(Kind::StopHost, Activity::Float);
    stop.injections[0].after_us = 3_000_000;
    assert_eq!(checked(&stop, &stop, |_| ()).failures, [""; 0]);
    let pushed = checked(&stop, &stop, |fixture| {
        fixture.cosim.bench.push(crate::plant::Push {
            joint: 1,
            torque_nm: 0.3,
            start_ns: (fixture.now_us() + 2_000_000) * 1_000,
            duration_ns: 300_000_000,
        });
    });
    assert!(has(&pushed, "joint 1 floated away"), "{pushed:?}");
    let driven = checked(&stop, &stop, |fixture| {
        let fault = MotorFault {
            gain: 1.0,
            offset_counts: 900.0,
        };
        fixture.cosim.bench.fail_motor(0, fault);
        fixture.cosim.bench.deafen(0, true);
    });
    assert!(has(&driven, "driven against its stop"), "{driven:?}");
    let led = Case {
        is_led: true,
        injections: Vec::new(),
        ..stop
    };
    assert_eq!(checked(&led, &led, |_| ()).failures, [""; 0]);
}

/// Every set-up holds the arm through all that the host may have it do, without a fault and
/// without a violation.
#[test]
fn every_set_up_holds_the_arm_without_a_fault() {
    let mut buses: Vec<Bus> = Bus::all().collect();
    buses.dedup();
    let set_ups = |bus: Bus| {
        let all = bus.set_ups(Activity::Idle).into_iter();
        all.map(move |it: SetUp| (bus, it))
    };
    for (bus, set_up) in buses.into_iter().flat_map(set_ups) {
        for (nth, activity) in Activity::all().enumerate() {
            // On a slow bus only some: its packets are the same.
            let is_left_out = bus.baud < 1_000_000 && nth % 4 != 0;
            if is_left_out || !activity.permits(set_up.period_us) {
                continue;
            }
            let case = Case {
                bus,
                set_up,
                friction: true,
                to_rad: [0.25, -0.2],
                initial_rad: if activity.is_balanced() {
                    [-0.2, 0.2]
                } else {
                    [0.02; JOINTS]
                },
                injections: Vec::new(),
                seed: nth as u64,
                ..case_of(Kind::Goodbye, activity)
            };
            let outcome = run_case(&case, &mut Trace::off(), None);
            let Outcome {
                fault, failures, ..
            } = &outcome;
            assert!(
                fault.is_none() && failures.is_empty(),
                "{case:?}: {outcome:?}"
            );
        }
    }
}
