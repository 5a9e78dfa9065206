//! Servo set-up: makes stock servos ready for torque, and restores them.
//!
//! Bring-up only reads stock servos' settings. A change needs a command,
//! [`Command::Prepare`](crate::link::message::Command::Prepare) or
//! [`Command::Release`](crate::link::message::Command::Release): use of the transparent
//! port alone changes no servo.
//!
//! A stock AX-12A has no torque command. In wheel mode (both angle limits 0) its
//! moving speed is the motor's duty, which has the same effect. Its return delay, 500 µs
//! ex works, would take half of a tick for each servo. Both are EEPROM, so
//! they are written only where they differ, and the values found are kept for the
//! release, until reset.

use super::setup_step::{SavedConfig, ServoSettings, SetupGoal, SetupStep, Step};
use crate::JOINTS;
use crate::servo::{Packet, ServoId};

/// Time without requests after a write to a servo's EEPROM, in µs. The e-Manual
/// does not specify it; an `ATmega8`, which AX-12A have had, takes
/// 8.5 ms a byte, and the longest write here is four.
const EEPROM_US: u64 = 40_000;

/// Next action of the set-up.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Progress {
    /// The next step, after a pause in µs.
    Step(SetupStep, u64),
    /// The set-up is over.
    Done(SetupGoal),
    /// The servo of this joint rejects its settings.
    Refused(usize),
    /// The servo of this joint does not answer.
    Silent(usize),
}

/// Set-up of the stock servos, with their settings as found and as read.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct ServoSetup {
    saved: [SavedConfig; JOINTS],
}

impl ServoSetup {
    /// The first request from this step on, with its step, packet and bytes of reply.
    ///
    /// # Errors
    /// The goal, if no step with a request is left.
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

    /// Takes the data of the reply to this step, or its absence.
    pub(super) fn note_reply(&mut self, step: SetupStep, data: Option<&[u8]>) -> Progress {
        let pause_us = if step.step.writes_eeprom() {
            EEPROM_US
        } else {
            0
        };
        let next = match (step.step, data.and_then(ServoSettings::decode)) {
            (Step::Read | Step::Reread | Step::Verify, Some(settings)) => {
                let is_check = step.step == Step::Verify;
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
            // No reply to READ: the status return level is 0.
            (Step::Read, None) => Some(SetupStep {
                step: Step::EnableReplies,
                ..step
            }),
            (Step::Reread | Step::Verify, None) => return Progress::Silent(step.joint),
            (
                Step::EnableReplies
                | Step::AngleLimits
                | Step::ReturnDelay
                | Step::ZeroSpeed
                | Step::TorqueOn
                | Step::TorqueOff
                | Step::StatusLevel,
                _,
            ) => step.after(),
        };
        next.map_or(Progress::Done(step.goal), |next| {
            Progress::Step(next, pause_us)
        })
    }

    /// Drops the saved settings: the servos are as they were found.
    pub(super) fn clear(&mut self) {
        *self = Self::default();
    }
}
