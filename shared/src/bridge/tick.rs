//! What a tick decides, and what it tells.

use embedded_hal::digital::OutputPin;
use embedded_hal_nb::serial::{Read, Write};
use nalgebra::Vector2;

use super::Bridge;
use super::guard::{Seen, Violation};
use super::law::Decision;
use crate::actuator::Pwm;
use crate::arm::State;
use crate::control::Reference;
use crate::link::message::{Drive, Fault, Guards, Sample};
use crate::servo::port::SetBaud;

impl<S, D> Bridge<'_, S, D>
where
    S: Read<u8> + Write<u8> + SetBaud,
    D: OutputPin,
{
    /// Estimates, controls and supervises: everything that is decided in a
    /// tick. Bracket it with a stopwatch for [`Bridge::publish`].
    pub fn decide(&mut self) {
        // A stop that is ordered below does not wait until then; what is asked of
        // the arm then is told all the same.
        let acts_us = self.next_start_us;
        self.watch_host();
        let counts = self.record.samples.map(Sample::counts);
        let measured = self.law.angles(counts);
        let is_fresh = self.is_fresh;
        if let ([Some(a), Some(b)], true) = (measured, is_fresh) {
            self.law.reset([a, b]);
            self.is_fresh = false;
        }
        let predicted_rad = self.law.prior().q.into();
        let believed = if self.state.is_armed() && !is_fresh {
            self.guard.believe(measured, predicted_rad)
        } else {
            measured
        };
        self.note_samples(believed);
        let state = self.law.correct(believed);
        self.judge_tick(&Seen {
            counts,
            missing: self.record.samples.map(Sample::missing),
            measured_rad: measured,
            predicted_rad,
            is_fresh,
            state: &state,
            torque_nm: (self.in_force.torque_nm + self.in_force.friction_nm).into(),
            gravity_nm: self.law.gravity_nm(&state).into(),
            is_armed: self.state.is_armed(),
        });
        self.check_integrity();
        self.watch_halt();
        // What is decided now acts from the next samples on.
        let ahead = self.law.advance(&self.in_force);
        let mut reference = self.course.at(acts_us);
        if self.is_experimenting() {
            self.conduct(&state, &ahead, acts_us, &mut reference);
        }
        let mut guards = Guards::NONE;
        self.next = if self.state.is_driven() {
            self.control(&ahead, &reference, &mut guards)
                .unwrap_or_else(|violation| {
                    self.trip(violation);
                    Decision::off()
                })
        } else {
            Decision::off()
        };
        let mode = self.mode();
        let record = &mut self.record;
        record.mode = mode;
        record.guards = guards;
        record.pwm_next = self.next.pwm.map(Pwm::counts);
        record.reference_rad = reference.q.into();
        record.reference_speed_rad_s = reference.dq.into();
        record.angle_rad = state.q.into();
        record.speed_rad_s = state.dq.into();
        record.torque_nm = self.next.torque_nm.into();
        record.disturbance_nm = self.law.disturbance_nm();
        self.decided = record.tick;
    }

    /// What drives the motors from the next tick on, within all limits.
    fn control(
        &mut self,
        ahead: &State<f32>,
        reference: &Reference<f32>,
        guards: &mut Guards,
    ) -> Result<Decision, Violation> {
        let (mut wanted_nm, mut friction_nm) = match self.drive {
            Drive::Torque => (self.torque_nm.into(), Vector2::zeros()),
            Drive::Regulate | Drive::Track | Drive::Hold | Drive::Experiment => {
                self.law.demand(ahead, reference)
            }
        };
        let exactly = (self.drive == Drive::Experiment)
            .then(|| self.run.ask(&self.law, &mut wanted_nm, &mut friction_nm));
        let before_nm = self.in_force.torque_nm + self.in_force.friction_nm;
        let shaped = self
            .guard
            .shape(self.law.arm(), ahead, wanted_nm, before_nm)?;
        let pwm_max = self.guard.limits().pwm_counts;
        let commands = match exactly {
            None => self.law.commands(shaped.torque_nm, friction_nm, pwm_max),
            Some(exactly) => {
                self.law
                    .commands_exactly(exactly, shaped.torque_nm, friction_nm, pwm_max)
            }
        };
        let (decision, is_limited) = commands.ok_or(Violation::plain(Fault::NotFinite))?;
        *guards = shaped.guards;
        if is_limited {
            *guards = guards.or(Guards::PWM);
        }
        self.guard.pwm(is_limited)?;
        Ok(decision)
    }

    /// Publishes the tick's record. True if the tick began and ended in time:
    /// feed the watchdog then.
    pub fn publish(&mut self, compute_ns: u32) -> bool {
        self.record.timing.compute_ns = compute_ns;
        if self.end.records.enqueue(self.record).is_err() {
            self.record.dropped = self.record.dropped.wrapping_add(1);
        }
        self.overruns_in_row == 0
    }
}
