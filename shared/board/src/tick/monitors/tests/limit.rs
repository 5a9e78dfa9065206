//! No torque leaves the fixture beyond its limits, whatever goes in.

use super::Fixture;
use crate::tick::monitors::LimitedTorque;
use armbridge_control::arm::{Parameters, State};
use armbridge_link::fault::Fault;
use armbridge_link::limits::Limits;
use armbridge_link::mode::Guards;
use nalgebra::Vector2;
use proptest::num::f32::{INFINITE, NORMAL, QUIET_NAN, SUBNORMAL, ZERO};
use proptest::prelude::*;

/// Of an arm, of anything, or of nothing that is a number.
fn number() -> impl Strategy<Value = f32> {
    prop_oneof![
        6 => -12.0_f32..12.0,
        2 => NORMAL | SUBNORMAL | ZERO,
        1 => INFINITE | QUIET_NAN,
    ]
}

fn pair() -> impl Strategy<Value = Vector2<f32>> {
    [number(), number()].prop_map(Vector2::from)
}

fn limits() -> impl Strategy<Value = Limits> {
    let each = |range: core::ops::Range<f32>| [range.clone(), range];
    (each(0.01..1.5), each(0.01..1.25), 0.1_f32..2_500.0).prop_map(
        |(angle_rad, torque_nm, torque_rate_nm_s)| Limits {
            angle_rad,
            torque_nm,
            torque_rate_nm_s,
            ..Limits::default()
        },
    )
}

proptest! {
    #[test]
    fn a_torque_is_within_its_limits_or_there_is_none(
        limits in limits(),
        period_us in 600_u32..100_000,
        (q, dq, wanted, before) in (pair(), pair(), pair(), pair()),
    ) {
        prop_assert!(limits.is_valid());
        let state = State { q, dq };
        let is_finite = [q, dq, wanted, before].iter().flatten().all(|x| x.is_finite());
        let mut fixture = Fixture::new(limits, period_us);
        match fixture.limit(&Parameters::paper(), &state, wanted, before) {
            Ok(LimitedTorque { torque_nm, guards }) => {
                prop_assert!(is_finite);
                let step = limits.torque_rate_nm_s * period_us as f32 * 1e-6;
                for joint in 0..2 {
                    let (torque, limit) = (torque_nm[joint], limits.torque_nm[joint]);
                    prop_assert!(torque.abs() <= limit, "{torque}");
                    // A brake does not wait, and what was beyond comes back.
                    let is_free = guards.contains(Guards::BRAKED) || before[joint].abs() > limit;
                    let change = (torque - before[joint]).abs();
                    prop_assert!(is_free || change <= step * 1.0001 + 1e-6, "{change}");
                }
                if guards == Guards::NONE {
                    prop_assert_eq!(torque_nm, wanted);
                }
            }
            Err(violation) => {
                prop_assert!(!is_finite);
                prop_assert_eq!(violation.fault, Fault::NotFinite);
                prop_assert!(!violation.value.is_finite());
            }
        }
    }
}

/// The tick in which a torque, wanted again and again, is a violation.
fn until(limits: Limits, period_us: u32, wanted: impl Fn(u32) -> f32) -> Option<(u32, Fault)> {
    let mut fixture = Fixture::new(limits, period_us);
    let upright = State::at_rest(Vector2::zeros());
    let mut before = Vector2::zeros();
    (1..3_000).find_map(|tick| {
        let wanted = Vector2::new(0.0, wanted(tick));
        match fixture.limit(&Parameters::paper(), &upright, wanted, before) {
            Ok(shaped) => before = shaped.torque_nm,
            Err(violation) => {
                assert!(violation.value > violation.limit, "{violation:?}");
                assert_eq!(violation.joint, Some(1));
                return Some((tick, violation.fault));
            }
        }
        None
    })
}

#[test]
fn to_limit_a_torque_for_long_is_a_violation() {
    let limits = Limits {
        torque_nm: [1.0; 2],
        torque_rate_nm_s: 100.0,
        ..Limits::default()
    };
    let beyond = [1_000, 100_000].map(|period| until(limits, period, |_| -1.001));
    assert_eq!(
        beyond,
        [500, 5].map(|tick| Some((tick, Fault::TorqueLimit)))
    );
    assert_eq!(until(limits, 1_000, |_| 0.999), None);
    let with_breaks = |tick| if tick % 500 == 0 { 0.9 } else { 1.1 };
    assert_eq!(until(limits, 1_000, with_breaks), None);

    // Back and forth by 0.22 N m a tick, where 0.1 is allowed.
    let rattle = |tick| if tick % 2 == 0 { 0.11 } else { -0.11 };
    assert_eq!(until(limits, 1_000, rattle), Some((100, Fault::TorqueRate)));
    let less = |tick| if tick % 2 == 0 { 0.049 } else { -0.049 };
    assert_eq!(until(limits, 1_000, less), None);
}

#[test]
fn a_pwm_beyond_its_limit_for_long_is_a_violation() {
    let mut fixture = Fixture::new(Limits::default(), 1_000);
    for tick in 1..2_000 {
        assert_eq!(fixture.pwm(tick % 500 > 0), Ok(()));
    }
    fixture.restart();
    let tripped = (1..1_000).find(|_| fixture.pwm(true).is_err());
    assert_eq!(tripped, Some(500));
}
