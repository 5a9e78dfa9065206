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
//! Off ages: a stock servo is read back again every [`RECHECK_US`] for as long as it has to be
//! off, since another master on the bus may switch it on. What such a master does is seen
//! within [`RECHECK_US`] and a tick for each joint, and undone by the next tick. A Morpheus
//! servo is commanded off in every tick, which is sooner.
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

use armbridge_link::message::{OffReport, OffState, Sample};
use armbridge_servo::{Firmware, JOINTS};

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
/// Age in µs at which a stock servo's read-back is repeated: in the tick after it, at the
/// longest period 45 ms later, and undone by the next one, within 100 ms. Queries and replies
/// are 42 bytes a servo: with the factory's return delay of 0.5 ms, a twentieth of the time at
/// 1 Mbaud.
const RECHECK_US: u64 = 40_000;
/// Repeated read-backs in a row without a reply after which a motor is no longer known to be off.
const MISSED_MAX: u8 = 3;
/// Ticks that command a stock servo off although it is known to be, after a repeated order.
const REPEAT_TICKS: u8 = 2;
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
    /// Its registers read back as off, too, at this time in µs, and so many repetitions have
    /// had no reply since; without a time it does not age.
    Off { read_us: Option<u64>, missed: u8 },
}

impl Evidence {
    fn is_off(self) -> bool {
        matches!(self, Self::Off { .. })
    }

    /// The check that is due now.
    fn check(self, now_us: u64) -> Option<CheckKind> {
        match self {
            Self::Commanded => Some(CheckKind::Ping),
            Self::Answering => Some(CheckKind::ReadBack),
            Self::Off { read_us, .. } => {
                let age_us = now_us.saturating_sub(read_us?);
                (age_us >= RECHECK_US).then_some(CheckKind::ReadBack)
            }
        }
    }
}

/// No evidence of the first `servos`; a joint without a servo has no motor that could be on.
fn unknown(servos: usize) -> [Evidence; JOINTS] {
    let absent = Evidence::Off {
        read_us: None,
        missed: 0,
    };
    let mut joints = [absent; JOINTS];
    for evidence in joints.iter_mut().take(servos) {
        *evidence = Evidence::Commanded;
    }
    joints
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
#[derive(Clone, Copy, Debug)]
pub(super) struct ForceOff {
    /// Number of servos.
    servos: usize,
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
    /// Ticks that command the motors off, also those known to be off.
    orders: u8,
    /// A report to the host is due, and the last report.
    is_reported: bool,
    reported: Option<[OffState; JOINTS]>,
}

impl ForceOff {
    /// This number of servos, of which nothing is known, and no order to switch them off.
    pub(super) fn new(servos: usize) -> Self {
        Self {
            servos,
            since_us: 0,
            next_stop_us: 0,
            stops: 0,
            joints: unknown(servos),
            silent_ticks: [0; JOINTS],
            ticks: 0,
            is_commanded: false,
            is_checked: false,
            next_joint: 0,
            orders: 0,
            is_reported: false,
            reported: None,
        }
    }

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
            ..Self::new(self.servos)
        };
    }

    /// Whether a stop sequence is due.
    pub(super) fn is_stop_due(&self, now_us: u64) -> bool {
        let has_had_checks = self.is_reported || self.ticks >= STOP_DELAY_TICKS;
        let is_late = now_us >= self.next_stop_us && has_had_checks;
        is_late && !self.is_off() && self.next_check(now_us).is_none()
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
        self.orders = self.orders.saturating_sub(1);
        let joints = self.joints.iter_mut().zip(&mut self.silent_ticks);
        for ((evidence, silent_ticks), sample) in joints.zip(samples).take(self.servos) {
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

    /// The next check, at most one a tick; where ticks are rare, one for each joint that is
    /// known to be off.
    pub(super) fn next_check(&self, now_us: u64) -> Option<OffCheck> {
        if self.is_checked || !self.is_commanded {
            return None;
        }
        (0..JOINTS).find_map(|step| {
            let joint = (self.next_joint + step) % JOINTS;
            let kind = self.joints.get(joint)?.check(now_us)?;
            Some(OffCheck { joint, kind })
        })
    }

    /// Notes that the check has been sent, this time before the next tick.
    pub(super) fn note_sent(&mut self, check: OffCheck, now_us: u64, left_us: u64) {
        self.is_checked = !(self.is_off() && left_us > RARE_US);
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
                match *evidence {
                    Evidence::Off { read_us, missed } if missed < MISSED_MAX => Evidence::Off {
                        read_us,
                        missed: missed + 1,
                    },
                    _ => Evidence::Commanded,
                }
            }
            (CheckKind::Ping, Some(data)) if firmware.is_pong(data) => Evidence::Answering,
            (CheckKind::Ping, Some(_)) => Evidence::Commanded,
            (CheckKind::ReadBack, Some(data)) => match firmware.decode_off(data) {
                Some(true) => Evidence::Off {
                    read_us: (firmware != Firmware::Morpheus).then_some(now_us),
                    missed: 0,
                },
                Some(false) => {
                    self.next_stop_us = now_us;
                    // What has set this one on may have set the others on too.
                    return self.discard_evidence();
                }
                None => Evidence::Commanded,
            },
        };
    }

    /// Whether every servo is confirmed off, and has answered since.
    pub(super) fn is_off(&self) -> bool {
        self.joints.iter().all(|evidence| evidence.is_off())
    }

    /// Whether the servo of this joint has been silent for [`SILENT_TICKS`].
    pub(super) fn is_out_of_reach(&self, joint: usize) -> bool {
        let silent = self.silent_ticks.get(joint);
        silent.is_some_and(|ticks| *ticks >= SILENT_TICKS)
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
            ..Self::new(self.servos)
        };
    }

    /// Repeats the order: the next ticks command the motors off, and those that are known to be
    /// off are read back again.
    pub(super) fn repeat(&mut self) {
        // A switch that is held asks in every tick.
        if self.orders > 0 {
            return;
        }
        self.orders = REPEAT_TICKS;
        for evidence in &mut self.joints {
            if let Evidence::Off {
                read_us: Some(read_us),
                ..
            } = evidence
            {
                *read_us = 0;
            }
        }
    }

    /// Whether a tick has to command the motors off: one of them is not known to be, or
    /// the order was repeated.
    pub(super) fn is_order_due(&self) -> bool {
        self.orders > 0 || !self.is_off()
    }

    /// Discards all evidence: the servos may have changed meanwhile.
    pub(super) fn discard_evidence(&mut self) {
        self.joints = unknown(self.servos);
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
                Evidence::Off { .. } => OffState::Off,
                _ if silent_ticks >= SILENT_TICKS => OffState::OutOfReach,
                _ => OffState::Unconfirmed,
            };
        }
        if self.reported == Some(joints) {
            return None;
        }
        self.reported = Some(joints);
        self.is_reported = true;
        self.last_report()
    }

    /// The last report to the host since the beginning, for a host that joins later.
    pub(super) fn last_report(&self) -> Option<OffReport> {
        let joints = self.reported?;
        let stops = self.stops;
        Some(OffReport { stops, joints })
    }
}

#[cfg(test)]
mod tests;
