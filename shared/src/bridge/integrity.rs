//! Whether the numbers in memory are still those that were set.
//!
//! Set-up and limits lie in RAM for hours. A bit that turns there, by a fault of the
//! memory or of the program, changes what the arm is given without anybody saying
//! so. Of both there is a second copy, as they were built; while torque is on, what
//! is in force is compared with it, less what it has learnt of the arm since, by
//! turns each [`CHECK_US`]. One that differs, whichever it is, is a fault.

use core::ops::ControlFlow;
use embedded_hal::digital::OutputPin;
use embedded_hal_nb::serial::{Read, Write};

use super::Bridge;
use super::guard::{Guard, Violation};
use super::law::Law;
use crate::link::message::Fault;
use crate::servo::port::SetBaud;

/// From one comparison to the next, of the other half. Either takes more than a
/// thousand instructions, too many for every tick; with the stop that follows, torque
/// is off within 20 ms.
const CHECK_US: u32 = 5_000;

/// Set-up and limits as they were built.
#[derive(Clone, Debug)]
pub(super) struct Originals {
    law: Law,
    guard: Guard,
    /// Ticks until the next comparison, and which it is.
    wait: u32,
    guard_is_next: bool,
}

impl Originals {
    pub(super) fn of(law: &Law, guard: &Guard) -> Self {
        Self {
            law: law.as_built(),
            guard: guard.as_built(),
            wait: 0,
            guard_is_next: false,
        }
    }

    /// Whether this tick compares, and finds a difference.
    fn check(&mut self, law: &Law, guard: &Guard) -> ControlFlow<()> {
        if let Some(wait) = self.wait.checked_sub(1) {
            self.wait = wait;
            return ControlFlow::Continue(());
        }
        let period_us = self.law.period_us();
        let ticks = (u64::from(CHECK_US) / period_us) as u32;
        self.wait = ticks.saturating_sub(1);
        let guard_is_next = !self.guard_is_next;
        let is_guard = core::mem::replace(&mut self.guard_is_next, guard_is_next);
        let is_as_built = if is_guard {
            guard.as_built() == self.guard
        } else {
            law.as_built() == self.law
        };
        if is_as_built {
            ControlFlow::Continue(())
        } else {
            ControlFlow::Break(())
        }
    }

    /// The next comparison finds a difference.
    pub(super) fn spoil(&mut self) {
        if let Some(number) = self.law.numbers().into_iter().next() {
            *number = f32::NAN;
        }
        (self.wait, self.guard_is_next) = (0, false);
    }

    fn are(&self, law: &Law, guard: &Guard) -> bool {
        law.as_built() == self.law && guard.as_built() == self.guard
    }
}

impl<S, D> Bridge<'_, S, D>
where
    S: Read<u8> + Write<u8> + SetBaud,
    D: OutputPin,
{
    /// Set-up or limits have been replaced.
    pub(super) fn keep_originals(&mut self) {
        self.originals = Originals::of(&self.law, &self.guard);
    }

    pub(super) fn check_integrity(&mut self) {
        if self.state.is_armed() && self.originals.check(&self.law, &self.guard).is_break() {
            self.trip(Violation::plain(Fault::Corrupted));
        }
    }

    /// What a doubt comes from: numbers that have changed make an arm run away, too.
    pub(super) fn cause(&self, violation: Violation) -> Violation {
        let is_of_numbers = match violation.fault {
            Fault::AngleLimit
            | Fault::SpeedLimit
            | Fault::TorqueLimit
            | Fault::TorqueRate
            | Fault::PwmLimit
            | Fault::DeadZone
            | Fault::Diverged
            | Fault::Stuck
            | Fault::NotFinite => true,
            Fault::EmergencyStop(_)
            | Fault::HostSilent
            | Fault::Temperature
            | Fault::ServoSilent
            | Fault::ServoReset
            | Fault::SamplesLost
            | Fault::SamplesRare
            | Fault::Overrun
            | Fault::Clock
            | Fault::ServoAlarm
            | Fault::FirmwareChanged
            | Fault::Corrupted => false,
        };
        if is_of_numbers && !self.originals.are(&self.law, &self.guard) {
            Violation::plain(Fault::Corrupted)
        } else {
            violation
        }
    }

    /// Turns a bit of a number that the tick computes with, which one by `draw`: to
    /// see what becomes of it.
    pub fn corrupt(&mut self, draw: u32) {
        let numbers = self.law.numbers();
        let count = numbers.len() as u32;
        let bit = 1 << (draw / count % 32);
        if let Some(number) = numbers.into_iter().nth((draw % count) as usize) {
            *number = f32::from_bits(number.to_bits() ^ bit);
        }
    }
}
