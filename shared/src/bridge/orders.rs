//! What the host wants.

use crate::servo::port::SetBaud;
use embedded_hal::digital::OutputPin;
use embedded_hal_nb::serial::{Read, Write};

use super::Bridge;
use super::course::{Course, Departure};
use super::law::{Decision, Law};
use super::mailbox::{Notice, Order, Task};
use super::schedule::Stage;
use super::settle::Chore;
use super::supervisor::{self, Event, Request, torque_is_on};
use crate::link::message::{Mode, Refusal};
use crate::servo::Firmware;

impl<S, D> Bridge<'_, S, D>
where
    S: Read<u8> + Write<u8> + SetBaud,
    D: OutputPin,
{
    pub(super) fn take_orders(&mut self) {
        while let Some(order) = self.end.orders.dequeue() {
            self.heard_us = self.now_us;
            if matches!(order, Order::Greeted) {
                self.announce();
            }
            if let Order::Do(sequence, task) = order {
                self.gateway.claim(self.now_us);
                let notice = if matches!(task, Task::Depart) {
                    self.departure().map_or_else(
                        |refusal| Notice::Ack(sequence, Err(refusal)),
                        |departure| Notice::Departure(sequence, departure),
                    )
                } else {
                    Notice::Ack(sequence, self.perform(task))
                };
                // Lost if the host does not fetch them: it will ask again.
                let _ = self.end.notices.enqueue(notice);
            }
        }
    }

    /// Torque comes on: not faster than the bus allows.
    fn allow(&mut self, request: Request) -> Result<(), Refusal> {
        supervisor::next(self.mode, Event::Asked(request))?;
        if !self.master.is_prepared() {
            return Err(Refusal::Unprepared);
        }
        let least_us = self.least_period_us();
        if self.law.period_us().get() < u64::from(least_us) {
            return Err(Refusal::TooFast { least_us });
        }
        Ok(())
    }

    /// Replaces the set-up, without a step in the torque if that is on.
    fn install(&mut self, mut law: Law) -> Result<(), Refusal> {
        self.apply(Event::Asked(Request::Configure))?;
        if torque_is_on(self.mode) {
            if law.period_us() != self.law.period_us() {
                return Err(Refusal::NotIdle);
            }
            let reference = self.course.at(self.next_start_us);
            law.take_over(&self.law, &reference);
        } else {
            self.is_fresh = true;
        }
        self.law = law;
        Ok(())
    }

    /// Makes the arm follow a course, from a constant torque without a step.
    fn follow(&mut self, request: Request, course: Course) -> Result<(), Refusal> {
        let before = self.mode;
        self.course = course;
        self.apply(Event::Asked(request))?;
        if before == Mode::Torque {
            let reference = self.course.at(self.next_start_us);
            let Decision {
                torque_nm,
                friction_nm,
                ..
            } = self.next;
            self.law.fade_from(torque_nm + friction_nm, &reference);
        }
        Ok(())
    }

    fn departure(&self) -> Result<Departure, Refusal> {
        supervisor::next(self.mode, Event::Asked(Request::Track))?;
        Ok(self.present_course().departure(self.now_us))
    }

    /// The course, or, if the arm follows none, rest where it is.
    fn present_course(&self) -> Course {
        match self.mode {
            Mode::Regulate | Mode::Track => self.course.clone(),
            Mode::BringUp | Mode::Idle | Mode::Torque | Mode::Passthrough | Mode::Fault(_) => {
                Course::hold(self.record.angle_rad.into())
            }
        }
    }

    pub(super) fn perform(&mut self, task: Task) -> Result<(), Refusal> {
        match task {
            Task::Idle => self.apply(Event::Asked(Request::Idle)),
            Task::ClearFault => self.apply(Event::Asked(Request::ClearFault)),
            Task::Torque(torque_nm) => {
                self.allow(Request::Torque)?;
                self.apply(Event::Asked(Request::Torque))?;
                self.torque_nm = torque_nm;
                Ok(())
            }
            Task::Regulate(reference_rad) => {
                self.allow(Request::Regulate)?;
                let course = Course::hold(reference_rad.into());
                self.follow(Request::Regulate, course)
            }
            Task::Depart => Ok(()),
            Task::Follow(leg) => {
                self.allow(Request::Track)?;
                let mut course = self.present_course();
                course.change_to(leg, self.now_us)?;
                self.follow(Request::Track, course)
            }
            Task::Stream(point) => {
                self.allow(Request::Track)?;
                let mut course = self.present_course();
                course.push(self.now_us, point)?;
                self.follow(Request::Track, course)
            }
            Task::Prepare if self.master.is_prepared() => {
                supervisor::next(self.mode, Event::Asked(Request::Prepare)).map(|_| ())
            }
            Task::Prepare => {
                self.apply(Event::Asked(Request::Prepare))?;
                self.stage = Stage::Settle(Chore::PREPARE);
                Ok(())
            }
            Task::Release => {
                self.apply(Event::Asked(Request::Release))?;
                if self.master.firmware() == Firmware::Stock {
                    self.stage = Stage::Settle(Chore::RESTORE);
                }
                Ok(())
            }
            Task::Install(law) => self.install(law),
        }
    }
}
