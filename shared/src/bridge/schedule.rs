//! What the bus is used for, and when: bring-up, then one exchange a tick.

use crate::servo::port::SetBaud;
use core::num::NonZeroU64;
use embedded_hal::digital::OutputPin;
use embedded_hal_nb::serial::{Read, Write};

use super::guard::Violation;
use super::law::Decision;
use super::mailbox::Notice;
use super::settle::Chore;
use super::supervisor::Event;
use super::{Bridge, Progress, limits};
use crate::JOINTS;
use crate::actuator::Pwm;
use crate::link::message::{Fault, Missing, Sample, Timing};
use crate::servo::Firmware;
use crate::servo::master::timing::tick_us;
use crate::servo::master::{Outcome, Transaction};
use crate::servo::port::BAUD_RATES;
use crate::servo::protocol1::Alarms;

/// Rest between two attempts to find the servos.
const SEARCH_PAUSE_US: u64 = 50_000;

/// How often a board whose bus is released looks whether all is well.
const LOOK_US: u64 = 10_000;

/// Morpheus first: the stop sequence has just been for it.
const FIRST_PING: Stage = Stage::Ping {
    joint: 0,
    firmware: Firmware::Morpheus,
};

/// What the bus is used for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Stage {
    /// The stop sequence at the speed that was in use, then [`Stage::Stop`].
    StopHere,
    /// The stop sequence at the speed of the search, then bring-up.
    Stop,
    /// Is this joint's servo there, and does it run this firmware?
    Ping { joint: usize, firmware: Firmware },
    /// Lining Morpheus servos up.
    Start,
    /// Making stock servos ready, or as they were.
    Settle(Chore),
    /// One exchange a tick.
    Ticking,
    /// Nothing: it is the client's of the transparent port.
    Released,
}

/// What has been found so far.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Search {
    /// Index of the baud rate at which servos are looked for.
    rate: usize,
    found: [Option<Firmware>; JOINTS],
    /// What was heard instead of those that are missing.
    heard: [Option<Missing>; JOINTS],
}

impl Search {
    /// From the likeliest speed on.
    pub(super) fn rewind(&mut self) {
        self.rate = 0;
    }
}

impl<S, D> Bridge<'_, S, D>
where
    S: Read<u8> + Write<u8> + SetBaud,
    D: OutputPin,
{
    /// Begins what the bus is used for next. A pause between attempts is over
    /// when this is called.
    pub(super) fn begin_next(&mut self) {
        self.is_chore_asked = false;
        let transaction = match self.stage {
            _ if core::mem::take(&mut self.stop_due) => {
                // Stock servos let go of their shafts.
                self.master.set_prepared(false);
                Transaction::Stop
            }
            Stage::StopHere => Transaction::Stop,
            Stage::Stop => {
                self.master.set_prepared(false);
                self.search.found = [None; JOINTS];
                self.search.heard = [None; JOINTS];
                self.speak(Firmware::Morpheus);
                Transaction::Stop
            }
            Stage::Ping { joint, firmware } => {
                self.speak(firmware);
                Transaction::Ping { joint }
            }
            Stage::Start => Transaction::Start,
            Stage::Settle(chore) => return self.do_chore(chore),
            Stage::Ticking => {
                self.begin_tick();
                self.quell()
                    .unwrap_or(Transaction::Drive(self.in_force.pwm))
            }
            Stage::Released => {
                self.next_start_us = self.now_us + LOOK_US;
                return;
            }
        };
        // Idle was just seen: it is not busy.
        let _ = self.master.begin(transaction, self.now_us);
    }

    /// At the speed of the search.
    fn speak(&mut self, firmware: Firmware) {
        let baud = BAUD_RATES.get(self.search.rate).copied();
        // Idle was just seen: it is not busy.
        let _ = self
            .master
            .set_line(firmware, baud.unwrap_or(self.master.baud()));
    }

    /// A transaction is over: what does it mean?
    pub(super) fn finish(&mut self, outcome: &Outcome) -> Progress {
        match (outcome.transaction, self.stage) {
            // The bus was released meanwhile: whatever came is nobody's.
            (_, Stage::Released) => {}
            (Transaction::Drive(_) | Transaction::HoldOff | Transaction::Quell { .. }, _) => {
                self.record.samples = outcome.samples;
                self.record.alarms = outcome.alarms.map(Alarms::bits);
                self.record.timing.bus_us = outcome.bus_us;
                return Progress::Sampled;
            }
            (Transaction::Ask(_), Stage::Settle(chore)) if self.is_chore_asked => {
                self.finish_chore(chore);
            }
            (Transaction::Ask(_), _) => {
                if !self.finish_care() {
                    self.finish_client();
                }
                return Progress::Served;
            }
            (Transaction::Stop, Stage::StopHere) => self.stage = Stage::Stop,
            (Transaction::Stop, Stage::Stop) => self.stage = FIRST_PING,
            // A fault's stop: ticks go on with torque off, from now.
            (Transaction::Stop | Transaction::BriefStop, _) => self.next_start_us = self.now_us,
            (Transaction::Ping { joint }, Stage::Ping { firmware, .. }) => {
                self.pinged(joint, firmware, outcome.samples.get(joint).copied());
            }
            // The stage has changed since.
            (Transaction::Ping { .. }, _) => {}
            (Transaction::Start, _) => match first_missing(outcome.samples) {
                Some((joint, missing)) => self.report_absent(joint, missing),
                None => self.begin_ticking(),
            },
        }
        Progress::Searching
    }

    fn pinged(&mut self, joint: usize, firmware: Firmware, sample: Option<Sample>) {
        let Search { found, heard, .. } = &mut self.search;
        let is_found = match sample {
            Some(Sample::Counts(_)) => {
                if let Some(slot) = found.get_mut(joint) {
                    *slot = Some(firmware);
                }
                true
            }
            Some(Sample::Missing(missing)) => {
                // What is not just silence says more.
                let says_more = !matches!(missing, Missing::Silence | Missing::EchoOnly);
                if let Some(slot) = heard.get_mut(joint)
                    && (slot.is_none() || says_more)
                {
                    *slot = Some(missing);
                }
                false
            }
            None => false,
        };
        self.stage = match firmware {
            Firmware::Morpheus if !is_found => Stage::Ping {
                joint,
                firmware: Firmware::Stock,
            },
            Firmware::Morpheus | Firmware::Stock if joint + 1 < JOINTS => Stage::Ping {
                joint: joint + 1,
                firmware: Firmware::Morpheus,
            },
            Firmware::Morpheus | Firmware::Stock => return self.all_pinged(),
        };
    }

    /// Every servo has been asked at this speed.
    fn all_pinged(&mut self) {
        let Search { rate, found, heard } = self.search;
        let absent = found.iter().position(Option::is_none);
        match (found, absent) {
            ([Some(a), Some(b)], _) if a == b => {
                if self.firmware.replace(a).is_some_and(|before| before != a) {
                    self.trip(Violation::plain(Fault::FirmwareChanged));
                }
                self.speak(a);
                self.stage = match a {
                    Firmware::Morpheus => Stage::Start,
                    Firmware::Stock => Stage::Settle(Chore::LOOK),
                };
            }
            ([Some(a), Some(b)], _) => {
                let _ = self.end.notices.enqueue(Notice::Mixed([a, b]));
                self.search_again();
            }
            // Nobody at this speed: the next.
            ([None, None], _) if rate + 1 < BAUD_RATES.len() => {
                self.search.rate = rate + 1;
                self.stage = Stage::Stop;
            }
            (_, absent) => {
                if found == [None; JOINTS] {
                    self.search.rate = 0;
                }
                let joint = absent.unwrap_or(0);
                let missing = heard.get(joint).copied().flatten();
                self.report_absent(joint, missing.unwrap_or(Missing::Silence));
            }
        }
    }

    pub(super) fn report_absent(&mut self, joint: usize, missing: Missing) {
        // A full queue means that the host knows already.
        let _ = self
            .end
            .notices
            .enqueue(Notice::Absent(joint as u8, missing));
        self.search_again();
    }

    /// From the beginning, after a pause.
    pub(super) fn search_again(&mut self) {
        self.stage = Stage::Stop;
        self.next_start_us = self.now_us + SEARCH_PAUSE_US;
    }

    pub(super) fn begin_ticking(&mut self) {
        self.stage = Stage::Ticking;
        self.next_start_us = self.now_us;
        self.guard.restart();
        self.begin_anew();
        self.care.restart(self.now_us);
        self.overruns_in_row = 0;
        self.announce();
        // Never refused.
        let _ = self.apply(Event::BusReady);
    }

    /// Tells the host what the servos are.
    pub(super) fn announce(&mut self) {
        let notice = match self.stage {
            Stage::Ticking => {
                let master = &self.master;
                Notice::Found(master.firmware(), master.baud(), master.is_prepared())
            }
            Stage::Released => Notice::Passthrough,
            Stage::StopHere
            | Stage::Stop
            | Stage::Ping { .. }
            | Stage::Start
            | Stage::Settle(_) => return,
        };
        let _ = self.end.notices.enqueue(notice);
    }

    /// Shortest period in µs that the bus allows.
    pub(super) fn least_period_us(&self) -> u32 {
        tick_us(
            self.master.firmware(),
            self.master.baud(),
            self.master.is_prepared(),
        )
    }

    /// Puts the decided PWM in force and keeps the schedule.
    pub(super) fn begin_tick(&mut self) {
        // A bus that is too slow for the period is read as fast as it goes; no
        // torque comes on then.
        let least_us = u64::from(self.least_period_us());
        let period_us = NonZeroU64::new(least_us).map_or(self.law.period_us(), |least| {
            least.max(self.law.period_us())
        });
        // A client that waits gets what would be margin.
        let available_us = if self.gateway.is_waiting() {
            least_us
        } else {
            period_us.get()
        };
        self.master.set_available(available_us as u32);
        let late_us = self.now_us.saturating_sub(self.next_start_us);
        let missed = late_us / period_us;
        self.next_start_us += (missed + 1) * period_us.get();
        if missed > 0 && self.state.is_armed() {
            self.overruns_in_row = self.overruns_in_row.saturating_add(1);
            if self.overruns_in_row >= self.guard.limits().overruns || late_us > limits::LATE_MAX_US
            {
                self.trip(Violation {
                    value: late_us as f32 * 1e-6,
                    limit: period_us.get() as f32 * 1e-6,
                    ..Violation::plain(Fault::Overrun)
                });
            }
        } else {
            self.overruns_in_row = 0;
        }
        if !self.state.is_driven() {
            self.next = Decision::off();
        }
        self.in_force = self.next;
        let record = &mut self.record;
        record.tick = record.tick.wrapping_add(1);
        record.start_us = self.now_us;
        record.pwm_in_force = self.in_force.pwm.map(Pwm::counts);
        record.timing = Timing {
            start_error_us: late_us as u32,
            missed: record.timing.missed.wrapping_add(missed as u32),
            ..Timing::default()
        };
    }
}

fn first_missing(samples: [Sample; JOINTS]) -> Option<(usize, Missing)> {
    samples
        .into_iter()
        .enumerate()
        .find_map(|(joint, sample)| match sample {
            Sample::Missing(missing) => Some((joint, missing)),
            Sample::Counts(_) => None,
        })
}
