//! What is in doubt, and what follows: every path here ends in torque off.

use crate::servo::port::SetBaud;
use embedded_hal::digital::OutputPin;
use embedded_hal_nb::serial::{Read, Write};

use super::law::Decision;
use super::schedule::Stage;
use super::supervisor::{self, Event, torque_is_on};
use super::{Bridge, limits};
use crate::JOINTS;
use crate::arm::State;
use crate::link::message::{Fault, Mode, Refusal};
use crate::servo::protocol1::Alarms;

/// Alarms upon which a stock servo, as it comes, lets go of its shaft.
const SHUTDOWN: Alarms = Alarms::OVERHEATING.or(Alarms::OVERLOAD);

impl<S, D> Bridge<'_, S, D>
where
    S: Read<u8> + Write<u8> + SetBaud,
    D: OutputPin,
{
    pub(super) fn count_lost(&mut self, measured: &[Option<f32>; JOINTS]) {
        for (lost, angle) in self.lost_in_row.iter_mut().zip(measured) {
            *lost = if angle.is_some() {
                0
            } else {
                lost.saturating_add(1)
            };
        }
        let period_us = self.law.period_us().get() as u32;
        let too_many = limits::lost_samples(period_us);
        if self
            .lost_in_row
            .iter()
            .any(|lost| u32::from(*lost) >= too_many)
        {
            self.trip(Fault::SamplesLost);
        }
    }

    pub(super) fn supervise(&mut self) {
        let silent_us = self.now_us.saturating_sub(self.heard_us);
        if torque_is_on(self.mode) && silent_us > limits::HOST_SILENCE_US {
            self.trip(Fault::HostSilent);
        }
    }

    /// Judges the state while torque is on.
    pub(super) fn check(&mut self, state: &State<f32>) {
        if !torque_is_on(self.mode) {
            return;
        }
        let is_finite = state.q.iter().chain(&state.dq).all(|x| x.is_finite());
        let alarms = self.record.alarms.map(Alarms::from_bits);
        if alarms.iter().any(|alarms| !alarms.and(SHUTDOWN).is_empty()) {
            self.trip(Fault::ServoAlarm);
        } else if !is_finite {
            self.trip(Fault::NotFinite);
        } else if state.q.iter().any(|q| q.abs() > limits::ANGLE_MAX_RAD) {
            self.trip(Fault::AngleLimit);
        }
    }

    /// Torque off, latched. The stop sequence follows at once on the bus.
    pub(super) fn trip(&mut self, fault: Fault) {
        // Never refused.
        let _ = self.apply(Event::Tripped(fault));
    }

    /// Changes the mode as the supervisor has it.
    pub(super) fn apply(&mut self, event: Event) -> Result<(), Refusal> {
        let before = self.mode;
        self.mode = supervisor::next(before, event)?;
        if self.mode == before {
            return Ok(());
        }
        if before == Mode::Passthrough {
            self.end_relay();
        }
        match self.mode {
            Mode::Fault(_) => {
                self.next = Decision::off();
                self.stop_due = true;
                // The stop does not wait for the next tick.
                self.next_start_us = self.now_us;
            }
            Mode::BringUp => {
                self.search.rewind();
                // What a client has set moving hears it at that client's speed.
                self.stage = if before == Mode::Passthrough {
                    Stage::StopHere
                } else {
                    Stage::Stop
                };
                self.next_start_us = self.now_us;
            }
            // Whatever the arm did with torque off, the estimator's model did
            // not see it: begin at rest where the arm is.
            Mode::Torque | Mode::Regulate | Mode::Track => self.is_fresh |= !torque_is_on(before),
            Mode::Passthrough => {
                self.stage = Stage::Released;
                // The client finds every motor off.
                self.stop_due = true;
                self.next_start_us = self.now_us;
                self.announce();
            }
            Mode::Idle => {}
        }
        Ok(())
    }
}
