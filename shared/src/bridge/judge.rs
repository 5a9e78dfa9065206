//! What is in doubt, and what follows: every path here ends in torque off.

use crate::servo::port::SetBaud;
use embedded_hal::digital::OutputPin;
use embedded_hal_nb::serial::{Read, Write};

use super::Bridge;
use super::course::Course;
use super::guard::{Seen, Violation};
use super::halt::Halting;
use super::law::Decision;
use super::mailbox::Notice;
use super::schedule::Stage;
use super::supervisor::{self, Action, Event, State};
use crate::JOINTS;
use crate::link::message::{Drive, Fault, Refusal, Sample, StopSource, Trip};
use crate::servo::master::Transaction;
use crate::servo::protocol1::Alarms;
use nalgebra::Vector2;

/// Alarms upon which a stock servo, as it comes, lets go of its shaft.
const SHUTDOWN: Alarms = Alarms::OVERHEATING.or(Alarms::OVERLOAD);

/// Ticks without an answer after which a servo is taken for deaf.
const SILENT_TICKS: u32 = 3;
/// It is switched off twice in 20 ms at 1 kHz, whichever it is, and else the ticks
/// say off to both.
const QUELL_TICKS: u32 = 4;

impl<S, D> Bridge<'_, S, D>
where
    S: Read<u8> + Write<u8> + SetBaud,
    D: OutputPin,
{
    /// The host has been silent for how long: hold, then let go.
    pub(super) fn watch_host(&mut self) {
        if !self.state.is_armed() {
            return;
        }
        let silent_us = self.now_us.saturating_sub(self.heard_us);
        let allowed_us = |ms: u16| u64::from(ms) * 1_000;
        if silent_us > allowed_us(self.guard.limits().silence_ms) {
            self.trip(Violation {
                value: silent_us as f32 * 1e-6,
                limit: f32::from(self.guard.limits().silence_ms) * 1e-3,
                ..Violation::plain(Fault::HostSilent)
            });
        } else if silent_us > allowed_us(self.guard.limits().hold_ms) && self.state.is_driven() {
            let event = match self.drive {
                // They hold already.
                Drive::Regulate | Drive::Hold => return,
                Drive::Track => Event::Brake,
                Drive::Torque => Event::Slacken,
                // It ends when this tick's samples have been looked at.
                Drive::Experiment => return self.run.note_quiet(),
            };
            // Never refused.
            let _ = self.apply(event);
        }
    }

    /// Whether a sample is missing, or not believed, shows in the mode.
    pub(super) fn note_samples(&mut self, believed: [Option<f32>; JOINTS]) {
        let event = if believed.iter().all(Option::is_some) {
            Event::SamplesBack
        } else {
            Event::SampleLost
        };
        // Never refused.
        let _ = self.apply(event);
    }

    /// Judges what the tick brought.
    pub(super) fn judge_tick(&mut self, seen: &Seen<'_>) {
        // The last tick before bring-up: its servos are being looked for again.
        if self.state == State::Boot {
            return;
        }
        if let Err(violation) = self.guard.judge(seen) {
            self.trip(violation);
        }
        let alarms = self.record.alarms.map(Alarms::from_bits);
        let letting_go = alarms
            .iter()
            .position(|alarms| !alarms.and(SHUTDOWN).is_empty());
        if let (Some(joint), true) = (letting_go, self.state.is_armed()) {
            self.trip(Violation {
                joint: Some(joint as u8),
                ..Violation::plain(Fault::ServoAlarm)
            });
        }
    }

    /// After a fault: are the servos seen to stand?
    pub(super) fn watch_halt(&mut self) {
        let Some(halting) = self.halting.as_mut() else {
            return;
        };
        let counts = self.record.samples.map(Sample::counts);
        let verdict = halting.watch(self.now_us, counts);
        if verdict.stop_again {
            self.stop_due = true;
            self.next_start_us = self.now_us;
        }
        if let Some(halt) = verdict.report {
            let _ = self.end.notices.enqueue(Notice::Halted(halt));
        }
    }

    /// After a fault, a servo that says nothing may hear nothing either, but for one
    /// kind of packet: that, in two ticks of [`QUELL_TICKS`] a servo.
    pub(super) fn quell(&self) -> Option<Transaction> {
        if self.state != State::Fault {
            return None;
        }
        let tick = self.record.tick % (QUELL_TICKS * JOINTS as u32);
        let joint = (tick / QUELL_TICKS) as usize;
        let (silent, _) = self.guard.lost_in_row(joint);
        let aside = match tick % QUELL_TICKS {
            0 => true,
            1 => false,
            _ => return None,
        };
        (silent > SILENT_TICKS).then_some(Transaction::Quell { joint, aside })
    }

    /// Emergency stop: the stop sequence begins when the exchange under way is over,
    /// within a tick.
    pub fn emergency_stop(&mut self, source: StopSource) {
        self.trip(Violation::plain(Fault::EmergencyStop(source)));
    }

    /// Torque off, latched with its first cause. The stop sequence follows at once
    /// on the bus.
    pub(super) fn trip(&mut self, violation: Violation) {
        if self.state == State::Fault {
            return;
        }
        let Violation {
            fault,
            joint,
            value,
            limit,
        } = self.cause(violation);
        self.trip = Some(Trip {
            fault,
            joint,
            tick: self.record.tick,
            at_us: self.now_us,
            value,
            limit,
        });
        // Never refused.
        let _ = self.apply(Event::Tripped);
        self.report_trip();
    }

    /// Tells the host why, if there is a fault.
    pub(super) fn report_trip(&mut self) {
        if let (State::Fault, Some(trip)) = (self.state, self.trip) {
            let _ = self.end.notices.enqueue(Notice::Tripped(trip));
        }
    }

    /// Changes the state as the supervisor has it.
    pub(super) fn apply(&mut self, event: Event) -> Result<(), Refusal> {
        let before = self.state;
        let (state, action) = supervisor::next(before, event)?;
        self.state = state;
        if before == State::Passthrough && state != before {
            self.end_relay();
        }
        if before == State::Fault && state != before {
            self.halting = None;
            self.trip = None;
        }
        match action {
            Action::Keep => {}
            Action::SwitchOff => self.next = Decision::off(),
            Action::Energise => {
                self.next = Decision::off();
                self.guard.restart();
                self.begin_anew();
            }
            Action::Hold => {
                self.drive = Drive::Hold;
                self.course.brake(self.next_start_us);
            }
            Action::Halt => {
                self.next = Decision::off();
                self.stop_due = true;
                self.halting = Some(Halting::begin(self.now_us));
                // The stop does not wait for the next tick.
                self.next_start_us = self.now_us;
            }
            Action::Search => self.search(Stage::Stop),
            // What a client has set moving hears it at that client's speed.
            Action::SearchHere => self.search(Stage::StopHere),
            Action::HandOver => {
                self.stage = Stage::Released;
                // The client finds every motor off.
                self.stop_due = true;
                self.next_start_us = self.now_us;
                self.announce();
            }
        }
        Ok(())
    }

    fn search(&mut self, from: Stage) {
        self.search.rewind();
        self.stage = from;
        self.next_start_us = self.now_us;
    }

    /// What is known of the arm, and what was asked of it, counts no more: with
    /// torque off it did what the estimator's model did not see.
    pub(super) fn begin_anew(&mut self) {
        self.is_fresh = true;
        self.course = Course::hold(Vector2::zeros());
    }

    /// Rest where the arm is.
    pub(super) fn hold_here(&self) -> Course {
        Course::hold(self.record.angle_rad.into())
    }
}
