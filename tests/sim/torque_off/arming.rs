//! Conditions on the samples before the board arms.

use armbridge_control::arm::State;
use armbridge_link::message::{Command, Limits, Mode, Refusal};
use armbridge_servo::Firmware;
use armbridge_sim::plant::PlantConfig;
use armbridge_tests::torque_off::rig::{Rig, World, bench, with_rig};
use nalgebra::Vector2;

/// 48 samples at rest show the noise of the encoders, without which one that stops goes
/// unnoticed; now and then 16 of them do not count.
#[test]
fn a_board_arms_as_soon_as_it_knows_the_encoders() {
    let bench = bench(&PlantConfig::default(), Firmware::Morpheus);
    with_rig(World::Bench, bench, |rig| {
        let (session, from_us) = (rig.host().session(), rig.now_us());
        let arm = Command::Arm { session };
        assert_eq!(
            rig.command_once(arm),
            Err(Refusal::EncoderUnknown { joint: 0 })
        );
        let is_checked = (rig.command(arm), rig.mode());
        assert_eq!(is_checked, (Ok(()), Some(Mode::MotorCheck)));
        let waited_us = rig.now_us() - from_us;
        assert!((46_000..85_000).contains(&waited_us), "{waited_us} µs");
        // Known for the rest of the session.
        assert_eq!(rig.command_once(Command::Idle), Ok(()));
        assert_eq!(rig.command_once(arm), Ok(()));
    });
}

#[test]
fn an_arm_beyond_its_limit_is_not_armed() {
    for joint in [0, 1] {
        let mut initial = Vector2::zeros();
        initial[usize::from(joint)] = -1.53;
        let lying = PlantConfig {
            initial: State::at_rest(initial),
            ..PlantConfig::default()
        };
        with_rig(World::Bench, bench(&lying, Firmware::Morpheus), |rig| {
            let session = rig.host().session();
            let answer = rig.command(Command::Arm { session });
            assert_eq!(answer, Err(Refusal::BeyondLimit { joint }));
            assert_eq!(rig.mode(), Some(Mode::Idle));
        });
    }
}

/// Arms under these limits, and disarms; the first mode after the command.
fn arm_under(rig: &mut Rig<'_>, limits: Limits) -> Mode {
    assert_eq!(rig.command(Command::Limit(limits)), Ok(()));
    let session = rig.host().session();
    assert_eq!(rig.command(Command::Arm { session }), Ok(()));
    let is_armed = |rig: &Rig<'_>| rig.mode().is_some_and(Mode::is_armed);
    rig.until("armed", 100_000, is_armed);
    let first = rig.mode().unwrap();
    rig.until("checked", 2_000_000, |rig| rig.mode() == Some(Mode::Armed));
    assert_eq!(rig.command(Command::Idle), Ok(()));
    first
}

#[test]
fn a_motor_check_that_moved_nothing_is_repeated_under_higher_limits() {
    let limits = Limits::default();
    let weak = Limits {
        torque_nm: [0.05; 2],
        ..limits
    };
    let slow = Limits {
        pwm_counts: 60,
        ..limits
    };
    for low in [weak, slow] {
        let bench = bench(&PlantConfig::default(), Firmware::Morpheus);
        with_rig(World::Bench, bench, |rig| {
            for (limits, first) in [
                (low, Mode::MotorCheck),
                (limits, Mode::MotorCheck),
                (limits, Mode::Armed),
                // Known by now.
                (low, Mode::Armed),
            ] {
                assert_eq!(arm_under(rig, limits), first, "{limits:?}");
            }
        });
    }
}
