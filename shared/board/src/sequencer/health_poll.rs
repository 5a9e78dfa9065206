//! Health poll: the board's own requests to servos in the idle slots of ticks.
//!
//! | request     | when                                          | purpose            |
//! |-------------|-----------------------------------------------|--------------------|
//! | temperature | each [`INTERVAL_US`], one servo after the other | a hot motor is switched off |
//! | torque      | each [`TORQUE_US`], one stock servo after the other, while motors may be driven | a servo that was reset, and so has no torque, is detected |
//! | ping, twice | a Morpheus servo has been missing for two, three and four fifths of what is allowed | a servo that lost power for a moment, and so has left the chain, is distinguished from one that is gone or on a bad line: it answers all six, and so does the other if it is missing too |
//!
//! A temperature goes out if its reply is sure to be over before the next tick;
//! after [`OVERDUE_US`] without such a slot, which is so at the shortest periods, a
//! tick may begin late for it. A ping may always delay a tick: the state of the arm is in doubt.
//!
//! A stock servo that was reset still answers. Its torque enable is read in a slot
//! that is long enough; after [`TORQUE_OVERDUE_US`] without one, which is so at 1 kHz, a
//! tick may begin late for it: when the servo's own control step falls into the reply,
//! once in eight times, and then by less than 100 µs.
//!
//! A stock servo sends its heat alarm with every answer and switches itself off, so
//! a tick is never late for its temperature. So does an X servo, but its reading is as short as that of
//! its torque enable, and a tick may be late for it, too, midway between two of those: at 1 kHz and
//! 1 Mbaud there is no other way.

use super::dropouts::Dropouts;
use armbridge_servo::master::Payload;
use armbridge_servo::{Alarms, Firmware, JOINTS, Query, ServoId};

/// Interval from one temperature to the next, of the other servo. A motor's winding heats
/// up in tens of seconds.
const INTERVAL_US: u64 = 250_000;
/// Interval from one reading of a torque enable to the next, of the other servo: with the
/// exchange itself, a reset is detected within 100 ms.
const TORQUE_US: u64 = 40_000;
/// Longest wait of such a reading for a slot, in µs; then a tick waits for it.
const TORQUE_OVERDUE_US: u64 = 5_000;
/// Longest wait of a temperature for a slot, in µs; then a tick waits for it.
const OVERDUE_US: u64 = 1_000_000;
/// Number of pings to a servo that is missing, and of those in a row. On a line that damages
/// one byte in 50, on which four ticks in a row fail now and then, a servo answers all six
/// once in four times, and two servos all twelve once in 18.
const PINGS: u8 = 6;
const PINGS_IN_ROW: u8 = 2;

/// Request of the health poll.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum HealthRequest {
    Temperature { joint: usize },
    Torque { joint: usize },
    Ping { joint: usize },
}

/// Result of a health poll.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Health {
    /// Temperature of this joint's servo: °C of a stock servo, counts of a Morpheus
    /// servo's converter.
    Temperature {
        /// Index of the joint.
        joint: usize,
        /// Temperature.
        value: u16,
    },
    /// The servo of this joint has been reset: it answers pings, but not in ticks, or its
    /// torque is not enabled any more.
    Reset {
        /// Index of the joint.
        joint: usize,
    },
}

/// Times of requests, and pings that were answered.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct HealthPoll {
    /// The joint whose temperature is next, and when, in µs.
    joint: usize,
    due_us: u64,
    /// Next joint and due time of torque enable.
    torque_joint: usize,
    torque_due_us: u64,
    /// Pings since the servo has been missing, and the number answered.
    pings: [u8; JOINTS],
    pongs: [u8; JOINTS],
}

impl HealthPoll {
    /// Restarts the poll: the servos have been found again.
    pub(super) fn restart(&mut self, now_us: u64) {
        *self = Self {
            due_us: now_us + INTERVAL_US,
            ..Self::default()
        };
    }

    /// The request that is due, and whether a tick may begin late for it.
    pub(super) fn next(
        &mut self,
        firmware: Firmware,
        now_us: u64,
        dropouts: &Dropouts,
        may_drive: bool,
    ) -> Option<(HealthRequest, bool)> {
        let &Dropouts {
            in_row: missing_in_row,
            allowed,
        } = dropouts;
        let is_morpheus = firmware == Firmware::Morpheus;
        let counted = self
            .pings
            .iter_mut()
            .zip(&mut self.pongs)
            .zip(missing_in_row);
        for (joint, ((pings, pongs), missing)) in counted.enumerate() {
            if missing == 0 {
                (*pings, *pongs) = (0, 0);
            }
            let due = 5 * missing >= (2 + u32::from(*pings / PINGS_IN_ROW)) * allowed;
            if is_morpheus && due && *pings < PINGS {
                return Some((HealthRequest::Ping { joint }, true));
            }
        }
        let joint = self.torque_joint;
        if !is_morpheus && may_drive && now_us >= self.torque_due_us {
            let may_be_late = now_us >= self.torque_due_us + TORQUE_OVERDUE_US;
            return Some((HealthRequest::Torque { joint }, may_be_late));
        }
        let joint = self.joint;
        let overdue_us = now_us.checked_sub(self.due_us)?;
        let may_be_late = overdue_us >= OVERDUE_US && self.may_delay_a_tick(firmware, now_us);
        Some((HealthRequest::Temperature { joint }, may_be_late))
    }

    /// Whether a tick may wait for a temperature.
    fn may_delay_a_tick(&self, firmware: Firmware, now_us: u64) -> bool {
        let to_torque_us = self.torque_due_us.checked_sub(now_us);
        match firmware {
            Firmware::Morpheus => true,
            Firmware::Stock => false,
            // A tick that was late for a torque leaves the next too little time.
            Firmware::XSeries => {
                to_torque_us.is_none_or(|us| (TORQUE_US / 4..TORQUE_US / 2).contains(&us))
            }
        }
    }

    /// Notes that the request has been sent to one of this number of servos.
    pub(super) fn note_sent(&mut self, request: HealthRequest, now_us: u64, servos: usize) {
        match request {
            HealthRequest::Temperature { joint } => {
                self.due_us = now_us + INTERVAL_US;
                self.joint = (joint + 1) % servos.max(1);
            }
            HealthRequest::Torque { joint } => {
                self.torque_due_us = now_us + TORQUE_US;
                self.torque_joint = (joint + 1) % servos.max(1);
            }
            HealthRequest::Ping { joint } => {
                if let Some(pings) = self.pings.get_mut(joint) {
                    *pings += 1;
                }
            }
        }
    }

    /// Takes a reply, or its absence; returns the result.
    pub(super) fn note_reply(
        &mut self,
        request: HealthRequest,
        firmware: Firmware,
        reply: Option<&Payload>,
    ) -> Option<Health> {
        let data = reply.map(|reply| reply.data.as_slice());
        let alarms = reply.map_or(Alarms::NONE, |reply| reply.alarms);
        match request {
            HealthRequest::Ping { joint } => {
                let pongs = self.pongs.get_mut(joint)?;
                *pongs += u8::from(data.is_some_and(|data| firmware.is_pong(data)));
                let is_reset = *pongs == PINGS && self.pongs == self.pings;
                is_reset.then_some(Health::Reset { joint })
            }
            // Alarms are reported with samples.
            HealthRequest::Torque { joint } => {
                if data.is_none() {
                    // Repeated in the next slot: otherwise a reset is detected a turn later.
                    self.torque_joint = joint;
                    self.torque_due_us = self.torque_due_us.saturating_sub(TORQUE_US);
                }
                // 255 of an X servo that has switched its motor off by itself.
                let is_reset = matches!(data, Some([0 | 255])) && alarms.is_empty();
                is_reset.then_some(Health::Reset { joint })
            }
            HealthRequest::Temperature { joint } => {
                let value = firmware.temperature(data?)?;
                Some(Health::Temperature { joint, value })
            }
        }
    }
}

impl HealthRequest {
    /// The query of the request, to this servo.
    pub(super) fn query(self, firmware: Firmware, servo: ServoId) -> Option<Query> {
        match self {
            Self::Ping { .. } => Some(firmware.ping_query(servo)),
            Self::Torque { .. } => firmware.reset_query(servo),
            Self::Temperature { .. } => firmware.temperature_query(servo),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use heapless::Vec;

    /// Runs ticks in which samples of these joints are missing, of five that may be; each
    /// ping is answered or not. The tick with the verdict, and its joint.
    fn verdict(missing: [bool; JOINTS], answers: impl Fn(usize) -> bool) -> Option<(u32, usize)> {
        let mut poll = HealthPoll::default();
        let pong = Payload {
            data: Vec::from_slice(&[1]).unwrap(),
            ..Payload::default()
        };
        let mut pings = 0;
        for tick in 1..5 {
            let dropouts = Dropouts {
                in_row: missing.map(|missing| if missing { tick } else { 0 }),
                allowed: 5,
            };
            while let Some((request @ HealthRequest::Ping { .. }, may_be_late)) =
                poll.next(Firmware::Morpheus, 0, &dropouts, true)
            {
                assert!(may_be_late);
                poll.note_sent(request, 0, JOINTS);
                let reply = answers(pings).then_some(&pong);
                pings += 1;
                if let Some(Health::Reset { joint }) =
                    poll.note_reply(request, Firmware::Morpheus, reply)
                {
                    return Some((tick, joint));
                }
            }
        }
        None
    }

    #[test]
    fn a_servo_that_answers_every_ping_has_been_reset() {
        assert_eq!(verdict([false, true], |_| true), Some((4, 1)));
        assert_eq!(verdict([true, true], |_| true), Some((4, 0)));
        for lost in 0..6 {
            assert_eq!(verdict([true, false], |ping| ping != lost), None, "{lost}");
        }
        // A line on which the other is lost as well.
        for lost in 0..10 {
            let all = verdict([true, true], |ping| ping != lost);
            assert_eq!(all, None, "{lost}");
        }
    }
}
