//! Set-up steps of stock and X servos: their order, and the register access of each.

use heapless::Vec;

use armbridge_servo::master::timing::RETURN_DELAY_US;
use armbridge_servo::protocol2::model::OperatingMode;
use armbridge_servo::{Firmware, JOINTS, Query, protocol1, protocol2};

/// Status return level with which READ is answered and WRITE is not: the least that a
/// tick needs.
const LEVEL_READ: u8 = 1;
/// Silence of the bus after which an X servo switches its motor off, in units of 20 ms.
const WATCHDOG: u8 = 1;

/// Bytes of the registers that are read, from address 0 on: of an X servo through the goal PWM.
const IMAGE_BYTES: usize = protocol2::register::GOAL_PWM as usize + 2;

/// Most repetitions of the steps of servos that are not ready after them: a write was lost,
/// or a reply.
const REPEATS_MAX: u8 = 3;

/// Registers of a set-up, and what they have in a servo that is ready.
struct Registers {
    return_delay: u16,
    /// In units of 2 µs.
    ready_delay: u8,
    /// What selects open-loop control: address, bytes, and their contents.
    mode: u16,
    mode_bytes: usize,
    ready_mode: [u8; 4],
    level: u16,
    torque: u16,
    /// What is read: first addresses and numbers of bytes. No READ goes across addresses without a
    /// register, of which the e-Manual of the X series does not say what a servo answers.
    reads: &'static [(u16, u16)],
}

/// Both angle limits 0 are wheel mode.
const AX12A: Registers = Registers {
    return_delay: protocol1::register::RETURN_DELAY,
    ready_delay: (RETURN_DELAY_US / 2) as u8,
    mode: protocol1::register::ANGLE_LIMITS,
    mode_bytes: 4,
    ready_mode: [0; 4],
    level: protocol1::register::STATUS_RETURN_LEVEL,
    torque: protocol1::register::TORQUE_ENABLE,
    reads: &[(
        protocol1::register::RETURN_DELAY,
        protocol1::register::TORQUE_ENABLE + 1 - protocol1::register::RETURN_DELAY,
    )],
};

const X: Registers = Registers {
    return_delay: protocol2::register::RETURN_DELAY,
    ready_delay: (protocol2::RETURN_DELAY_US / 2) as u8,
    mode: protocol2::register::OPERATING_MODE,
    mode_bytes: 1,
    ready_mode: [OperatingMode::Pwm.code(), 0, 0, 0],
    level: protocol2::register::STATUS_RETURN_LEVEL,
    torque: protocol2::register::TORQUE_ENABLE,
    // Return delay, drive mode and operating mode are neighbours.
    reads: &[
        (protocol2::register::RETURN_DELAY, 3),
        (protocol2::register::TORQUE_ENABLE, 1),
        (protocol2::register::STATUS_RETURN_LEVEL, 1),
        (protocol2::register::BUS_WATCHDOG, 1),
        (protocol2::register::GOAL_PWM, 2),
    ],
};

impl Registers {
    /// Those of a firmware; Morpheus needs no set-up.
    fn of(firmware: Firmware) -> Option<&'static Self> {
        match firmware {
            Firmware::Morpheus => None,
            Firmware::Stock => Some(&AX12A),
            Firmware::XSeries => Some(&X),
        }
    }
}

/// Registers of one servo as they are read piece by piece, from address 0 on.
#[derive(Clone, Copy, Debug)]
pub(super) struct RegisterImage([u8; IMAGE_BYTES]);

impl Default for RegisterImage {
    fn default() -> Self {
        Self([0; IMAGE_BYTES])
    }
}

impl RegisterImage {
    /// Takes the data of a read from this address on.
    pub(super) fn store(&mut self, address: u16, data: &[u8]) {
        let start = usize::from(address);
        if let Some(bytes) = self.0.get_mut(start..start + data.len()) {
            bytes.copy_from_slice(data);
        }
    }
}

/// Settings of a servo that the bridge changes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct ServoSettings {
    firmware: Firmware,
    return_delay: u8,
    /// Angle limits, or the operating mode.
    mode: [u8; 4],
    /// Torque limit at power-up of a stock servo.
    max_torque: [u8; 2],
    /// Status return level.
    level: u8,
    /// Torque enable, which is no setting.
    torque: u8,
    /// The watchdog of an X servo and its goal PWM, which are none either.
    watchdog: u8,
    goal_pwm: [u8; 2],
}

impl ServoSettings {
    /// Decodes the registers, once all are read.
    pub(super) fn decode(firmware: Firmware, image: &RegisterImage) -> Option<Self> {
        let registers = Registers::of(firmware)?;
        let from = |address: u16| image.0.get(usize::from(address)..);
        let byte = |address: u16| from(address)?.first().copied();
        let mut mode = [0; 4];
        let bytes = from(registers.mode)?.get(..registers.mode_bytes)?;
        mode.get_mut(..registers.mode_bytes)?.copy_from_slice(bytes);
        let is_stock = firmware == Firmware::Stock;
        Some(Self {
            firmware,
            return_delay: byte(registers.return_delay)?,
            mode,
            max_torque: if is_stock {
                *from(protocol1::register::MAX_TORQUE)?.first_chunk()?
            } else {
                [0; 2]
            },
            level: byte(registers.level)?,
            torque: byte(registers.torque)?,
            watchdog: if is_stock {
                WATCHDOG
            } else {
                byte(protocol2::register::BUS_WATCHDOG)?
            },
            goal_pwm: if is_stock {
                [0; 2]
            } else {
                *from(protocol2::register::GOAL_PWM)?.first_chunk()?
            },
        })
    }

    /// Whether the servo takes torque with these settings.
    pub(super) fn are_ready(self) -> bool {
        Registers::of(self.firmware).is_some_and(|registers| {
            self.return_delay == registers.ready_delay
                && self.mode == registers.ready_mode
                && self.level > 0
        })
    }

    /// Whether torque can be enabled without a motion.
    pub(super) fn are_safe(self) -> bool {
        self.are_ready() && self.watchdog == WATCHDOG && self.goal_pwm == [0; 2]
    }

    /// Whether it would obey a torque now.
    pub(super) fn are_in_force(self) -> bool {
        self.are_ready() && self.torque == 1 && self.watchdog == WATCHDOG
    }
}

/// Settings of a joint's servo.
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
    /// Index of the read, of a step that reads.
    pub(super) read: u8,
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
    /// Writes what selects open-loop control: the angle limits, or the operating mode.
    Mode,
    ReturnDelay,
    /// Ends the watchdog of an X servo, and the lock of its goals by one that has switched off.
    WatchdogOff,
    /// Writes moving speed 0 and the torque limit, or goal PWM 0.
    ZeroDuty,
    /// Starts the watchdog of an X servo.
    Watchdog,
    /// Reads the settings of an X servo before torque is enabled: a change of the operating mode
    /// has set its goal PWM to the largest.
    Confirm,
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
            Self::EnableReplies | Self::Mode | Self::ReturnDelay | Self::StatusLevel => true,
            Self::Read
            | Self::Reread
            | Self::WatchdogOff
            | Self::ZeroDuty
            | Self::Watchdog
            | Self::Confirm
            | Self::TorqueOn
            | Self::TorqueOff
            | Self::Verify => false,
        }
    }
}

/// Access to registers of one servo.
pub(super) enum RegisterAccess {
    /// First address, and number of bytes.
    Read(u16, u16),
    Write(u16, Vec<u8, 4>),
}

impl SetupStep {
    pub(super) const READ: Self = Self {
        goal: SetupGoal::Read,
        joint: 0,
        step: Step::Read,
        read: 0,
        repeats: 0,
    };
    pub(super) const PREPARE: Self = Self {
        goal: SetupGoal::Prepare,
        joint: 0,
        step: Step::TorqueOff,
        read: 0,
        repeats: 0,
    };
    pub(super) const RESTORE: Self = Self {
        goal: SetupGoal::Restore,
        joint: 0,
        step: Step::TorqueOff,
        read: 0,
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
            read: 0,
            repeats: self.repeats + 1,
            ..self
        })
    }

    /// The next read of this step; `None` after the last.
    pub(super) fn next_read(self, firmware: Firmware) -> Option<Self> {
        let read = self.read + 1;
        let reads = Registers::of(firmware)?.reads;
        (usize::from(read) < reads.len()).then_some(Self { read, ..self })
    }

    /// The step after this one; `None` after the last.
    pub(super) fn after(self) -> Option<Self> {
        use Step::{
            Confirm, EnableReplies, Mode, Read, Reread, ReturnDelay, StatusLevel, TorqueOff,
            TorqueOn, Verify, Watchdog, WatchdogOff, ZeroDuty,
        };
        let of_this = |step| Some((self.joint, step));
        let of_next = |step| (self.joint + 1 < JOINTS).then_some((self.joint + 1, step));
        let (joint, step) = match (self.goal, self.step) {
            (_, EnableReplies) => of_this(Reread),
            // An EEPROM is written with torque off.
            (_, TorqueOff) => of_this(Mode),
            (_, Mode) => of_this(ReturnDelay),
            (SetupGoal::Restore, ReturnDelay) => of_this(StatusLevel),
            // No servo has torque while the board waits for the EEPROM of another.
            (_, ReturnDelay) => of_next(TorqueOff).or(Some((0, WatchdogOff))),
            (SetupGoal::Restore, WatchdogOff) => of_next(TorqueOff),
            (_, WatchdogOff) => of_this(ZeroDuty),
            (_, ZeroDuty) => of_this(Watchdog),
            (_, Watchdog) => of_this(Confirm),
            (_, Confirm) => of_this(TorqueOn),
            (_, TorqueOn) => of_this(Verify),
            (_, Verify) => of_next(WatchdogOff),
            (_, StatusLevel) => of_this(WatchdogOff),
            (_, Read | Reread) => of_next(Read),
        }?;
        Some(Self {
            joint,
            step,
            read: 0,
            ..self
        })
    }

    /// Settings that the goal requires: ready, or as found.
    fn target(self, registers: &Registers, saved: &SavedConfig) -> Option<ServoSettings> {
        match self.goal {
            SetupGoal::Read => saved.now,
            SetupGoal::Prepare => Some(ServoSettings {
                return_delay: registers.ready_delay,
                mode: registers.ready_mode,
                level: saved.now?.level.max(LEVEL_READ),
                ..saved.now?
            }),
            SetupGoal::Restore => saved.before,
        }
    }

    /// The register access of this step; `None` if there is nothing to do.
    pub(super) fn access(self, firmware: Firmware, saved: &SavedConfig) -> Option<RegisterAccess> {
        let registers = Registers::of(firmware)?;
        let write = |address, data: &[u8]| {
            Vec::from_slice(data)
                .ok()
                .map(|data| RegisterAccess::Write(address, data))
        };
        let write_watchdog = |value| match firmware {
            Firmware::Morpheus | Firmware::Stock => None,
            Firmware::XSeries => write(protocol2::register::BUS_WATCHDOG, &[value]),
        };
        match self.step {
            Step::Confirm if firmware != Firmware::XSeries => None,
            Step::Read | Step::Reread | Step::Confirm | Step::Verify => {
                let (address, count) = *registers.reads.get(usize::from(self.read))?;
                Some(RegisterAccess::Read(address, count))
            }
            Step::EnableReplies => write(registers.level, &[LEVEL_READ]),
            Step::WatchdogOff => write_watchdog(0),
            Step::Watchdog => write_watchdog(WATCHDOG),
            Step::ZeroDuty => match firmware {
                Firmware::Morpheus => None,
                // The torque limit is the next register: a shutdown has left it at 0.
                Firmware::Stock => {
                    let [low, high] = saved.now?.max_torque;
                    write(protocol1::register::MOVING_SPEED, &[0, 0, low, high])
                }
                Firmware::XSeries => write(protocol2::register::GOAL_PWM, &[0, 0]),
            },
            Step::TorqueOn => write(registers.torque, &[1]),
            Step::TorqueOff => write(registers.torque, &[0]),
            Step::Mode | Step::ReturnDelay | Step::StatusLevel => {
                let (now, target) = (saved.now?, self.target(registers, saved)?);
                match self.step {
                    Step::Mode if now.mode != target.mode => {
                        write(registers.mode, target.mode.get(..registers.mode_bytes)?)
                    }
                    Step::ReturnDelay if now.return_delay != target.return_delay => {
                        write(registers.return_delay, &[target.return_delay])
                    }
                    Step::StatusLevel if now.level != target.level => {
                        write(registers.level, &[target.level])
                    }
                    _ => None,
                }
            }
        }
    }
}

impl RegisterAccess {
    /// The query to the servo `id`.
    pub(super) fn query(&self, firmware: Firmware, id: u8) -> Option<Query> {
        match self {
            Self::Read(address, count) => firmware.read_query(id, *address, *count),
            Self::Write(address, data) => firmware.write_query(id, *address, data),
        }
    }
}
