//! Servo set-up: makes stock servos ready for torque, and restores them.
//!
//! Bring-up only reads stock servos' settings. A change needs a command,
//! [`Command::Prepare`](armbridge_link::message::Command::Prepare) or
//! [`Command::Release`](armbridge_link::message::Command::Release): use of the transparent
//! port alone changes no servo.
//!
//! A stock AX-12A has no torque command. In wheel mode (both angle limits 0) its
//! moving speed is the motor's duty, which has the same effect. Its return delay, 500 µs
//! ex works, would take half of a tick for each servo. Both are EEPROM, so
//! they are written only where they differ, and the values found are kept for the
//! release, until reset.

use super::setup_step::{SavedConfig, ServoSettings, SetupGoal, SetupStep, Step};
use armbridge_servo::master::timing::CONTROL_STEP_US;
use armbridge_servo::{JOINTS, Packet, ServoId};

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
    ) -> Result<(SetupStep, Packet, u16), SetupGoal> {
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
            // Until its control step is over, a servo that has replied may not listen.
            CONTROL_STEP_US
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
                if is_check && !settings.are_in_force() {
                    let again = step.again().map(|again| Progress::Step(again, pause_us));
                    return again.unwrap_or(Progress::Refused(step.joint));
                }
                step.after()
            }
            // No reply to READ: the status return level is 0.
            (Step::Read, None) => Some(SetupStep {
                step: Step::EnableReplies,
                ..step
            }),
            (Step::Verify, None) if step.again().is_some() => step.again(),
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

#[cfg(test)]
mod tests {
    extern crate std;
    use super::super::setup_step::RegisterAccess;
    use super::*;
    use armbridge_servo::protocol1::register::TORQUE_ENABLE;
    use std::vec::Vec;

    /// A servo's registers, as it comes from the factory, with torque off.
    fn factory() -> [u8; 50] {
        let mut memory = [0; 50];
        memory[5] = 250;
        memory[8..10].copy_from_slice(&1023_u16.to_le_bytes());
        memory[14..16].copy_from_slice(&1023_u16.to_le_bytes());
        memory[16] = 2;
        memory
    }

    /// Reads and prepares servos with these registers; every write that `is_lost` selects by
    /// its number is lost. Joint and address of each write, and the end.
    fn prepared(
        servos: &mut [[u8; 50]; JOINTS],
        is_lost: impl Fn(usize) -> bool,
    ) -> (Vec<(usize, u16)>, Progress) {
        let ids = [1, 2].map(|id| ServoId::new(id).unwrap());
        let (mut setup, mut writes) = (ServoSetup::default(), Vec::new());
        let mut end = Progress::Done(SetupGoal::Read);
        for first in [SetupStep::READ, SetupStep::PREPARE] {
            let mut step = first;
            end = loop {
                step = match setup.request(step, ids) {
                    Ok((step, _, _)) => step,
                    Err(goal) => break Progress::Done(goal),
                };
                let memory = &mut servos[step.joint];
                let data = match step.access(&setup.saved[step.joint]).unwrap() {
                    RegisterAccess::Read => Some(&memory[5..25]),
                    RegisterAccess::Write(address, data) => {
                        writes.push((step.joint, address));
                        if !is_lost(writes.len() - 1) {
                            memory[usize::from(address)..][..data.len()].copy_from_slice(&data);
                        }
                        None
                    }
                };
                match setup.note_reply(step, data) {
                    Progress::Step(next, pause_us) => {
                        assert!(pause_us >= CONTROL_STEP_US);
                        step = next;
                    }
                    end => break end,
                }
            };
        }
        (writes, end)
    }

    #[test]
    fn torque_is_enabled_once_no_eeprom_is_left_to_write() {
        let mut servos = [factory(); JOINTS];
        let (writes, end) = prepared(&mut servos, |_| false);
        assert_eq!(end, Progress::Done(SetupGoal::Prepare));
        let of = |joint| [(joint, TORQUE_ENABLE), (joint, 6), (joint, 5)];
        let then = |joint| [(joint, 32), (joint, TORQUE_ENABLE)];
        assert_eq!(writes, [&of(0)[..], &of(1), &then(0), &then(1)].concat());
        assert!(
            servos
                .iter()
                .all(|memory| memory[24] == 1 && memory[5] == 10)
        );
    }

    #[test]
    fn a_lost_write_is_repeated() {
        for lost in 0..10 {
            let mut servos = [factory(); JOINTS];
            let (_, end) = prepared(&mut servos, |write| write == lost);
            assert_eq!(end, Progress::Done(SetupGoal::Prepare), "{lost}");
            assert!(
                servos
                    .iter()
                    .all(|memory| memory[24] == 1 && memory[5] == 10)
            );
        }
        let (writes, end) = prepared(&mut [factory(); JOINTS], |_| true);
        assert_eq!(end, Progress::Refused(0));
        assert!(writes.len() < 60, "{}", writes.len());
    }
}
