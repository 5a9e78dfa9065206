//! Servo set-up: makes stock and X servos ready for torque, and restores them.
//!
//! Bring-up only reads their settings. A change needs a command,
//! [`Command::Prepare`](armbridge_link::message::Command::Prepare) or
//! [`Command::Release`](armbridge_link::message::Command::Release): use of the transparent
//! port alone changes no servo.
//!
//! A stock AX-12A has no torque command. In wheel mode (both angle limits 0) its
//! moving speed is the motor's duty, which has the same effect. Its return delay, 500 µs
//! ex works, would take half of a tick for each servo. Both are EEPROM, so
//! they are written only where they differ, and the values found are kept for the
//! release, until reset.
//!
//! An X servo has a PWM control mode, and a current control mode if it measures its current: EEPROM,
//! too, as is its drive mode, of which the direction of rotation stays as found and torque by a goal
//! does not. A servo in current control mode whose current limit is below the board's largest
//! command ignores a goal beyond it, so it is refused. The watchdog of the bus is set last, by the
//! period of the ticks: from then on a servo that receives no packet of its protocol for that long
//! switches its motor off, whatever has become of board and wire.

use super::servo_settings::{RegisterImage, ServoSettings, XRequirements};
use super::setup_step::{RegisterAccess, SavedConfig, SetupGoal, SetupStep, Step};
use armbridge_servo::master::timing::CONTROL_STEP_US;
use armbridge_servo::{ControlMode, Firmware, JOINTS, Query, ServoIds};

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

/// Set-up of the servos, with their settings as found and as read.
#[derive(Clone, Copy, Debug)]
pub(super) struct ServoSetup {
    saved: [SavedConfig; JOINTS],
    image: RegisterImage,
    required: XRequirements,
}

impl ServoSetup {
    /// Nothing is known of the servos.
    pub(super) fn new(required: XRequirements) -> Self {
        Self {
            saved: [SavedConfig::default(); JOINTS],
            image: RegisterImage::default(),
            required,
        }
    }

    /// Sets what X servos have to be. Whether that is something else than before.
    pub(super) fn require(&mut self, required: XRequirements) -> bool {
        core::mem::replace(&mut self.required, required) != required
    }

    /// What commands of servos are that have been made ready.
    pub(super) fn mode(&self) -> ControlMode {
        self.required.mode
    }

    /// The first request from this step on, with its step; joints without a servo have none.
    ///
    /// # Errors
    /// The goal, if no step with a request is left.
    pub(super) fn request(
        &self,
        mut step: SetupStep,
        firmware: Firmware,
        ids: ServoIds,
    ) -> Result<(SetupStep, Query), SetupGoal> {
        loop {
            let servo = ids.get(step.joint).zip(self.access(step, firmware));
            if let Some(query) = servo.and_then(|(id, access)| access.query(firmware, id.get())) {
                return Ok((step, query));
            }
            step = step.after().ok_or(step.goal)?;
        }
    }

    /// The register access of a step; `None` if there is nothing to do.
    fn access(&self, step: SetupStep, firmware: Firmware) -> Option<RegisterAccess> {
        let saved = self.saved.get(step.joint).copied().unwrap_or_default();
        step.access(firmware, &saved, self.required)
    }

    /// Takes the data of the reply to this step, or its absence.
    pub(super) fn note_reply(
        &mut self,
        step: SetupStep,
        firmware: Firmware,
        data: Option<&[u8]>,
    ) -> Progress {
        let pause_us = if step.step.writes_eeprom() {
            EEPROM_US
        } else {
            // Until its control step is over, a servo that has replied may not listen.
            CONTROL_STEP_US
        };
        let is_silent = data.is_none();
        // An X servo without such a register answers without data.
        let data = data.filter(|data| !data.is_empty());
        let access = self.access(step, firmware);
        let reads = step.reads(firmware, self.required.mode).unwrap_or_default();
        if let (Some(data), Some(RegisterAccess::Read(..))) = (data, access) {
            self.image.store(reads, step.read, data);
            if let Some(next) = step.next_read(reads) {
                return Progress::Step(next, pause_us);
            }
        }
        let settings =
            data.and_then(|_| ServoSettings::decode(firmware, &self.image, reads, self.required));
        let next = match (step.step, settings) {
            (Step::Read | Step::Reread | Step::Confirm | Step::Verify, Some(settings)) => {
                let is_check = matches!(step.step, Step::Confirm | Step::Verify);
                let is_passed = match step.step {
                    Step::Confirm => settings.are_safe(self.required),
                    Step::Verify => settings.are_in_force(self.required),
                    _ => true,
                };
                if let Some(saved) = self.saved.get_mut(step.joint) {
                    saved.now = Some(settings);
                    if !is_check && !settings.are_ready(self.required) {
                        saved.before = Some(settings);
                    }
                }
                if !is_passed {
                    let again = step.again().map(|again| Progress::Step(again, pause_us));
                    return again.unwrap_or(Progress::Refused(step.joint));
                }
                step.after()
            }
            // No reply to READ: the status return level is 0.
            (Step::Read, None) => Some(SetupStep {
                step: Step::EnableReplies,
                read: 0,
                ..step
            }),
            (Step::Confirm | Step::Verify, None) if step.again().is_some() => step.again(),
            (Step::Reread | Step::Confirm | Step::Verify, None) => {
                return if is_silent {
                    Progress::Silent(step.joint)
                } else {
                    Progress::Refused(step.joint)
                };
            }
            (
                Step::EnableReplies
                | Step::Mode
                | Step::ReturnDelay
                | Step::WatchdogOff
                | Step::ZeroGoal
                | Step::Watchdog
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
        self.saved = [SavedConfig::default(); JOINTS];
        self.image = RegisterImage::default();
    }
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;
    use crate::tick::LoopConfig;
    use armbridge_link::message::Settings;
    use armbridge_servo::protocol1::register::TORQUE_ENABLE;
    use std::vec::Vec;

    fn required() -> XRequirements {
        XRequirements::of(&LoopConfig::build(&Settings::default()).unwrap())
    }

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
        let ids = ServoIds::from([1, 2].map(|id| armbridge_servo::ServoId::new(id).unwrap()));
        let (mut setup, mut writes) = (ServoSetup::new(required()), Vec::new());
        let mut end = Progress::Done(SetupGoal::Read);
        for first in [SetupStep::READ, SetupStep::PREPARE] {
            let mut step = first;
            end = loop {
                step = match setup.request(step, Firmware::Stock, ids) {
                    Ok((step, _)) => step,
                    Err(goal) => break Progress::Done(goal),
                };
                let memory = &mut servos[step.joint];
                let data = match step
                    .access(Firmware::Stock, &setup.saved[step.joint], required())
                    .unwrap()
                {
                    RegisterAccess::Read(..) => Some(&memory[5..25]),
                    RegisterAccess::Write(address, data) => {
                        writes.push((step.joint, address));
                        if !is_lost(writes.len() - 1) {
                            memory[usize::from(address)..][..data.len()].copy_from_slice(&data);
                        }
                        None
                    }
                };
                match setup.note_reply(step, Firmware::Stock, data) {
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
