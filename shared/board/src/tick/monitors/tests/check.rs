//! Every monitor is fed, and only while it should be.

use super::Fixture;
use crate::tick::monitors::{Hold, MonitorInput};
use armbridge_control::arm::State;
use armbridge_link::fault::Fault;
use armbridge_link::limits::Limits;
use armbridge_link::message::Missing;
use armbridge_link::record::Violation;
use nalgebra::Vector2;

/// A standing arm, seen.
fn seen(state: &State<f32>) -> MonitorInput<'_> {
    MonitorInput {
        counts: [Some(512); 2],
        missing: [None; 2],
        measured_rad: [Some(0.0); 2],
        predicted_rad: [0.0; 2],
        is_fresh: false,
        state,
        torque_nm: [0.05; 2],
        gravity_nm: [0.0; 2],
        is_alarmed: [false; 2],
        lowered: [false; 2],
        hold: Hold::None,
        reference_rad_s: [0.0; 2],
        is_armed: true,
    }
}

/// The tick in which the same thing, seen again and again, is a violation.
fn until(fixture: &mut Fixture, seen: &MonitorInput<'_>) -> Option<(u32, Violation)> {
    (1..2_000).find_map(|tick| Some((tick, fixture.check(seen).err()?)))
}

/// The second joint somewhere, with a speed.
fn at(q: f32, dq: f32) -> State<f32> {
    State {
        q: Vector2::new(0.0, q),
        dq: Vector2::new(0.0, dq),
    }
}

#[test]
fn each_doubt_has_its_own_fault() {
    let (still, out, fast, endless) = (at(0., 0.), at(-1.51, 0.), at(0., -10.1), at(0., f32::NAN));
    let base = seen(&still);
    #[rustfmt::skip]
    let table = [
        (MonitorInput { counts: [Some(512), Some(7)], ..base }, Fault::DeadZone, 2),
        (MonitorInput { predicted_rad: [0.0, 0.11], ..base }, Fault::Diverged, 3),
        (MonitorInput { is_alarmed: [false, true], ..base }, Fault::ServoAlarm, 2),
        (seen(&out), Fault::AngleLimit, 1),
        (seen(&fast), Fault::SpeedLimit, 10),
        (seen(&endless), Fault::NotFinite, 1),
        (MonitorInput { torque_nm: [0.0, f32::NAN], ..base }, Fault::NotFinite, 1),
        (MonitorInput { torque_nm: [0.0, 0.7], gravity_nm: [0.0, 0.2], ..base }, Fault::Stuck, 150),
    ];
    for (seen, fault, tick) in table {
        let mut fixture = Fixture::new(Limits::default(), 1_000);
        let (taken, violation) = until(&mut fixture, &seen).unwrap();
        assert_eq!((violation.fault, taken), (fault, tick));
        assert_eq!(violation.joint, Some(1));
        // With torque off none of it matters.
        let off = MonitorInput {
            is_armed: false,
            ..seen
        };
        assert_eq!(until(&mut fixture, &off), None);
    }
    let silent = MonitorInput {
        counts: [Some(512), None],
        missing: [None, Some(Missing::Silence)],
        measured_rad: [Some(0.0), None],
        is_armed: false,
        ..base
    };
    let mut fixture = Fixture::new(Limits::default(), 1_000);
    let (taken, violation) = until(&mut fixture, &silent).unwrap();
    assert_eq!((violation.fault, taken), (Fault::ServoSilent, 20));
}

#[test]
fn what_is_below_a_limit_is_no_violation() {
    let (still, near) = (at(0.0, 0.0), at(1.49, 9.9));
    let base = seen(&still);
    #[rustfmt::skip]
    let table = [
        MonitorInput { counts: [Some(218), Some(806)], ..base },
        MonitorInput { predicted_rad: [-0.099, 0.099], ..base },
        MonitorInput { predicted_rad: [0.0, 5.0], is_fresh: true, ..base },
        seen(&near),
        MonitorInput { torque_nm: [0.0, 0.95], gravity_nm: [0.0, 0.56], ..base },
    ];
    for seen in table {
        let mut fixture = Fixture::new(Limits::default(), 1_000);
        assert_eq!(until(&mut fixture, &seen), None, "{seen:?}");
    }
}

#[test]
fn a_restart_forgets() {
    let mut fixture = Fixture::new(Limits::default(), 1_000);
    assert_eq!(*fixture.limits(), Limits::default());
    let still = at(0.0, 0.0);
    let silent = MonitorInput {
        counts: [None; 2],
        missing: [Some(Missing::EchoOnly); 2],
        measured_rad: [None; 2],
        ..seen(&still)
    };
    for _ in 0..100 {
        for _ in 0..19 {
            assert_eq!(fixture.check(&silent), Ok(()));
        }
        fixture.restart();
    }
}

/// Of a joint without samples, however long, nothing is known.
#[test]
fn an_encoder_is_unknown_until_it_has_given_samples() {
    let state = at(0.0, 0.0);
    let missing = MonitorInput {
        counts: [Some(512), None],
        measured_rad: [Some(0.0), None],
        is_armed: false,
        ..seen(&state)
    };
    let whole = MonitorInput {
        is_armed: false,
        ..seen(&state)
    };
    let mut fixture = Fixture::new(Limits::default(), 1_000);
    let mut unknown_after = |seen: &MonitorInput<'_>, ticks| {
        for _ in 0..ticks {
            assert_eq!(fixture.check(seen), Ok(()));
        }
        fixture.monitors.unknown_encoder(armbridge_servo::JOINTS)
    };
    assert_eq!(unknown_after(&missing, 47), Some(0));
    assert_eq!(unknown_after(&missing, 1_000), Some(1));
    assert_eq!(unknown_after(&whole, 47), Some(1));
    assert_eq!(unknown_after(&whole, 1), None);
}
