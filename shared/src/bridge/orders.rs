//! What the host wants.

use crate::servo::port::SetBaud;
use embedded_hal::digital::OutputPin;
use embedded_hal_nb::serial::{Read, Write};

use super::Bridge;
use super::course::{Course, Departure};
use super::guard::Guard;
use super::law::{Decision, Law};
use super::mailbox::{Notice, Order, Task};
use super::schedule::Stage;
use super::settle::Chore;
use super::supervisor::{self, Event, State};
use crate::link::message::{Drive, Moment, Refusal};
use crate::servo::Firmware;

impl<S, D> Bridge<'_, S, D>
where
    S: Read<u8> + Write<u8> + SetBaud,
    D: OutputPin,
{
    pub(super) fn take_orders(&mut self) {
        if let Some(source) = self.end.take_emergency() {
            self.emergency_stop(source);
        }
        while let Some(order) = self.end.orders.dequeue() {
            match order {
                Order::Heartbeat => self.heard_us = self.now_us,
                Order::Greeted => self.greet(),
                Order::Goodbye => {
                    // Never refused.
                    let _ = self.apply(Event::Disarm);
                }
                Order::Do(sequence, task) => {
                    self.heard_us = self.now_us;
                    self.take_task(sequence, task);
                }
            }
        }
    }

    /// A host says hello.
    pub(super) fn greet(&mut self) {
        // What another host has armed is not for this one.
        if self.state.is_armed() {
            let _ = self.apply(Event::Disarm);
        }
        // What was before is in no log of this host.
        self.begin_anew();
        // After a fault the guard knows which servo may be deaf.
        if self.state != State::Fault {
            self.guard.restart();
        }
        let _ = self.end.notices.enqueue(Notice::Began(self.moment()));
        self.announce();
        self.report_trip();
    }

    fn take_task(&mut self, sequence: u16, task: Task) {
        self.gateway.claim(self.now_us);
        let moment = self.moment();
        let notice = if matches!(task, Task::Depart) {
            self.departure().map_or_else(
                |refusal| Notice::Ack(sequence, Err(refusal), moment),
                |departure| Notice::Departure(sequence, departure, moment),
            )
        } else {
            Notice::Ack(sequence, self.perform(task), moment)
        };
        // Lost if the host does not fetch them: it will ask again.
        let _ = self.end.notices.enqueue(notice);
    }

    /// Now, as an order is told it.
    fn moment(&self) -> Moment {
        Moment {
            tick: self.record.tick,
            is_decided: self.decided == self.record.tick,
            at_us: self.now_us,
        }
    }

    /// The servos can be given torque as often as the set-up wants.
    fn check_bus(&self) -> Result<(), Refusal> {
        if !self.master.is_prepared() {
            return Err(Refusal::Unprepared);
        }
        let least_us = self.least_period_us();
        if self.law.period_us().get() < u64::from(least_us) {
            return Err(Refusal::TooFast { least_us });
        }
        Ok(())
    }

    fn arm(&mut self) -> Result<(), Refusal> {
        supervisor::next(self.state, Event::Arm)?;
        self.check_bus()?;
        self.apply(Event::Arm)
    }

    /// Drives the motors from now on.
    fn drive(&mut self, drive: Drive) -> Result<(), Refusal> {
        self.apply(Event::Drive)?;
        self.replace_experiment();
        self.drive = drive;
        Ok(())
    }

    /// Replaces the set-up, without a step in the torque if that is on.
    fn install(&mut self, mut law: Law) -> Result<(), Refusal> {
        self.apply(Event::Configure)?;
        if self.is_experimenting() {
            return Err(Refusal::NotIdle);
        }
        if self.state.is_armed() && law.period_us() != self.law.period_us() {
            return Err(Refusal::NotIdle);
        }
        if self.state.is_driven() {
            let reference = self.course.at(self.next_start_us);
            law.take_over(&self.law, &reference);
        } else {
            self.is_fresh = true;
        }
        if law.period_us() != self.law.period_us() {
            let period_us = law.period_us().get() as u32;
            self.guard = Guard::new(*self.guard.limits(), period_us);
        }
        self.law = law;
        self.keep_originals();
        Ok(())
    }

    /// Makes the arm follow a course, from a torque that followed none without a step.
    pub(super) fn follow(&mut self, drive: Drive, course: Course) -> Result<(), Refusal> {
        let was_constant = match self.drive {
            Drive::Torque | Drive::Experiment => self.state.is_driven(),
            Drive::Regulate | Drive::Track | Drive::Hold => false,
        };
        self.drive(drive)?;
        self.course = course;
        if was_constant {
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

    pub(super) fn departure(&self) -> Result<Departure, Refusal> {
        supervisor::next(self.state, Event::Drive)?;
        Ok(self.present_course().departure(self.now_us))
    }

    /// The course, or, if the arm follows none, rest where it is.
    #[inline(never)]
    pub(super) fn present_course(&self) -> Course {
        match self.drive {
            Drive::Regulate | Drive::Track | Drive::Hold if self.state.is_driven() => {
                self.course.clone()
            }
            Drive::Experiment if self.state.is_driven() => self.course_of_experiment(),
            Drive::Torque | Drive::Regulate | Drive::Track | Drive::Hold | Drive::Experiment => {
                self.hold_here()
            }
        }
    }

    pub(super) fn perform(&mut self, task: Task) -> Result<(), Refusal> {
        match task {
            Task::Idle => {
                self.replace_experiment();
                self.apply(Event::Disarm)
            }
            Task::Arm => self.arm(),
            Task::ClearFault => self.apply(Event::ClearFault),
            Task::Torque(torque_nm) => {
                self.drive(Drive::Torque)?;
                self.torque_nm = torque_nm;
                Ok(())
            }
            Task::Regulate(reference_rad) => {
                let course = Course::hold(reference_rad.into());
                self.follow(Drive::Regulate, course)
            }
            Task::Depart => Ok(()),
            Task::Follow(leg) => {
                supervisor::next(self.state, Event::Drive)?;
                let mut course = self.present_course();
                course.change_to(leg, self.now_us)?;
                self.follow(Drive::Track, course)
            }
            Task::Stream(point) => {
                supervisor::next(self.state, Event::Drive)?;
                let mut course = self.present_course();
                course.push(self.now_us, point)?;
                self.follow(Drive::Track, course)
            }
            Task::Experiment(plan) => self.begin_experiment(plan),
            Task::Prepare if self.master.is_prepared() => {
                supervisor::next(self.state, Event::Prepare).map(|_| ())
            }
            Task::Prepare => {
                self.apply(Event::Prepare)?;
                self.stage = Stage::Settle(Chore::PREPARE);
                Ok(())
            }
            Task::Release => {
                self.apply(Event::Release)?;
                if self.master.firmware() == Firmware::Stock {
                    self.stage = Stage::Settle(Chore::RESTORE);
                }
                Ok(())
            }
            Task::Install(law) => self.install(law),
            Task::Limit(limits) => {
                self.apply(Event::Keep)?;
                let period_us = self.law.period_us().get() as u32;
                self.guard = Guard::new(limits, period_us);
                self.keep_originals();
                Ok(())
            }
            Task::Save => self.apply(Event::Keep),
        }
    }
}
