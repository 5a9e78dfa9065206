//! Set-up steps of stock and X servos: their order, and the register access of each.

use heapless::Vec;

use super::servo_settings::{LEVEL_READ, Reads, Registers, ServoSettings, XRequirements};
use armbridge_servo::protocol2::model;
use armbridge_servo::{ControlMode, Firmware, JOINTS, Query, protocol1, protocol2};

/// Most repetitions of the steps of servos that are not ready after them: a write was lost,
/// or a reply.
const REPEATS_MAX: u8 = 3;

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
    /// Writes what selects open-loop control: the angle limits, or drive mode and operating mode.
    Mode,
    ReturnDelay,
    /// Ends the watchdog of an X servo, and the lock of its goals by one that has switched off.
    WatchdogOff,
    /// Writes moving speed 0 and the torque limit, or goal PWM or goal current 0.
    ZeroGoal,
    /// Starts the watchdog of an X servo.
    Watchdog,
    /// Reads the settings of an X servo before torque is enabled: a change of the operating mode
    /// has set its goals to the largest.
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
            | Self::ZeroGoal
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

    /// The next one of the reads of this step; `None` after the last.
    pub(super) fn next_read(self, reads: Reads) -> Option<Self> {
        let read = self.read + 1;
        (usize::from(read) < reads.len()).then_some(Self { read, ..self })
    }

    /// What this step reads. At first only what every model has.
    pub(super) fn reads(self, firmware: Firmware, mode: ControlMode) -> Option<Reads> {
        let mode = match self.step {
            Step::Read | Step::Reread => ControlMode::Pwm,
            _ => mode,
        };
        Some(Registers::of(firmware, mode)?.reads)
    }

    /// The step after this one; `None` after the last.
    pub(super) fn after(self) -> Option<Self> {
        use Step::{
            Confirm, EnableReplies, Mode, Read, Reread, ReturnDelay, StatusLevel, TorqueOff,
            TorqueOn, Verify, Watchdog, WatchdogOff, ZeroGoal,
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
            (_, WatchdogOff) => of_this(ZeroGoal),
            (_, ZeroGoal) => of_this(Watchdog),
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
    fn target(self, saved: &SavedConfig, required: XRequirements) -> Option<ServoSettings> {
        match self.goal {
            SetupGoal::Read => saved.now,
            SetupGoal::Prepare => saved.now?.made_ready(required),
            SetupGoal::Restore => saved.before,
        }
    }

    /// The register access of this step; `None` if there is nothing to do.
    pub(super) fn access(
        self,
        firmware: Firmware,
        saved: &SavedConfig,
        required: XRequirements,
    ) -> Option<RegisterAccess> {
        let registers = Registers::of(firmware, required.mode)?;
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
                let reads = self.reads(firmware, required.mode)?;
                let (address, count) = *reads.get(usize::from(self.read))?;
                Some(RegisterAccess::Read(address, count))
            }
            Step::EnableReplies => write(registers.level, &[LEVEL_READ]),
            Step::WatchdogOff => write_watchdog(0),
            Step::Watchdog => write_watchdog(required.watchdog),
            Step::ZeroGoal => match (firmware, required.mode) {
                (Firmware::Morpheus, _) => None,
                // The torque limit is the next register: a shutdown has left it at 0.
                (Firmware::Stock, _) => {
                    let [low, high] = saved.now?.max_torque;
                    write(protocol1::register::MOVING_SPEED, &[0, 0, low, high])
                }
                (_, ControlMode::Pwm) => write(protocol2::register::GOAL_PWM, &[0, 0]),
                // The goal PWM is the largest duty then, and the goal current the next register.
                (_, ControlMode::Current) => {
                    let [low, high] = model::FULL.to_le_bytes();
                    write(protocol2::register::GOAL_PWM, &[low, high, 0, 0])
                }
            },
            Step::TorqueOn => write(registers.torque, &[1]),
            Step::TorqueOff => write(registers.torque, &[0]),
            Step::Mode | Step::ReturnDelay | Step::StatusLevel => {
                let (now, target) = (saved.now?, self.target(saved, required)?);
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
