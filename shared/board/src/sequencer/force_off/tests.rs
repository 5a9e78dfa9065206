//! Evidence, checks and stops, tick by tick.

use super::*;
use armbridge_servo::Missing;

const HEARD: Sample = Sample::Counts(512);
const SILENT: Sample = Sample::Missing(Missing::Silence);
/// Payload of a Morpheus read-back of PWM 1000 and of 1500, from 0x0F on.
const OFF: [u8; 2] = [1, 0xE8];
const ON: [u8; 2] = [1, 0xDC];

/// Runs a tick, and answers the check after it, if there is one.
fn tick(off: &mut ForceOff, now_us: u64, samples: [Sample; JOINTS], read_back: &[u8]) {
    off.note_tick(now_us, samples);
    if let Some(check) = off.next_check(now_us) {
        off.note_sent(check, now_us, 0);
        let data: &[u8] = match check.kind {
            CheckKind::Ping => &[1],
            CheckKind::ReadBack => read_back,
        };
        off.note_reply(check, Firmware::Morpheus, Some(data), now_us);
    }
    assert_eq!(off.next_check(now_us), None, "one a tick");
}

/// Runs a tick, after which no servo answers a check in the time that is left.
fn deaf_tick(off: &mut ForceOff, now_us: u64, samples: [Sample; JOINTS], left_us: u64) {
    off.note_tick(now_us, samples);
    assert!(
        !off.is_stop_due(now_us + 1_000_000),
        "the check comes first"
    );
    let check = off.next_check(now_us).unwrap();
    off.note_sent(check, now_us, left_us);
    off.note_reply(check, Firmware::Morpheus, None, now_us);
}

#[test]
fn a_motor_is_off_when_it_is_seen_to_be() {
    let mut off = ForceOff::new(JOINTS);
    off.begin(0, true);
    assert!(off.is_stop_due(0));
    off.note_stop(0);
    for ms in 1..=4 {
        assert!(!off.is_off(), "{ms}");
        assert_eq!(off.take_report(ms * 1_000), None);
        tick(&mut off, ms * 1_000, [HEARD; JOINTS], &OFF);
    }
    assert!(off.is_off() && !off.is_stop_due(1_000_000));
    let report = OffReport {
        stops: 1,
        joints: [OffState::Off; JOINTS],
    };
    assert_eq!(off.last_report(), None);
    assert_eq!(off.take_report(5_000), Some(report));
    assert_eq!(off.take_report(6_000), None);
    assert_eq!(off.last_report(), Some(report));
    off.begin(7_000, true);
    assert_eq!(off.last_report(), None, "of the stop before");
}

#[test]
fn a_motor_that_reads_back_as_on_is_stopped_again_at_once() {
    let mut off = ForceOff::new(JOINTS);
    off.begin(0, true);
    off.note_stop(0);
    for ms in 1..=2 {
        tick(&mut off, ms * 1_000, [HEARD; JOINTS], &ON);
    }
    assert!(off.is_stop_due(2_000));
    assert_eq!(off.take_report(299_999), None);
    let report = off.take_report(300_000).unwrap();
    assert_eq!(report.joints, [OffState::Unconfirmed; JOINTS]);
}

#[test]
fn evidence_of_a_servo_that_was_silent_is_worth_nothing() {
    let mut off = ForceOff::new(JOINTS);
    off.begin(0, true);
    for ms in 1..=4 {
        tick(&mut off, ms * 1_000, [HEARD; JOINTS], &OFF);
    }
    assert!(off.is_off());
    for ms in 5..=6 {
        off.note_tick(ms * 1_000, [HEARD, SILENT]);
    }
    deaf_tick(&mut off, 7_000, [HEARD, SILENT], 0);
    assert!(!off.is_off() && off.is_stop_due(300_000));
    let report = off.take_report(300_000).unwrap();
    assert_eq!(report.joints, [OffState::Off, OffState::OutOfReach]);
    for ms in 301..=302 {
        tick(&mut off, ms * 1_000, [HEARD; JOINTS], &OFF);
    }
    assert!(off.is_off());
    let report = off.take_report(303_000).unwrap();
    assert_eq!(report.joints, [OffState::Off; JOINTS]);
}

#[test]
fn without_a_fault_the_ticks_are_given_time_first() {
    let mut off = ForceOff::new(JOINTS);
    off.begin(0, false);
    for ms in 1..=5 {
        assert!(!off.is_stop_due(1_000_000), "too few ticks for the checks");
        deaf_tick(&mut off, ms * 1_000, [HEARD; JOINTS], 0);
    }
    assert!(!off.is_stop_due(99_999) && off.is_stop_due(100_000));
    off.note_stop(100_000);
    deaf_tick(&mut off, 101_000, [HEARD; JOINTS], 0);
    assert!(!off.is_stop_due(149_999) && off.is_stop_due(150_000));
    // Motors that are off without a fault need no report.
    for ms in 160..=163 {
        tick(&mut off, ms * 1_000, [HEARD; JOINTS], &OFF);
    }
    assert_eq!(off.take_report(1_000_000), None);
}

#[test]
fn a_stop_follows_each_tick_that_a_servo_misses_if_ticks_are_rare() {
    let mut off = ForceOff::new(JOINTS);
    off.begin(0, true);
    off.note_stop(7_000);
    // Heard, or at a kilohertz, it comes later.
    deaf_tick(&mut off, 8_000, [HEARD; JOINTS], 4_000);
    assert!(!off.is_stop_due(56_999) && off.is_stop_due(57_000));
    deaf_tick(&mut off, 9_000, [SILENT, HEARD], 400);
    assert!(!off.is_stop_due(56_999));
    deaf_tick(&mut off, 10_000, [SILENT, HEARD], 4_000);
    assert!(off.is_stop_due(10_000));
    // One that stays away gets no more than others.
    off.note_stop(SLOW_AFTER_US);
    deaf_tick(&mut off, SLOW_AFTER_US + 1_000, [SILENT; JOINTS], 4_000);
    assert!(!off.is_stop_due(SLOW_AFTER_US + SLOW_FACTOR * REPEAT_US - 1));
}

/// At 45 ms the checks take 180 ms; a stop would release stock servos, which then take no
/// torque.
#[test]
fn ticks_with_long_periods_are_checked_first() {
    let mut off = ForceOff::new(JOINTS);
    off.begin(0, false);
    for tick_us in [45_000, 90_000, 135_000, 180_000] {
        tick(&mut off, tick_us, [HEARD; JOINTS], &OFF);
        assert!(!off.is_stop_due(tick_us + 44_999));
    }
    assert!(off.is_off());
}
