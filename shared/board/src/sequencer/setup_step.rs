//! Set-up steps of stock servos: their order, and the register access of each.

use heapless::Vec;

use armbridge_servo::master::timing::RETURN_DELAY_US;
use armbridge_servo::protocol1::{Instruction, register};
use armbridge_servo::{JOINTS, Packet};

/// Bytes that are read at once: return delay through torque enable.
const SETTINGS_BYTES: u16 = register::TORQUE_ENABLE - register::RETURN_DELAY + 1;
/// [`RETURN_DELAY_US`] in the register's unit.
const RETURN_DELAY: u8 = (RETURN_DELAY_US / 2) as u8;
/// Angle limits of wheel mode.
const WHEEL: [u8; 4] = [0; 4];
/// Status return level with which READ is answered and WRITE is not: the least that a
/// tick needs.
const LEVEL_READ: u8 = 1;

/// Most repetitions of the steps of servos that are not ready after them: a write was lost,
/// or a reply.
const REPEATS_MAX: u8 = 3;

/// Settings in a stock servo's EEPROM that the bridge changes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct ServoSettings {
    return_delay: u8,
    limits: [u8; 4],
    /// Torque limit at power-up.
    max_torque: [u8; 2],
    /// Status return level.
    level: u8,
    /// Torque enable, which is no setting.
    torque: u8,
}

impl ServoSettings {
    /// Decodes the registers from the return delay on.
    pub(super) fn decode(memory: &[u8]) -> Option<Self> {
        let at = |address: u16| usize::from(address - register::RETURN_DELAY);
        let limits = at(register::ANGLE_LIMITS);
        let max_torque = at(register::MAX_TORQUE);
        Some(Self {
            return_delay: *memory.first()?,
            limits: memory.get(limits..limits + 4)?.try_into().ok()?,
            max_torque: memory.get(max_torque..max_torque + 2)?.try_into().ok()?,
            level: *memory.get(at(register::STATUS_RETURN_LEVEL))?,
            torque: *memory.get(at(register::TORQUE_ENABLE))?,
        })
    }

    /// Whether the servo takes torque with these settings.
    pub(super) fn are_ready(self) -> bool {
        self.return_delay == RETURN_DELAY && self.limits == WHEEL && self.level > 0
    }

    /// Whether it would obey a torque now.
    pub(super) fn are_in_force(self) -> bool {
        self.are_ready() && self.torque == 1
    }
}

/// Settings of a joint's stock servo.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct SavedConfig {
    /// Settings as found first.
    pub(super) before: Option<ServoSettings>,
    /// Settings as read last.
    pub(super) now: Option<ServoSettings>,
}

/// One step of the set-up of one servo.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct SetupStep {
    pub(super) goal: SetupGoal,
    pub(super) joint: usize,
    pub(super) step: Step,
    /// Repetitions of steps so far.
    pub(super) repeats: u8,
}

/// Purpose of the set-up.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum SetupGoal {
    /// Settings read, unchanged.
    Read,
    /// Ready for torque.
    Prepare,
    /// As they were found.
    Restore,
}

/// Action on one servo.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Step {
    /// Reads the settings.
    Read,
    /// Raises the status return level of a servo that does not answer READ.
    EnableReplies,
    /// Reads the settings after that.
    Reread,
    /// Writes the angle limits, which select wheel mode.
    AngleLimits,
    ReturnDelay,
    /// Writes moving speed 0, and the torque limit.
    ZeroSpeed,
    TorqueOn,
    TorqueOff,
    /// Writes the status return level.
    StatusLevel,
    /// Reads settings and torque enable to compare them with the goal.
    Verify,
}

impl Step {
    /// Whether the step writes to the EEPROM.
    pub(super) fn writes_eeprom(self) -> bool {
        match self {
            Self::EnableReplies | Self::AngleLimits | Self::ReturnDelay | Self::StatusLevel => true,
            Self::Read
            | Self::Reread
            | Self::ZeroSpeed
            | Self::TorqueOn
            | Self::TorqueOff
            | Self::Verify => false,
        }
    }
}

/// Access to registers of one servo.
pub(super) enum RegisterAccess {
    Read,
    Write(u16, Vec<u8, 4>),
}

impl SetupStep {
    pub(super) const READ: Self = Self {
        goal: SetupGoal::Read,
        joint: 0,
        step: Step::Read,
        repeats: 0,
    };
    pub(super) const PREPARE: Self = Self {
        goal: SetupGoal::Prepare,
        joint: 0,
        step: Step::TorqueOff,
        repeats: 0,
    };
    pub(super) const RESTORE: Self = Self {
        goal: SetupGoal::Restore,
        joint: 0,
        step: Step::TorqueOff,
        repeats: 0,
    };

    /// Whether the set-up restores the servos.
    pub(super) fn is_restore(self) -> bool {
        self.goal == SetupGoal::Restore
    }

    /// The step with which this joint is made ready once more; `None` if that has been tried
    /// often enough.
    pub(super) fn again(self) -> Option<Self> {
        (self.repeats < REPEATS_MAX).then_some(Self {
            step: Step::TorqueOff,
            repeats: self.repeats + 1,
            ..self
        })
    }

    /// The step after this one; `None` after the last.
    pub(super) fn after(self) -> Option<Self> {
        use Step::{
            AngleLimits, EnableReplies, Read, Reread, ReturnDelay, StatusLevel, TorqueOff,
            TorqueOn, Verify, ZeroSpeed,
        };
        let of_this = |step| Some((self.joint, step));
        let of_next = |step| (self.joint + 1 < JOINTS).then_some((self.joint + 1, step));
        let (joint, step) = match (self.goal, self.step) {
            (_, EnableReplies) => of_this(Reread),
            // An EEPROM is written with torque off.
            (_, TorqueOff) => of_this(AngleLimits),
            (_, AngleLimits) => of_this(ReturnDelay),
            (SetupGoal::Restore, ReturnDelay) => of_this(StatusLevel),
            // No servo has torque while the board waits for the EEPROM of another.
            (_, ReturnDelay) => of_next(TorqueOff).or(Some((0, ZeroSpeed))),
            (_, ZeroSpeed) => of_this(TorqueOn),
            (_, TorqueOn) => of_this(Verify),
            (_, Verify) => of_next(ZeroSpeed),
            (_, StatusLevel) => of_next(TorqueOff),
            (_, Read | Reread) => of_next(Read),
        }?;
        Some(Self {
            joint,
            step,
            ..self
        })
    }

    /// Settings that the goal requires: ready, or as found.
    fn target(self, saved: &SavedConfig) -> Option<ServoSettings> {
        match self.goal {
            SetupGoal::Read => saved.now,
            SetupGoal::Prepare => Some(ServoSettings {
                return_delay: RETURN_DELAY,
                limits: WHEEL,
                level: saved.now?.level.max(LEVEL_READ),
                ..saved.now?
            }),
            SetupGoal::Restore => saved.before,
        }
    }

    /// The register access of this step; `None` if there is nothing to do.
    pub(super) fn access(self, saved: &SavedConfig) -> Option<RegisterAccess> {
        let write = |address, data: &[u8]| {
            Vec::from_slice(data)
                .ok()
                .map(|d| RegisterAccess::Write(address, d))
        };
        match self.step {
            Step::Read | Step::Reread | Step::Verify => Some(RegisterAccess::Read),
            Step::EnableReplies => write(register::STATUS_RETURN_LEVEL, &[LEVEL_READ]),
            // The torque limit is the next register: a shutdown has left it at 0.
            Step::ZeroSpeed => {
                let [low, high] = saved.now?.max_torque;
                write(register::MOVING_SPEED, &[0, 0, low, high])
            }
            Step::TorqueOn => write(register::TORQUE_ENABLE, &[1]),
            Step::TorqueOff => write(register::TORQUE_ENABLE, &[0]),
            Step::AngleLimits | Step::ReturnDelay | Step::StatusLevel => {
                let (now, target) = (saved.now?, self.target(saved)?);
                match self.step {
                    Step::AngleLimits if now.limits != target.limits => {
                        write(register::ANGLE_LIMITS, &target.limits)
                    }
                    Step::ReturnDelay if now.return_delay != target.return_delay => {
                        write(register::RETURN_DELAY, &[target.return_delay])
                    }
                    Step::StatusLevel if now.level != target.level => {
                        write(register::STATUS_RETURN_LEVEL, &[target.level])
                    }
                    _ => None,
                }
            }
        }
    }
}

impl RegisterAccess {
    /// The packet to the servo `id`, and the bytes of its reply.
    pub(super) fn packet(&self, id: u8) -> Option<(Packet, u16)> {
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
