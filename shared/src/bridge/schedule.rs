//! What the bus is used for, and when: bring-up, then one exchange a tick.

use embedded_hal::digital::OutputPin;
use embedded_hal_nb::serial::{Read, Write};

use super::law::Decision;
use super::mailbox::Notice;
use super::supervisor::{Event, torque_is_on};
use super::{Bridge, Progress, limits};
use crate::JOINTS;
use crate::actuator::Pwm;
use crate::link::message::{Fault, Missing, Sample, Timing};
use crate::servo::master::{Outcome, Transaction};

/// Rest between two attempts to find the servos.
const SEARCH_PAUSE_US: u64 = 50_000;

/// What the bus is used for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Stage {
    /// The stop sequence, then bring-up.
    Stop,
    /// Is this joint's servo there?
    Ping(usize),
    /// Lining the servos up.
    Start,
    /// One exchange a tick.
    Ticking,
}

impl<S, D> Bridge<'_, S, D>
where
    S: Read<u8> + Write<u8>,
    D: OutputPin,
{
    /// What the bus is used for next. A pause between attempts is over when
    /// this is called.
    pub(super) fn next_transaction(&mut self) -> Transaction {
        if core::mem::take(&mut self.stop_due) {
            return Transaction::Stop;
        }
        match self.stage {
            Stage::Stop => Transaction::Stop,
            Stage::Ping(joint) => Transaction::Ping { joint },
            Stage::Start => Transaction::Start,
            Stage::Ticking => {
                self.begin_tick();
                Transaction::Drive(self.in_force.pwm)
            }
        }
    }

    /// A transaction is over: what does it mean?
    pub(super) fn finish(&mut self, outcome: &Outcome) -> Progress {
        match (outcome.transaction, self.stage) {
            (Transaction::Drive(_), _) => {
                self.record.samples = outcome.samples;
                self.record.timing.bus_us = outcome.bus_us;
                return Progress::Sampled;
            }
            (Transaction::Stop, Stage::Stop) => self.stage = Stage::Ping(0),
            // A fault's stop: ticks go on with torque off, from now.
            (Transaction::Stop, _) => self.next_start_us = self.now_us,
            (Transaction::Ping { joint }, _) => match outcome.samples.get(joint) {
                Some(Sample::Missing(missing)) => self.report_absent(joint, *missing),
                Some(Sample::Counts(_)) if joint + 1 < JOINTS => {
                    self.stage = Stage::Ping(joint + 1);
                }
                _ => self.stage = Stage::Start,
            },
            (Transaction::Start, _) => match first_missing(outcome.samples) {
                Some((joint, missing)) => self.report_absent(joint, missing),
                None => self.begin_ticking(),
            },
        }
        Progress::Searching
    }

    pub(super) fn report_absent(&mut self, joint: usize, missing: Missing) {
        // A full queue means that the host knows already.
        let _ = self
            .end
            .notices
            .enqueue(Notice::Absent(joint as u8, missing));
        self.stage = Stage::Ping(0);
        self.next_start_us = self.now_us + SEARCH_PAUSE_US;
    }

    pub(super) fn begin_ticking(&mut self) {
        self.stage = Stage::Ticking;
        self.next_start_us = self.now_us;
        self.lost_in_row = [0; JOINTS];
        self.overruns_in_row = 0;
        self.is_fresh = true;
        // Never refused.
        let _ = self.apply(Event::BusReady);
    }

    /// Puts the decided PWM in force and keeps the schedule.
    pub(super) fn begin_tick(&mut self) {
        let period_us = self.law.period_us();
        let late_us = self.now_us.saturating_sub(self.next_start_us);
        let missed = late_us / period_us;
        self.next_start_us += (missed + 1) * period_us.get();
        if missed > 0 && torque_is_on(self.mode) {
            self.overruns_in_row = self.overruns_in_row.saturating_add(1);
            if self.overruns_in_row >= limits::OVERRUNS {
                self.trip(Fault::Overrun);
            }
        } else {
            self.overruns_in_row = 0;
        }
        if !torque_is_on(self.mode) {
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
