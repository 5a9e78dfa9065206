//! Set-up steps of stock servos: their order, and the request of each.

use heapless::Vec;

use crate::JOINTS;
use crate::servo::Packet;
use crate::servo::master::timing::RETURN_DELAY_US;
use crate::servo::protocol1::{Instruction, register};

/// From the return delay to the status return level: what is read at once.
const SETTINGS_BYTES: u8 = register::STATUS_RETURN_LEVEL - register::RETURN_DELAY + 1;
/// [`RETURN_DELAY_US`] in the register's unit.
const RETURN_DELAY: u8 = (RETURN_DELAY_US / 2) as u8;
const WHEEL: [u8; 4] = [0; 4];
/// READ is answered, WRITE is not: the least that a tick needs.
const LEVEL_READ: u8 = 1;

/// What the bridge changes in a stock servo's EEPROM.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct ServoSettings {
    return_delay: u8,
    limits: [u8; 4],
    /// What the torque limit is at power-up.
    max_torque: [u8; 2],
    level: u8,
}

impl ServoSettings {
    pub(super) fn of(memory: &[u8]) -> Option<Self> {
        let at = |address: u8| usize::from(address - register::RETURN_DELAY);
        let limits = at(register::ANGLE_LIMITS);
        let max_torque = at(register::MAX_TORQUE);
        Some(Self {
            return_delay: *memory.first()?,
            limits: memory.get(limits..limits + 4)?.try_into().ok()?,
            max_torque: memory.get(max_torque..max_torque + 2)?.try_into().ok()?,
            level: *memory.get(at(register::STATUS_RETURN_LEVEL))?,
        })
    }

    pub(super) fn are_ready(self) -> bool {
        self.return_delay == RETURN_DELAY && self.limits == WHEEL && self.level > 0
    }
}

/// Settings of a joint's stock servo.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct SavedConfig {
    /// As found at first.
    pub(super) before: Option<ServoSettings>,
    /// As read last.
    pub(super) now: Option<ServoSettings>,
}

/// One step of the set-up of one servo.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct SetupStep {
    pub(super) goal: SetupGoal,
    pub(super) joint: usize,
    pub(super) step: Step,
}

/// Purpose of the set-up.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum SetupGoal {
    /// Reading of their settings.
    Look,
    /// Ready for torque.
    Prepare,
    /// As they were found.
    Restore,
}

/// Action on one servo.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Step {
    Look,
    /// To one that does not answer READ.
    MakeItAnswer,
    LookAgain,
    Mode,
    Delay,
    Standstill,
    TorqueOn,
    TorqueOff,
    Level,
    Check,
}

impl Step {
    /// Whether it writes to the EEPROM.
    pub(super) fn is_kept(self) -> bool {
        match self {
            Self::MakeItAnswer | Self::Mode | Self::Delay | Self::Level => true,
            Self::Look
            | Self::LookAgain
            | Self::Standstill
            | Self::TorqueOn
            | Self::TorqueOff
            | Self::Check => false,
        }
    }
}

/// A request to one servo.
pub(super) enum RegisterAccess {
    Read,
    Write(u8, Vec<u8, 4>),
}

impl SetupStep {
    pub(super) const LOOK: Self = Self {
        goal: SetupGoal::Look,
        joint: 0,
        step: Step::Look,
    };
    pub(super) const PREPARE: Self = Self {
        goal: SetupGoal::Prepare,
        joint: 0,
        step: Step::TorqueOff,
    };
    pub(super) const RESTORE: Self = Self {
        goal: SetupGoal::Restore,
        joint: 0,
        step: Step::TorqueOff,
    };

    /// Whether it gives the servos back.
    pub(super) fn is_restore(self) -> bool {
        self.goal == SetupGoal::Restore
    }

    /// The step after this one; `None` after the last joint's last.
    pub(super) fn after(self) -> Option<Self> {
        use Step::{
            Check, Delay, Level, Look, LookAgain, MakeItAnswer, Mode, Standstill, TorqueOff,
            TorqueOn,
        };
        let step = match (self.goal, self.step) {
            (_, MakeItAnswer) => Some(LookAgain),
            // An EEPROM is written with torque off.
            (_, TorqueOff) => Some(Mode),
            (_, Mode) => Some(Delay),
            (SetupGoal::Restore, Delay) => Some(Level),
            (_, Delay) => Some(Standstill),
            (_, Standstill) => Some(TorqueOn),
            (_, TorqueOn) => Some(Check),
            (_, Check | Level | Look | LookAgain) => None,
        };
        match (step, self.goal) {
            (Some(step), _) => Some(Self { step, ..self }),
            (None, _) if self.joint + 1 >= JOINTS => None,
            (None, goal) => Some(Self {
                joint: self.joint + 1,
                ..match goal {
                    SetupGoal::Look => Self::LOOK,
                    SetupGoal::Prepare => Self::PREPARE,
                    SetupGoal::Restore => Self::RESTORE,
                }
            }),
        }
    }

    /// What the servo shall be set to: ready, or as it was found.
    fn wanted(self, stock: &SavedConfig) -> Option<ServoSettings> {
        match self.goal {
            SetupGoal::Look => stock.now,
            SetupGoal::Prepare => Some(ServoSettings {
                return_delay: RETURN_DELAY,
                limits: WHEEL,
                level: stock.now?.level.max(LEVEL_READ),
                ..stock.now?
            }),
            SetupGoal::Restore => stock.before,
        }
    }

    /// The request of this step; `None` if there is nothing to do.
    pub(super) fn access(self, stock: &SavedConfig) -> Option<RegisterAccess> {
        let write = |address, data: &[u8]| {
            Vec::from_slice(data)
                .ok()
                .map(|d| RegisterAccess::Write(address, d))
        };
        match self.step {
            Step::Look | Step::LookAgain | Step::Check => Some(RegisterAccess::Read),
            Step::MakeItAnswer => write(register::STATUS_RETURN_LEVEL, &[LEVEL_READ]),
            // The torque limit lies beside: a shutdown has left it at 0.
            Step::Standstill => {
                let [low, high] = stock.now?.max_torque;
                write(register::MOVING_SPEED, &[0, 0, low, high])
            }
            Step::TorqueOn => write(register::TORQUE_ENABLE, &[1]),
            Step::TorqueOff => write(register::TORQUE_ENABLE, &[0]),
            Step::Mode | Step::Delay | Step::Level => {
                let (now, wanted) = (stock.now?, self.wanted(stock)?);
                match self.step {
                    Step::Mode if now.limits != wanted.limits => {
                        write(register::ANGLE_LIMITS, &wanted.limits)
                    }
                    Step::Delay if now.return_delay != wanted.return_delay => {
                        write(register::RETURN_DELAY, &[wanted.return_delay])
                    }
                    Step::Level if now.level != wanted.level => {
                        write(register::STATUS_RETURN_LEVEL, &[wanted.level])
                    }
                    _ => None,
                }
            }
        }
    }
}

impl RegisterAccess {
    pub(super) fn packet(&self, id: u8) -> Option<(Packet, u8)> {
        match self {
            Self::Read => {
                let read = Instruction::Read {
                    address: register::RETURN_DELAY,
                    count: SETTINGS_BYTES,
                };
                Some((read.encode(id)?, SETTINGS_BYTES + 6))
            }
            Self::Write(address, data) => {
                let write = Instruction::Write {
                    address: *address,
                    data,
                };
                Some((write.encode(id)?, 6))
            }
        }
    }
}
