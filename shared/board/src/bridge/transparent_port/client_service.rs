//! Service of the transparent port's client in the idle slots of ticks.

use super::super::app_core::{Core, TickSamples};
use super::super::channels::{Mailbox, Notification};
use super::{ClientLine, Progress as Answered, REPORT_US, TransparentPort, Verdict, policy};
use crate::sequencer::{BusSequencer, SearchStep, State as BusState};
use crate::supervisor::{Event, State};
use armbridge_link::message::{Limits, Sample};
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

impl TransparentPort<'_> {
    /// Takes the client's bytes, and decides whether it gets or loses the bus.
    pub(in crate::bridge) fn poll<B: Bus>(
        &mut self,
        sequencer: &BusSequencer<B>,
        core: &Core,
    ) -> Option<Event> {
        let now_us = core.now_us();
        while self.waiting.is_none()
            && let Some(byte) = self.client.receive()
        {
            self.waiting = self.framer.push(byte, now_us);
        }
        if self.waiting.is_none() {
            self.waiting = self.framer.expire(now_us);
        }
        let halves = self.framer.truncated();
        if self.counters.counts.halves != halves {
            self.counters.change().halves = halves;
        }
        let ClientLine { is_open, .. } = self.client.line();
        let is_waiting = self.waiting.is_some();
        if core.state() == State::Passthrough {
            self.was_open |= is_open;
            let is_closed = self.was_open && !is_open && !is_waiting;
            let silent_at_us = self.silent_at_us(core.config().limits());
            let is_silent = silent_at_us.is_some_and(|at| now_us >= at);
            if is_silent {
                let ended = &mut self.counters.change().ended;
                *ended = ended.wrapping_add(1);
            }
            return (is_closed || is_silent).then_some(Event::ClientLeft);
        }
        let may_come = is_waiting
            && now_us >= self.claimed_until_us
            // The stop sequence precedes any packet of a client.
            && sequencer.state() != BusState::Search(SearchStep::Stop)
            && !sequencer.is_stopping();
        may_come.then_some(Event::ClientCame)
    }

    /// Latest time of the next poll for the client.
    pub(in crate::bridge) fn wake_at_us(&self, limits: &Limits) -> u64 {
        let framer = self.framer.wake_at_us();
        let silent = self.silent_at_us(limits);
        [framer, silent]
            .into_iter()
            .flatten()
            .min()
            .unwrap_or(u64::MAX)
    }

    /// Passes the servos' bytes to the client.
    #[inline]
    pub(in crate::bridge) fn send_tapped<B: Bus>(&mut self, sequencer: &mut BusSequencer<B>) {
        while let Some(byte) = sequencer.take_tapped() {
            self.send_to_client(&[byte]);
        }
    }

    /// Sends the client's next query between ticks, if it fits.
    pub(in crate::bridge) fn serve<B: Bus>(
        &mut self,
        sequencer: &mut BusSequencer<B>,
        core: &Core,
        sampled: &TickSamples,
        tick_due_us: u64,
    ) {
        if self.pending.is_none() {
            self.apply_policy(sequencer, core, sampled);
        }
        let now_us = core.now_us();
        let Some(pending) = &mut self.pending else {
            return;
        };
        if now_us.saturating_sub(self.since_us) > REQUEST_TIMEOUT_US {
            self.pending = None;
            self.count(false);
            return;
        }
        let budget = sequencer.time_budget(pending.servo(), tick_due_us);
        let Some(query) = budget.and_then(|budget| pending.next(budget)) else {
            self.has_waited = true;
            return;
        };
        self.since_us = now_us;
        self.tries += 1;
        sequencer.request_for_client(query, tick_due_us);
    }

    /// Applies the policy to the waiting packet.
    fn apply_policy<B: Bus>(
        &mut self,
        sequencer: &BusSequencer<B>,
        core: &Core,
        sampled: &TickSamples,
    ) {
        let Some(kind) = self.waiting.take() else {
            return;
        };
        let frame = self.framer.frame(kind);
        let Some(request) = frame.request() else {
            self.count(false);
            return;
        };
        let samples = sampled.samples.map(Sample::counts);
        match policy::decide(sequencer.firmware(), sequencer.servos(), samples, request) {
            Verdict::Query(pending) => {
                let period_us = core.config().period_us().get();
                let exchange_us = sampled.bus_us.saturating_sub(EXCHANGE_SPREAD_US);
                let budget = sequencer.spare_budget(pending.servo(), period_us, exchange_us);
                self.since_us = core.now_us();
                self.tries = 0;
                if pending.can_complete(budget) {
                    self.pending = Some(pending);
                } else {
                    // A servo that may be absent gives no answer.
                    if sequencer
                        .servos()
                        .iter()
                        .any(|ours| ours.get() == pending.servo())
                    {
                        self.send_to_client(&pending.refusal());
                    }
                    self.count(false);
                }
            }
            Verdict::Answer(bytes) => {
                self.send_to_client(&bytes);
                self.count(true);
            }
            Verdict::Refuse(bytes) => {
                self.send_to_client(&bytes);
                self.count(false);
            }
        }
    }

    /// Takes the servo's answer to the client's request, or its absence.
    pub(in crate::bridge) fn finish<B: Bus>(&mut self, sequencer: &BusSequencer<B>) {
        let Some(pending) = &mut self.pending else {
            return;
        };
        let reply = sequencer.reply();
        let reply = reply.map(|payload| (payload.alarms.bits(), payload.data.as_slice()));
        match pending.take_reply(reply) {
            Answered::More => {
                self.tries = 0;
                return;
            }
            Answered::Done(bytes) => self.send_to_client(&bytes),
            // A servo that has just sent may still not receive: repeated.
            Answered::Silent if self.tries < TRIES => return,
            // A silent servo gives no answer, and neither does the board.
            Answered::Silent => {}
        }
        self.pending = None;
        self.count(true);
    }

    fn send_to_client(&mut self, bytes: &[u8]) {
        for byte in bytes {
            if !self.client.send(*byte) {
                let lost = &mut self.counters.change().lost;
                *lost = lost.wrapping_add(1);
            }
        }
    }

    /// Reports the counters to the host, if one has changed.
    pub(in crate::bridge) fn report(&mut self, now_us: u64, mailbox: &mut Mailbox<'_>) {
        let is_due = now_us.saturating_sub(self.reported_us) >= REPORT_US;
        if is_due && self.counters.has_changed {
            self.reported_us = now_us;
            // One that is lost is followed by another with the same counts.
            let counts = self.counters.counts;
            self.counters.has_changed = !mailbox.notify(Notification::Port(counts));
        }
    }
}
