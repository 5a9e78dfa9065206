//! How the tick serves the client of the transparent port, beside its own work.

use embedded_hal::digital::OutputPin;
use embedded_hal_nb::serial::{Read, Write};

use super::super::mailbox::Notice;
use super::super::schedule::Stage;
use super::super::supervisor::{Event, State};
use super::super::{Bridge, SERVO_IDS};
use super::{ClientLine, Job, Progress as Answered, REPORT_US, Slack, Verdict, judge};
use crate::link::message::Sample;
use crate::servo::master::timing::{GUARD_US, latency_us, prepared_latency_us};
use crate::servo::port::{SetBaud, byte_ns};

/// What a tick may begin late because of the client before it is an error: none;
/// this much is kept free for the board to get from one to the other.
const RESERVE_US: u64 = 10;

/// A question, or the next piece of it, that finds no room for so long, in µs,
/// is dropped: the vendor's SDK waits 34 ms for an answer, and one that comes
/// later would be taken for the next.
const PATIENCE_US: u64 = 30_000;
/// How often a servo is asked that does not answer.
const TRIES: u8 = 3;
/// What a tick may take less than the one before: what is margin in it, and the
/// servos' own 26 µs either way.
const SHORTER_US: u32 = 80;

impl<S, D> Bridge<'_, S, D>
where
    S: Read<u8> + Write<u8> + SetBaud,
    D: OutputPin,
{
    /// Takes what the client says, and decides whose the bus is.
    pub(in crate::bridge) fn heed_client(&mut self) {
        let gateway = &mut self.gateway;
        while gateway.item.is_none()
            && let Some(byte) = self.end.client.take()
        {
            gateway.item = gateway.framer.push(byte, self.now_us);
        }
        if gateway.item.is_none() {
            gateway.item = gateway.framer.expire(self.now_us);
        }
        gateway.counters.halves = gateway.framer.halves();
        let ClientLine { is_open, .. } = self.end.client.line();
        let is_waiting = gateway.item.is_some();
        if self.state == State::Passthrough {
            gateway.was_open |= is_open;
            if gateway.was_open && !is_open && !is_waiting {
                // Never refused.
                let _ = self.apply(Event::ClientLeft);
            }
        } else if is_waiting
            && self.now_us >= gateway.claimed_until_us
            // The stop sequence comes before anything of a client's.
            && !matches!(self.stage, Stage::Stop | Stage::StopHere)
        {
            let _ = self.apply(Event::ClientCame);
        }
        self.report_port();
    }

    /// When the client's affairs need a look at the latest.
    pub(in crate::bridge) fn client_wake_us(&self) -> u64 {
        self.gateway.framer.wake_at_us().unwrap_or(u64::MAX)
    }

    /// The bus is idle: is there something to do on it for the client?
    pub(in crate::bridge) fn serve_client(&mut self) {
        match self.stage {
            Stage::Released => self.relay(),
            Stage::Ticking => self.serve_in_slack(),
            Stage::StopHere
            | Stage::Stop
            | Stage::Ping { .. }
            | Stage::Start
            | Stage::Settle(_) => {}
        }
    }

    /// Hands over what was heard of the servos.
    pub(in crate::bridge) fn pass_overheard(&mut self) {
        while let Some(byte) = self.master.overheard() {
            self.give(&[byte]);
        }
    }

    /// Between ticks: one question at a time, if it fits.
    fn serve_in_slack(&mut self) {
        if self.gateway.job.is_none() {
            self.judge();
        }
        let Some(servo) = self.gateway.job.as_ref().map(Job::servo) else {
            return;
        };
        if self.now_us.saturating_sub(self.gateway.since_us) > PATIENCE_US {
            self.gateway.job = None;
            self.count(false);
            return;
        }
        let slack = self.slack_now(servo);
        let next = self.gateway.job.as_mut().and_then(|job| job.next(slack));
        let Some(ask) = next else {
            self.gateway.has_waited = true;
            return;
        };
        let expected = ask.expected_reply(slack.latency_us);
        self.gateway.since_us = self.now_us;
        self.gateway.tries += 1;
        // Idle was just seen, and our own requests are short.
        let _ = self.master.ask(&ask.packet, expected, self.now_us);
        let _ = self.master.poll(self.now_us);
    }

    /// Until the next tick.
    pub(in crate::bridge) fn slack_now(&self, id: u8) -> Slack {
        let begins_us = self.now_us.max(self.master.ready_at_us());
        let budget_us = self
            .next_start_us
            .saturating_sub(begins_us + GUARD_US + RESERVE_US);
        self.slack(id, budget_us as u32)
    }

    /// A servo that bring-up has not set may take as long as any.
    fn slack(&self, id: u8, budget_us: u32) -> Slack {
        let (firmware, baud) = (self.master.firmware(), self.master.baud());
        Slack {
            budget_us,
            byte_ns: byte_ns(baud),
            latency_us: if is_ours(id) {
                prepared_latency_us(firmware, baud)
            } else {
                latency_us(firmware)
            },
        }
    }

    /// What may be done with the packet that waits?
    fn judge(&mut self) {
        let Some(item) = self.gateway.item.take() else {
            return;
        };
        let frame = self.gateway.framer.frame(item);
        let Some(request) = frame.request() else {
            self.count(false);
            return;
        };
        let firmware = self.master.firmware();
        let samples = self.record.samples.map(Sample::counts);
        match judge(firmware, SERVO_IDS, samples, request) {
            Verdict::Ask(job) => {
                let period_us = self.law.period_us().get() as u32;
                let rests_us = (2 * GUARD_US + RESERVE_US) as u32;
                let taken_us = (self.record.timing.bus_us + rests_us).saturating_sub(SHORTER_US);
                let slack = self.slack(job.servo(), period_us.saturating_sub(taken_us));
                self.gateway.since_us = self.now_us;
                self.gateway.tries = 0;
                if job.can_ever_fit(slack) {
                    self.gateway.job = Some(job);
                } else {
                    // In the name of a servo that may not be there, nothing.
                    if is_ours(job.servo()) {
                        self.give(&job.refusal());
                    }
                    self.count(false);
                }
            }
            Verdict::Answer(bytes) => {
                self.give(&bytes);
                self.count(true);
            }
            Verdict::Refuse(bytes) => {
                self.give(&bytes);
                self.count(false);
            }
        }
    }

    /// The servo has answered the client's question, or not.
    pub(in crate::bridge) fn finish_client(&mut self) {
        let Some(job) = &mut self.gateway.job else {
            return;
        };
        let reply = self.master.reply();
        let reply = reply.map(|payload| (payload.alarms.bits(), payload.data.as_slice()));
        match job.took(reply) {
            Answered::More => {
                self.gateway.tries = 0;
                return;
            }
            Answered::Done(bytes) => self.give(&bytes),
            // A servo that has just spoken may still be deaf: once more.
            Answered::Silent if self.gateway.tries < TRIES => return,
            // The servo is silent; so is the board.
            Answered::Silent => {}
        }
        self.gateway.job = None;
        self.count(true);
    }

    pub(super) fn give(&mut self, bytes: &[u8]) {
        for byte in bytes {
            if !self.end.client.give(*byte) {
                let lost = &mut self.gateway.counters.lost;
                *lost = lost.wrapping_add(1);
            }
        }
    }

    pub(super) fn count(&mut self, is_passed: bool) {
        let has_waited = core::mem::take(&mut self.gateway.has_waited);
        let counters = &mut self.gateway.counters;
        let which = if is_passed {
            &mut counters.passed
        } else {
            &mut counters.refused
        };
        *which = which.wrapping_add(1);
        if is_passed && has_waited {
            counters.delayed = counters.delayed.wrapping_add(1);
        }
    }

    fn report_port(&mut self) {
        let gateway = &mut self.gateway;
        let is_due = self.now_us.saturating_sub(gateway.reported_us) >= REPORT_US;
        if is_due && gateway.counters != gateway.reported {
            gateway.reported_us = self.now_us;
            // Lost if the host does not fetch it: the next one says more.
            if self
                .end
                .notices
                .enqueue(Notice::Port(gateway.counters))
                .is_ok()
            {
                gateway.reported = gateway.counters;
            }
        }
    }
}

/// Whether bring-up has found this servo.
fn is_ours(id: u8) -> bool {
    SERVO_IDS.iter().any(|ours| ours.get() == id)
}
