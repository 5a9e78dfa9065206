//! An experiment, tick by tick: what each joint is given, and when it is over.
//!
//! ```text
//! permit -> begin -> tick: in the envelope? -> reference, PWM, torque -> guard -> ...
//!                               | no, or time over, or the host is quiet
//!                               +-> Event::Brake: braked to rest, and held
//! ```
//!
//! Time is that of the planned beginnings of ticks, from the first on that acts by the
//! experiment's word, so a tick that was skipped is not made up for.
//!
//! A joint that the controller does not keep has no reference: it is told to be where
//! the arm will be anyway, so that the controller of the other joint sees no error in
//! it, and the record shows no difference between reference and angle.

mod permit;

pub use permit::permits;

use embedded_hal::digital::OutputPin;
use embedded_hal_nb::serial::{Read, Write};
use nalgebra::Vector2;

use super::Bridge;
use super::course::Course;
use super::guard::InRow;
use super::law::Law;
use super::mailbox::Notice;
use super::supervisor::{self, Event};
use crate::JOINTS;
use crate::actuator::Pwm;
use crate::arm::State;
use crate::control::Reference;
use crate::experiment::Signal;
use crate::link::experiment::{Conclusion, Experiment, ExperimentEnd, HELD_S, Role};
use crate::link::message::{Drive, Refusal};
use crate::servo::port::SetBaud;

/// An experiment under way, or the last that was.
#[derive(Clone, Debug)]
pub(super) struct Run {
    plan: Experiment,
    /// When its first tick begins to act; `None` until it is decided.
    starts_us: Option<u64>,
    /// Of the tick that is decided, in s since then.
    elapsed_s: f32,
    fast: [InRow; JOINTS],
    /// PWM in counts from off that held each joint, summed over so many ticks.
    held_counts: [f32; JOINTS],
    held_ticks: f32,
    /// The host has said nothing for too long.
    is_host_quiet: bool,
}

impl Default for Run {
    fn default() -> Self {
        Self::of(Experiment::NONE)
    }
}

impl Run {
    fn of(plan: Experiment) -> Self {
        Self {
            plan,
            starts_us: None,
            elapsed_s: 0.0,
            fast: Default::default(),
            held_counts: [0.0; JOINTS],
            held_ticks: 0.0,
            is_host_quiet: false,
        }
    }

    /// The host has said nothing for too long.
    pub(super) fn note_quiet(&mut self) {
        self.is_host_quiet = true;
    }

    fn pass_to(&mut self, acts_us: u64) {
        let starts_us = *self.starts_us.get_or_insert(acts_us);
        // Ten minutes in µs are 32 bits.
        let elapsed_us = u32::try_from(acts_us.saturating_sub(starts_us)).unwrap_or(u32::MAX);
        self.elapsed_s = elapsed_us as f32 * 1e-6;
    }

    /// Whether joints are still held before their PWM is frozen.
    fn is_freezing(&self) -> bool {
        self.elapsed_s < HELD_S
    }

    /// This PWM has been decided in the tick before.
    fn note_pwm(&mut self, pwm: [u16; JOINTS]) {
        if self.is_freezing() {
            for (sum, pwm) in self.held_counts.iter_mut().zip(pwm) {
                *sum += f32::from(pwm) - f32::from(Pwm::OFF.counts());
            }
            self.held_ticks += 1.0;
        }
    }

    /// Makes of what the controller would be asked for what it is, for an arm that will
    /// be at `ahead`.
    fn refer(&self, ahead: &State<f32>, reference: &mut Reference<f32>) {
        for (joint, role) in self.plan.roles.iter().enumerate() {
            match role {
                Role::Hold => {}
                Role::Bias(_) if self.is_freezing() => {}
                Role::Angle(signal) => {
                    let sample = signal.at(self.elapsed_s, self.plan.duration_s);
                    reference.q[joint] += sample.value;
                    reference.dq[joint] += sample.first;
                    reference.ddq[joint] += sample.second;
                }
                Role::Off | Role::Pwm(_) | Role::Bias(_) | Role::Torque(_) => {
                    reference.q[joint] = ahead.q[joint];
                    reference.dq[joint] = ahead.dq[joint];
                    reference.ddq[joint] = 0.0;
                }
            }
        }
    }

    /// Whether it is over, with the arm here.
    fn over(&mut self, state: &State<f32>, fast_ticks: u32) -> Option<ExperimentEnd> {
        let envelope = self.plan.angle_rad.into_iter().zip(self.plan.speed_rad_s);
        let states = state.q.iter().zip(state.dq.iter());
        let mut end = None;
        for (((joint, fast), ([low, high], most)), (q, dq)) in
            (0..).zip(&mut self.fast).zip(envelope).zip(states)
        {
            let is_fast = fast.note(dq.abs() > most, fast_ticks);
            if !(low..=high).contains(q) {
                let value_rad = *q;
                end = end.or(Some(ExperimentEnd::Angle { joint, value_rad }));
            } else if is_fast {
                let value_rad_s = *dq;
                end = end.or(Some(ExperimentEnd::Speed { joint, value_rad_s }));
            }
        }
        let is_finished = self.elapsed_s >= self.plan.duration_s;
        end.or(is_finished.then_some(ExperimentEnd::Finished))
            .or(self.is_host_quiet.then_some(ExperimentEnd::HostQuiet))
    }

    /// Makes of the controller's demand what drives the joints. A PWM is asked for as the
    /// torque that it stands for; the very PWM comes back.
    #[inline(never)]
    pub(super) fn ask(
        &self,
        law: &Law,
        torque_nm: &mut Vector2<f32>,
        friction_nm: &mut Vector2<f32>,
    ) -> [Option<Pwm>; JOINTS] {
        let mut exactly = [None; JOINTS];
        let joints = law.joints().iter().zip(&mut exactly).enumerate();
        for ((joint, (actuator, exactly)), role) in joints.zip(&self.plan.roles) {
            let sample = |signal: &Signal<f32>| signal.at(self.elapsed_s, self.plan.duration_s);
            let pwm = match role {
                Role::Hold | Role::Angle(_) => continue,
                Role::Torque(signal) => {
                    torque_nm[joint] = sample(signal).value;
                    friction_nm[joint] = 0.0;
                    continue;
                }
                Role::Pwm(signal) => Pwm::from_off(sample(signal).value),
                Role::Bias(_) if self.is_freezing() => continue,
                Role::Bias(signal) => {
                    let held = self.held_counts[joint] / self.held_ticks;
                    let since_s = self.elapsed_s - HELD_S;
                    Pwm::from_off(held + signal.at(since_s, self.plan.duration_s).value)
                }
                Role::Off => Pwm::OFF,
            };
            torque_nm[joint] = actuator.torque(pwm);
            friction_nm[joint] = 0.0;
            *exactly = Some(pwm);
        }
        exactly
    }
}

impl<S, D> Bridge<'_, S, D>
where
    S: Read<u8> + Write<u8> + SetBaud,
    D: OutputPin,
{
    /// Whether an experiment drives the motors.
    pub(super) fn is_experimenting(&self) -> bool {
        self.state.is_driven() && self.drive == Drive::Experiment
    }

    /// Begins an experiment with the next tick, from where the arm is. Out of line, like
    /// what follows: what is rare has its place in flash, and on the stack, once.
    #[inline(never)]
    pub(super) fn begin_experiment(&mut self, plan: Experiment) -> Result<(), Refusal> {
        supervisor::next(self.state, Event::Drive)?;
        if self.is_experimenting() && self.run.plan == plan {
            return Ok(());
        }
        let mut course = self.present_course();
        course.brake(self.next_start_us);
        let now = State {
            q: self.record.angle_rad.into(),
            dq: self.record.speed_rad_s.into(),
        };
        permit::from_here(&plan, &self.guard, &now, course.end()).map_err(Refusal::Experiment)?;
        self.follow(Drive::Experiment, course)?;
        self.run = Run::of(plan);
        Ok(())
    }

    /// Makes of the course's reference at `acts_us` what the experiment asks for, of an
    /// arm that will be at `ahead` then; or what the brake asks for that ends it because
    /// of where the arm is.
    #[inline(never)]
    pub(super) fn conduct(
        &mut self,
        state: &State<f32>,
        ahead: &State<f32>,
        acts_us: u64,
        reference: &mut Reference<f32>,
    ) {
        self.run.note_pwm(self.record.pwm_next);
        self.run.pass_to(acts_us);
        self.run.refer(ahead, reference);
        let fast_ticks = self.guard.fast_ticks();
        if let Some(end) = self.run.over(state, fast_ticks) {
            self.conclude(end);
            self.course = Course::braking(reference, acts_us);
            // Never refused: the motors are driven.
            let _ = self.apply(Event::Brake);
            *reference = self.course.at(acts_us);
        }
    }

    /// Something else is asked of the arm.
    pub(super) fn replace_experiment(&mut self) {
        if self.is_experimenting() {
            self.conclude(ExperimentEnd::Replaced);
        }
    }

    /// The course of an experiment under way, were it to end here.
    #[inline(never)]
    pub(super) fn course_of_experiment(&self) -> Course {
        if self.run.starts_us.is_none() {
            // Nothing has been decided by it.
            return self.course.clone();
        }
        let from = Reference {
            q: self.record.reference_rad.into(),
            dq: self.record.reference_speed_rad_s.into(),
            ddq: Vector2::zeros(),
        };
        Course::braking(&from, self.next_start_us)
    }

    fn conclude(&mut self, end: ExperimentEnd) {
        let tick = self.record.tick;
        let _ = self
            .end
            .notices
            .enqueue(Notice::Concluded(Conclusion { tick, end }));
    }
}
