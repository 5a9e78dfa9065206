//! Forced off: repeated commands until each servo's registers read back as off.
//!
//! A joint at rest is no evidence: a servo that pushes against an obstacle is at rest
//! too. The evidence is collected joint by joint in this order:
//!
//! ```text
//!   commanded off, in a tick or by a stop          -> Commanded
//!   answers a ping                                 -> Answering
//!   its registers read back as off                 -> Off
//! ```
//!
//! A stock servo's registers are proof: torque enable and moving speed. Of a Morpheus
//! servo's PWM only the low byte can be read, so that its read-back counts together
//! with the two before it, and every tick continues to command it off.
//!
//! Evidence is discarded once a servo has been silent for [`SILENT_TICKS`], and again
//! when it answers: the wire or the servo may have come back. Until all is collected the
//! stop sequence is repeated, [`REPEAT_US`] after its end, and after [`SLOW_AFTER_US`] less
//! often. The first step after a tick is always a check, so that sequences on a slow bus do
//! not keep checks away.
//!
//! A silent servo may be inside a packet that was cut off, and wait for up to 254 bytes.
//! Ticks that are [`RARE_US`] apart, or more, carry these too slowly: a stop sequence follows
//! each of them.
//! A servo that has left the ticks' chain, as a Morpheus servo has after a reset, still
//! answers requests to its own id.
//!
//! This module has no access to the bus: the sequencer takes the next action and
//! reports its outcome.

use crate::JOINTS;
use crate::link::message::{OffReport, OffState, Sample};
use crate::servo::Firmware;

/// Time in µs from the end of a stop sequence to the next while a servo is not confirmed
/// off. Between them the ticks command it off, and read back.
const REPEAT_US: u64 = 50_000;
/// Time in µs that is left after a tick above which ticks are too rare for a servo that
/// waits for the rest of a packet: of about 30 bytes each, they would take 20 ms.
const RARE_US: u64 = 2_000;
/// Time in µs after which a stop sequence follows for motors that ticks alone, without a
/// fault, have commanded off and that are not confirmed off.
const STOP_DELAY_US: u64 = 100_000;
/// Ticks without a fault that pass before as well, however long they are: two checks a joint.
const STOP_DELAY_TICKS: u32 = 2 * JOINTS as u32 + 1;
/// Time in µs after which the sequence is sent [`SLOW_FACTOR`] times less often: an arm
/// that does not answer may stay so.
const SLOW_AFTER_US: u64 = 3_000_000;
/// See [`SLOW_AFTER_US`].
const SLOW_FACTOR: u64 = 5;
/// Ticks without a reply after which a servo is out of reach.
const SILENT_TICKS: u32 = 3;
/// Time in µs after which the host gets a report even if evidence is missing.
const REPORT_US: u64 = 300_000;

/// Evidence that one joint's motor is off.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum Evidence {
    /// The servo has been commanded off.
    #[default]
    Commanded,
    /// The servo has answered a ping since.
    Answering,
    /// Its registers read back as off, too.
    Off,
}

/// A query to one servo that adds to the evidence.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct OffCheck {
    pub(super) joint: usize,
    pub(super) kind: CheckKind,
}

/// Kind of an [`OffCheck`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum CheckKind {
    /// A ping.
    Ping,
    /// The registers that show whether the motor is off.
    ReadBack,
}

/// See the [module](self).
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct ForceOff {
    since_us: u64,
    next_stop_us: u64,
    /// Stop sequences sent since the beginning.
    stops: u16,
    joints: [Evidence; JOINTS],
    silent_ticks: [u32; JOINTS],
    /// Ticks since the beginning.
    ticks: u32,
    /// Motors have been commanded off since the beginning; before that no check is due.
    is_commanded: bool,
    /// A check has been made since the last tick.
    is_checked: bool,
    /// The joint that is checked next, if a check is due.
    next_joint: usize,
    /// A report to the host is due, and the last report.
    is_reported: bool,
    reported: Option<[OffState; JOINTS]>,
}

impl ForceOff {
    /// Begins to force motors off. After a fault, `is_fault`, the stop
    /// sequence is sent at once and the host gets reports.
    pub(super) fn begin(&mut self, now_us: u64, is_fault: bool) {
        *self = Self {
            since_us: now_us,
            next_stop_us: if is_fault {
                now_us
            } else {
                now_us + STOP_DELAY_US
            },
            silent_ticks: self.silent_ticks,
            is_reported: is_fault,
            ..Self::default()
        };
    }

    /// Whether a stop sequence is due.
    pub(super) fn is_stop_due(&self, now_us: u64) -> bool {
        let has_had_checks = self.is_reported || self.ticks >= STOP_DELAY_TICKS;
        let is_late = now_us >= self.next_stop_us && has_had_checks;
        is_late && !self.is_off() && self.next_check().is_none()
    }

    /// Notes that a stop sequence has ended now.
    pub(super) fn note_stop(&mut self, now_us: u64) {
        self.is_commanded = true;
        self.stops = self.stops.saturating_add(1);
        let factor = if self.is_old(now_us) { SLOW_FACTOR } else { 1 };
        self.next_stop_us = now_us + factor * REPEAT_US;
    }

    fn is_old(&self, now_us: u64) -> bool {
        now_us.saturating_sub(self.since_us) >= SLOW_AFTER_US
    }

    /// Takes the samples of a tick that commanded every motor off.
    pub(super) fn note_tick(&mut self, now_us: u64, samples: [Sample; JOINTS]) {
        (self.is_commanded, self.is_checked) = (true, false);
        self.ticks = self.ticks.saturating_add(1);
        let joints = self.joints.iter_mut().zip(&mut self.silent_ticks);
        for ((evidence, silent_ticks), sample) in joints.zip(samples) {
            let was_silent = *silent_ticks >= SILENT_TICKS;
            *silent_ticks = match sample {
                Sample::Counts(_) => 0,
                Sample::Missing(_) => silent_ticks.saturating_add(1),
            };
            if was_silent != (*silent_ticks >= SILENT_TICKS) {
                *evidence = Evidence::Commanded;
                // The ticks command it off as soon as it answers again.
                self.next_stop_us = self.next_stop_us.max(now_us + STOP_DELAY_US);
            }
        }
    }

    /// The next check, at most one a tick.
    pub(super) fn next_check(&self) -> Option<OffCheck> {
        if self.is_checked || !self.is_commanded {
            return None;
        }
        (0..JOINTS).find_map(|step| {
            let joint = (self.next_joint + step) % JOINTS;
            let kind = match self.joints.get(joint)? {
                Evidence::Commanded => CheckKind::Ping,
                Evidence::Answering => CheckKind::ReadBack,
                Evidence::Off => return None,
            };
            Some(OffCheck { joint, kind })
        })
    }

    /// Notes that the check has been sent, this time before the next tick.
    pub(super) fn note_sent(&mut self, check: OffCheck, now_us: u64, left_us: u64) {
        self.is_checked = true;
        let is_silent = self.silent_ticks.iter().any(|silent| *silent > 0);
        if is_silent && left_us > RARE_US && !self.is_old(now_us) {
            self.next_stop_us = now_us;
        }
        if check.kind == CheckKind::ReadBack {
            self.next_joint = check.joint + 1;
        }
    }

    /// Takes the answer to a check; `None` if there is none.
    pub(super) fn note_reply(
        &mut self,
        check: OffCheck,
        firmware: Firmware,
        data: Option<&[u8]>,
        now_us: u64,
    ) {
        let Some(evidence) = self.joints.get_mut(check.joint) else {
            return;
        };
        *evidence = match (check.kind, data) {
            (_, None) => {
                self.next_joint = check.joint + 1;
                Evidence::Commanded
            }
            (CheckKind::Ping, Some(data)) if firmware.is_pong(data) => Evidence::Answering,
            (CheckKind::Ping, Some(_)) => Evidence::Commanded,
            (CheckKind::ReadBack, Some(data)) => match firmware.decode_off(data) {
                Some(true) => Evidence::Off,
                Some(false) => {
                    self.next_stop_us = now_us;
                    Evidence::Commanded
                }
                None => Evidence::Commanded,
            },
        };
    }

    /// Whether every servo is confirmed off, and has answered since.
    pub(super) fn is_off(&self) -> bool {
        self.joints == [Evidence::Off; JOINTS]
    }

    /// Whether the stop has concluded: each motor is confirmed off, or the host has a
    /// report that one is not.
    pub(super) fn is_settled(&self) -> bool {
        self.is_off() || self.reported.is_some()
    }

    /// Restarts after the servos have been found again, with motors commanded off. A report that
    /// is due after a fault stays due.
    pub(super) fn resume(&mut self, now_us: u64) {
        *self = Self {
            since_us: now_us,
            next_stop_us: now_us + STOP_DELAY_US,
            stops: self.stops,
            is_reported: self.is_reported,
            reported: self.reported,
            ..Self::default()
        };
    }

    /// Discards all evidence: the servos may have changed meanwhile.
    pub(super) fn discard_evidence(&mut self) {
        self.joints = Default::default();
    }

    /// Whether reports go to the host: after a fault.
    pub(super) fn is_reported(&self) -> bool {
        self.is_reported
    }

    /// The report to the host, when it changes.
    pub(super) fn take_report(&mut self, now_us: u64) -> Option<OffReport> {
        let is_old = now_us.saturating_sub(self.since_us) >= REPORT_US;
        let is_off = self.is_off();
        // Motors that are off without a fault need no report.
        let is_due = if self.is_reported {
            is_off || is_old
        } else {
            is_old && !is_off
        };
        if !is_due {
            return None;
        }
        let mut joints = [OffState::Off; JOINTS];
        let known = self.joints.iter().zip(self.silent_ticks);
        for (state, (evidence, silent_ticks)) in joints.iter_mut().zip(known) {
            *state = match evidence {
                Evidence::Off => OffState::Off,
                _ if silent_ticks >= SILENT_TICKS => OffState::OutOfReach,
                _ => OffState::Unconfirmed,
            };
        }
        if self.reported == Some(joints) {
            return None;
        }
        self.reported = Some(joints);
        self.is_reported = true;
        Some(OffReport {
            stops: self.stops,
            joints,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::servo::Missing;

    const HEARD: Sample = Sample::Counts(512);
    const SILENT: Sample = Sample::Missing(Missing::Silence);
    /// Payload of a Morpheus read-back of PWM 1000 and of 1500, from 0x0F on.
    const OFF: [u8; 2] = [1, 0xE8];
    const ON: [u8; 2] = [1, 0xDC];

    /// Runs a tick, and answers the check after it, if there is one.
    fn tick(off: &mut ForceOff, now_us: u64, samples: [Sample; JOINTS], read_back: &[u8]) {
        off.note_tick(now_us, samples);
        if let Some(check) = off.next_check() {
            off.note_sent(check, now_us, 0);
            let data: &[u8] = match check.kind {
                CheckKind::Ping => &[1],
                CheckKind::ReadBack => read_back,
            };
            off.note_reply(check, Firmware::Morpheus, Some(data), now_us);
        }
        assert_eq!(off.next_check(), None, "one a tick");
    }

    /// Runs a tick, after which no servo answers a check in the time that is left.
    fn deaf_tick(off: &mut ForceOff, now_us: u64, samples: [Sample; JOINTS], left_us: u64) {
        off.note_tick(now_us, samples);
        assert!(
            !off.is_stop_due(now_us + 1_000_000),
            "the check comes first"
        );
        let check = off.next_check().unwrap();
        off.note_sent(check, now_us, left_us);
        off.note_reply(check, Firmware::Morpheus, None, now_us);
    }

    #[test]
    fn a_motor_is_off_when_it_is_seen_to_be() {
        let mut off = ForceOff::default();
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
        assert_eq!(off.take_report(5_000), Some(report));
        assert_eq!(off.take_report(6_000), None);
    }

    #[test]
    fn a_motor_that_reads_back_as_on_is_stopped_again_at_once() {
        let mut off = ForceOff::default();
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
        let mut off = ForceOff::default();
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
        let mut off = ForceOff::default();
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
        let mut off = ForceOff::default();
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
        let mut off = ForceOff::default();
        off.begin(0, false);
        for tick_us in [45_000, 90_000, 135_000, 180_000] {
            tick(&mut off, tick_us, [HEARD; JOINTS], &OFF);
            assert!(!off.is_stop_due(tick_us + 44_999));
        }
        assert!(off.is_off());
    }
}
