//! Servo set-up: makes stock servos ready for torque, and restores them.
//!
//! Bring-up only reads stock servos' settings. Anything else needs a command,
//! [`Command::Prepare`](crate::link::message::Command::Prepare) or
//! [`Command::Release`](crate::link::message::Command::Release): use of the transparent
//! port alone changes no servo.
//!
//! A stock AX-12A has no torque command. In wheel mode (both angle limits 0) its
//! moving speed is the motor's duty, which is as good. Its return delay, 500 µs
//! ex works, would take the half of a tick for each servo. Both are EEPROM, so
//! they are written only where they differ, and the values found are kept for the
//! release, until reset.

use super::setup_step::{SavedConfig, ServoSettings, SetupGoal, SetupStep, Step};
use crate::JOINTS;
use crate::servo::{Packet, ServoId};

/// Time without requests after a write to a servo's EEPROM, in µs. The e-Manual
/// does not specify it; an `ATmega8`, which AX-12A have had, takes
/// 8.5 ms a byte, and four are the most that is written here.
const EEPROM_US: u64 = 40_000;

/// Next action of the set-up.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Progress {
    /// This step, after a pause in µs.
    Step(SetupStep, u64),
    /// It is over.
    Done(SetupGoal),
    /// The servo of this joint does not take what it must be set to.
    Refused(usize),
    /// The servo of this joint does not answer.
    Silent(usize),
}

/// Settings of the stock servos, as found and as read.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct ServoSetup {
    saved: [SavedConfig; JOINTS],
}

impl ServoSetup {
    /// The request of this step or of the next that has one, with that step;
    /// otherwise the set-up is over.
    ///
    /// # Errors
    /// The goal that has been reached.
    pub(super) fn request(
        &self,
        mut step: SetupStep,
        ids: [ServoId; JOINTS],
    ) -> Result<(SetupStep, Packet, u8), SetupGoal> {
        loop {
            let saved = self.saved.get(step.joint).copied().unwrap_or_default();
            let id = ids.get(step.joint).map_or(0, |id| id.get());
            let access = step.access(&saved);
            if let Some((packet, reply_bytes)) = access.and_then(|access| access.packet(id)) {
                return Ok((step, packet, reply_bytes));
            }
            step = step.after().ok_or(step.goal)?;
        }
    }

    /// The request of this step has been answered with these data, or not at all.
    pub(super) fn note_reply(&mut self, step: SetupStep, data: Option<&[u8]>) -> Progress {
        let pause_us = if step.step.is_kept() { EEPROM_US } else { 0 };
        let next = match (step.step, data.and_then(ServoSettings::of)) {
            (Step::Look | Step::LookAgain | Step::Check, Some(settings)) => {
                let is_check = step.step == Step::Check;
                if let Some(saved) = self.saved.get_mut(step.joint) {
                    saved.now = Some(settings);
                    if !is_check && !settings.are_ready() {
                        saved.before = Some(settings);
                    }
                }
                if is_check && !settings.are_ready() {
                    return Progress::Refused(step.joint);
                }
                step.after()
            }
            // Status return level 0: READ is not answered.
            (Step::Look, None) => Some(SetupStep {
                step: Step::MakeItAnswer,
                ..step
            }),
            (Step::LookAgain | Step::Check, None) => return Progress::Silent(step.joint),
            (
                Step::MakeItAnswer
                | Step::Mode
                | Step::Delay
                | Step::Standstill
                | Step::TorqueOn
                | Step::TorqueOff
                | Step::Level,
                _,
            ) => step.after(),
        };
        next.map_or(Progress::Done(step.goal), |next| {
            Progress::Step(next, pause_us)
        })
    }

    /// The servos are as they were found.
    pub(super) fn forget(&mut self) {
        *self = Self::default();
    }
}
