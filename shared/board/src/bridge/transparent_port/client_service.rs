//! Service of the transparent port's client in the idle slots of ticks.

use super::super::channels::Notification;
use super::super::{Bridge, SERVO_IDS};
use super::{ClientLine, Progress as Answered, REPORT_US, Verdict, policy};
use crate::sequencer::{SearchStep, State as BusState};
use crate::supervisor::{Event, State};
use armbridge_link::message::Sample;
use armbridge_servo::bus::Bus;

/// Longest wait of a request, or of the next part of it, for a slot, in µs; then it is
/// dropped: the vendor's SDK waits 34 ms for an answer, and takes a later one for that of
/// the next request.
const REQUEST_TIMEOUT_US: u64 = 30_000;
/// Number of queries to a servo that does not answer.
const TRIES: u8 = 3;
/// Spread of the duration of a tick's exchange, in µs: its margin, and the servos' own
/// 26 µs either way.
const EXCHANGE_SPREAD_US: u32 = 80;

impl<B: Bus> Bridge<'_, B> {
    /// Takes the client's bytes, and decides whether it gets or keeps the bus. Most polls find
    /// no client.
    pub(in crate::bridge) fn poll_client(&mut self) {
        let is_quiet = self.end.client.is_empty() && self.port.is_quiet();
        if !is_quiet || self.core.state() == State::Passthrough {
            self.serve_port();
        }
    }

    #[inline(never)]
    fn serve_port(&mut self) {
        let now_us = self.core.now_us();
        let port = &mut self.port;
        while port.waiting.is_none()
            && let Some(byte) = self.end.client.receive()
        {
            port.waiting = port.framer.push(byte, now_us);
        }
        if port.waiting.is_none() {
            port.waiting = port.framer.expire(now_us);
        }
        let halves = port.framer.truncated();
        if port.counters.counts.halves != halves {
            port.counters.change().halves = halves;
        }
        let ClientLine { is_open, .. } = self.end.client.line();
        let is_waiting = port.waiting.is_some();
        if self.core.state() == State::Passthrough {
            port.was_open |= is_open;
            let is_closed = port.was_open && !is_open && !is_waiting;
            let is_silent = self.client_silent_at_us().is_some_and(|at| now_us >= at);
            if is_silent {
                let ended = &mut self.port.counters.change().ended;
                *ended = ended.wrapping_add(1);
            }
            if is_closed || is_silent {
                // Never refused.
                let _ = self.apply(Event::ClientLeft);
            }
        } else if is_waiting
            && now_us >= port.claimed_until_us
            // The stop sequence precedes any packet of a client.
            && self.sequencer.state() != BusState::Search(SearchStep::Stop)
            && !self.sequencer.is_stopping()
        {
            let _ = self.apply(Event::ClientCame);
        }
        self.report_port();
    }

    /// Latest time of the next poll for the client.
    pub(in crate::bridge) fn client_wake_us(&self) -> u64 {
        let framer = self.port.framer.wake_at_us();
        let silent = self.client_silent_at_us();
        [framer, silent]
            .into_iter()
            .flatten()
            .min()
            .unwrap_or(u64::MAX)
    }

    /// Passes the servos' bytes to the client.
    #[inline]
    pub(in crate::bridge) fn relay_tapped_bytes(&mut self) {
        while let Some(byte) = self.sequencer.take_tapped() {
            self.send_to_client(&[byte]);
        }
    }

    /// Sends the client's next query between ticks, if it fits.
    pub(in crate::bridge) fn serve_client(&mut self, tick_due_us: u64) {
        if self.port.pending.is_none() {
            self.apply_policy();
        }
        let now_us = self.core.now_us();
        let Some(pending) = &mut self.port.pending else {
            return;
        };
        if now_us.saturating_sub(self.port.since_us) > REQUEST_TIMEOUT_US {
            self.port.pending = None;
            self.port.count(false);
            return;
        }
        let budget = self.sequencer.time_budget(pending.servo(), tick_due_us);
        let Some(query) = budget.and_then(|budget| pending.next(budget)) else {
            self.port.has_waited = true;
            return;
        };
        self.port.since_us = now_us;
        self.port.tries += 1;
        self.sequencer.request_for_client(query, tick_due_us);
    }

    /// Applies the policy to the waiting packet.
    fn apply_policy(&mut self) {
        let Some(kind) = self.port.waiting.take() else {
            return;
        };
        let frame = self.port.framer.frame(kind);
        let Some(request) = frame.request() else {
            self.port.count(false);
            return;
        };
        let samples = self.sampled.samples.map(Sample::counts);
        match policy::decide(self.sequencer.firmware(), SERVO_IDS, samples, request) {
            Verdict::Query(pending) => {
                let period_us = self.core.config().period_us().get();
                let exchange_us = self.sampled.bus_us.saturating_sub(EXCHANGE_SPREAD_US);
                let budget = self
                    .sequencer
                    .spare_budget(pending.servo(), period_us, exchange_us);
                self.port.since_us = self.core.now_us();
                self.port.tries = 0;
                if pending.can_complete(budget) {
                    self.port.pending = Some(pending);
                } else {
                    // A servo that may be absent gives no answer.
                    if SERVO_IDS.iter().any(|ours| ours.get() == pending.servo()) {
                        self.send_to_client(&pending.refusal());
                    }
                    self.port.count(false);
                }
            }
            Verdict::Answer(bytes) => {
                self.send_to_client(&bytes);
                self.port.count(true);
            }
            Verdict::Refuse(bytes) => {
                self.send_to_client(&bytes);
                self.port.count(false);
            }
        }
    }

    /// Takes the servo's answer to the client's request, or its absence.
    pub(in crate::bridge) fn finish_client(&mut self) {
        let Some(pending) = &mut self.port.pending else {
            return;
        };
        let reply = self.sequencer.reply();
        let reply = reply.map(|payload| (payload.alarms.bits(), payload.data.as_slice()));
        match pending.take_reply(reply) {
            Answered::More => {
                self.port.tries = 0;
                return;
            }
            Answered::Done(bytes) => self.send_to_client(&bytes),
            // A servo that has just sent may still not receive: repeated.
            Answered::Silent if self.port.tries < TRIES => return,
            // A silent servo gives no answer, and neither does the board.
            Answered::Silent => {}
        }
        self.port.pending = None;
        self.port.count(true);
    }

    fn send_to_client(&mut self, bytes: &[u8]) {
        for byte in bytes {
            if !self.end.client.send(*byte) {
                let lost = &mut self.port.counters.change().lost;
                *lost = lost.wrapping_add(1);
            }
        }
    }

    fn report_port(&mut self) {
        let now_us = self.core.now_us();
        let port = &mut self.port;
        let is_due = now_us.saturating_sub(port.reported_us) >= REPORT_US;
        if is_due && port.counters.has_changed {
            port.reported_us = now_us;
            // Lost if the host does not fetch it: the next one has the same counts.
            let notification = Notification::Port(port.counters.counts);
            port.counters.has_changed = self.end.notifications.enqueue(notification).is_err();
        }
    }
}
