//! Steps: begin, end and order of the transactions of the sequencer.

use super::discovery::Next;
use super::idle_request::Owner;
use super::servo_setup::Progress;
use super::setup_step::{SetupGoal, SetupStep};
use super::{BusEvent, BusSequencer, SearchStep, State};
use crate::checkpoints::{Checkpoints, Machine};
use armbridge_link::message::{Missing, Sample};
use armbridge_link::record::Permission;
use armbridge_servo::bus::Bus;
use armbridge_servo::master::timing::reply_latency_us;
use armbridge_servo::master::{Outcome, Transaction};
use armbridge_servo::{Firmware, JOINTS};

/// Pause between two attempts to find the servos, in µs. It is short: each attempt begins
/// with a stop, which a servo may need.
const SEARCH_PAUSE_US: u64 = 10_000;
/// Interval of checks while the bus is lent, in µs.
const LENT_POLL_US: u64 = 10_000;

impl<B: Bus> BusSequencer<B> {
    /// Advances the bus as far as it goes without waiting. Returns an event when a
    /// transaction or step has ended; the caller [begins](Self::begin_tick) the ticks.
    pub fn poll(&mut self, now_us: u64) -> Option<BusEvent> {
        self.now_us = now_us;
        if let Ok(outcome) = self.master.poll(now_us) {
            return Some(self.finish(&outcome));
        }
        if !self.master.is_idle() {
            return None;
        }
        if let Some((stop, baud)) = self.stops.take() {
            return self.begin_stop(stop, baud);
        }
        match self.state {
            State::Search(step) if now_us >= self.next_us => self.begin_search_step(step),
            State::ForceOff
                if self.off.is_stop_due(now_us) && self.permission == Permission::Off =>
            {
                self.plan_stops();
                let (stop, baud) = self.stops.take()?;
                self.begin_stop(stop, baud)
            }
            State::Passthrough if now_us >= self.next_us => {
                self.next_us = now_us + LENT_POLL_US;
                if !self.is_tapping {
                    self.is_tapping = true;
                    self.master.set_rx_tap(true);
                }
                Some(BusEvent::Searching)
            }
            State::Search(_) | State::ForceOff | State::Drive | State::Passthrough => None,
        }
    }

    fn begin_stop(&mut self, stop: Transaction, baud: u32) -> Option<BusEvent> {
        // Stock servos release their shafts, but keep their return delay. The shorter
        // the receive windows of ticks, the more commands reach a silent servo.
        self.master.mark_released();
        // Not busy: idle was checked before.
        let _ = self.master.set_line(self.firmware(), baud);
        self.begin(stop);
        self.is_planned_stop = true;
        None
    }

    fn begin(&mut self, transaction: Transaction) {
        self.owner = None;
        self.is_planned_stop = false;
        // Not busy: idle was checked before.
        let _ = self.master.begin(transaction, self.now_us);
        let _ = self.master.poll(self.now_us);
    }

    fn begin_search_step(&mut self, step: SearchStep) -> Option<BusEvent> {
        // Not busy: idle was checked before.
        let _ = self.master.set_servos(self.ids);
        let transaction = match step {
            SearchStep::Stop => {
                self.master.set_prepared(None);
                self.master.forget_echo();
                self.discovery.begin();
                self.set_bus_line(Firmware::Morpheus);
                Transaction::Stop
            }
            SearchStep::Ping { joint, firmware } => {
                self.set_bus_line(firmware);
                Transaction::Ping { joint }
            }
            SearchStep::Start => Transaction::Start,
            SearchStep::SetUp(step) => return self.begin_set_up(step),
        };
        self.begin(transaction);
        None
    }

    /// Sets firmware and the speed of the search.
    fn set_bus_line(&mut self, firmware: Firmware) {
        let baud = self.discovery.baud().unwrap_or(self.baud());
        // Not busy: idle was checked before.
        let _ = self.master.set_line(firmware, baud);
    }

    fn begin_set_up(&mut self, step: SetupStep) -> Option<BusEvent> {
        let (step, query) = match self.setup.request(step, self.firmware(), self.ids) {
            Ok(request) => request,
            Err(goal) => return Some(self.finish_set_up(goal)),
        };
        let latency_us = reply_latency_us(self.firmware(), self.baud(), false);
        let expected = query.expected_reply(latency_us);
        self.state = State::Search(SearchStep::SetUp(step));
        self.owner = Some(Owner::SetUp(step));
        // Not busy: idle was checked before; set-up packets are short.
        let _ = self.master.request(&query.packet, expected, self.now_us);
        let _ = self.master.poll(self.now_us);
        None
    }

    /// Processes the outcome of a transaction.
    fn finish(&mut self, outcome: &Outcome) -> BusEvent {
        match (outcome.transaction, self.state) {
            (
                Transaction::Drive(_) | Transaction::HoldOff | Transaction::StopWedged { .. },
                State::Passthrough,
            ) => BusEvent::Searching,
            (Transaction::Drive(_) | Transaction::HoldOff | Transaction::StopWedged { .. }, _) => {
                let is_off = outcome.transaction.is_off();
                if is_off && self.state == State::ForceOff {
                    self.off.note_tick(self.now_us, outcome.samples);
                }
                let checkpoints = Checkpoints::begin(self.tick).pass(Machine::Sequencer);
                BusEvent::Sampled(*outcome, checkpoints)
            }
            (Transaction::Request(_), _) => self.finish_request(),
            (Transaction::Stop, State::Search(SearchStep::Stop)) if !self.is_planned_stop => {
                self.state = State::Search(SearchStep::Ping {
                    joint: 0,
                    firmware: self.discovery.first_firmware(),
                });
                BusEvent::Searching
            }
            (Transaction::Ping { joint }, State::Search(SearchStep::Ping { firmware, .. })) => {
                let sample = outcome.samples.get(joint).copied();
                let next = self.discovery.note_ping(joint, firmware, sample);
                self.finish_ping(next)
            }
            (Transaction::Start, State::Search(SearchStep::Start)) => {
                match first_missing(outcome.samples, self.ids.len()) {
                    Some((joint, missing)) => self.absent(joint, missing),
                    None => self.line_up(),
                }
            }
            (Transaction::Stop | Transaction::BriefStop, _) if self.stops.is_done() => {
                self.off.note_stop(self.now_us);
                if self.is_ticking() {
                    // Not busy: the stop has ended.
                    let _ = self.master.set_line(self.firmware(), self.found_baud);
                }
                BusEvent::Searching
            }
            // One of a plan's stops, or the state has changed since.
            (
                Transaction::Stop
                | Transaction::BriefStop
                | Transaction::Ping { .. }
                | Transaction::Start,
                _,
            ) => BusEvent::Searching,
        }
    }

    fn finish_ping(&mut self, next: Next) -> BusEvent {
        let step = match next {
            Next::Ping { joint, firmware } => SearchStep::Ping { joint, firmware },
            Next::OtherSpeed => SearchStep::Stop,
            Next::Found(found) => {
                let before = self.firmware.replace(found);
                self.set_bus_line(found);
                self.state = State::Search(match found {
                    Firmware::Morpheus => SearchStep::Start,
                    Firmware::Stock | Firmware::XSeries => SearchStep::SetUp(SetupStep::READ),
                });
                let is_changed = before.is_some_and(|before| before != found);
                return if is_changed {
                    BusEvent::FirmwareChanged
                } else {
                    BusEvent::Searching
                };
            }
            Next::Mixed(firmwares) => {
                self.search_again();
                return BusEvent::Mixed(firmwares);
            }
            Next::Absent(joint, missing) => return self.absent(joint, missing),
        };
        self.state = State::Search(step);
        BusEvent::Searching
    }

    fn absent(&mut self, joint: usize, missing: Missing) -> BusEvent {
        self.search_again();
        BusEvent::Absent(joint, missing)
    }

    /// Restarts the search after a pause.
    fn search_again(&mut self) {
        self.state = State::Search(SearchStep::Stop);
        self.next_us = self.now_us + SEARCH_PAUSE_US;
    }

    fn line_up(&mut self) -> BusEvent {
        self.state = State::ForceOff;
        self.found_baud = self.baud();
        self.off.resume(self.now_us);
        self.health.restart(self.now_us);
        BusEvent::LinedUp
    }

    /// Not inlined: most transactions are ticks.
    #[inline(never)]
    fn finish_request(&mut self) -> BusEvent {
        let Some(owner) = self.owner.take() else {
            return BusEvent::Served;
        };
        let firmware = self.firmware();
        let data = self.master.reply().map(|reply| reply.data.as_slice());
        match owner {
            Owner::Off(check) => {
                self.off.note_reply(check, firmware, data, self.now_us);
                if self.off.is_off() {
                    self.client_speeds.clear();
                }
                BusEvent::Served
            }
            Owner::Health(request) => self
                .health
                .note_reply(request, firmware, self.master.reply())
                .map_or(BusEvent::Served, BusEvent::Health),
            Owner::Client => BusEvent::Client,
            Owner::Relay => BusEvent::Searching,
            Owner::SetUp(step) => {
                if self.state != State::Search(SearchStep::SetUp(step)) {
                    return BusEvent::Searching;
                }
                match self.setup.note_reply(step, firmware, data) {
                    Progress::Step(next, pause_us) => {
                        self.state = State::Search(SearchStep::SetUp(next));
                        self.next_us = self.now_us + pause_us;
                        BusEvent::Searching
                    }
                    Progress::Done(goal) => self.finish_set_up(goal),
                    Progress::Refused(joint) => {
                        self.search_again();
                        BusEvent::Unprepared(joint)
                    }
                    Progress::Silent(joint) => self.absent(joint, Missing::Silence),
                }
            }
        }
    }

    fn finish_set_up(&mut self, goal: SetupGoal) -> BusEvent {
        match goal {
            SetupGoal::Read => self.line_up(),
            SetupGoal::Prepare => {
                self.master.set_prepared(Some(self.setup.mode()));
                self.line_up()
            }
            SetupGoal::Restore => {
                self.setup.clear();
                self.state = State::Passthrough;
                BusEvent::Restored
            }
        }
    }
}

fn first_missing(samples: [Sample; JOINTS], servos: usize) -> Option<(usize, Missing)> {
    samples
        .into_iter()
        .enumerate()
        .take(servos)
        .find_map(|(joint, sample)| match sample {
            Sample::Missing(missing) => Some((joint, missing)),
            Sample::Counts(_) => None,
        })
}
