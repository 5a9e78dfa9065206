//! Stock servos made ready for torque, and given back as they were.
//!
//! Bring-up only looks at stock servos. Everything else is asked for, by
//! [`Command::Prepare`](crate::link::message::Command::Prepare) and
//! [`Command::Release`](crate::link::message::Command::Release): whoever plugs the
//! bridge in to use its transparent port finds the servos as they were.
//!
//! A stock AX-12A has no torque command. In wheel mode (both angle limits 0) its
//! moving speed is the motor's duty, which is as good. Its return delay, 500 µs
//! ex works, would take the half of a tick for each servo. Both are EEPROM, so
//! they are written only where they differ, and what was found is remembered for
//! the release, until reset.

use embedded_hal::digital::OutputPin;
use embedded_hal_nb::serial::{Read, Write};
use heapless::Vec;

use super::mailbox::Notice;
use super::schedule::Stage;
use super::{Bridge, SERVO_IDS};
use crate::JOINTS;
use crate::link::message::Missing;
use crate::servo::Firmware;
use crate::servo::Packet;
use crate::servo::master::Asked;
use crate::servo::master::timing::{RETURN_DELAY_US, latency_us};
use crate::servo::port::SetBaud;
use crate::servo::protocol1::{Instruction, register};

/// How long a servo is left alone after a write to its EEPROM, in µs. The e-Manual
/// does not say how long it is busy; an `ATmega8`, which AX-12A have had, takes
/// 8.5 ms a byte, and four are the most that is written here.
const EEPROM_US: u64 = 40_000;

/// From the return delay to the status return level: what is read at once.
const SETTINGS_BYTES: u8 = register::STATUS_RETURN_LEVEL - register::RETURN_DELAY + 1;
/// [`RETURN_DELAY_US`] in the register's unit.
const RETURN_DELAY: u8 = (RETURN_DELAY_US / 2) as u8;
const WHEEL: [u8; 4] = [0; 4];
/// READ is answered, WRITE is not: the least that a tick needs.
const LEVEL_READ: u8 = 1;

/// What the bridge changes in a stock servo's EEPROM.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Settings {
    return_delay: u8,
    limits: [u8; 4],
    /// What the torque limit is at power-up.
    max_torque: [u8; 2],
    level: u8,
}

impl Settings {
    fn of(memory: &[u8]) -> Option<Self> {
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

    fn are_ready(self) -> bool {
        self.return_delay == RETURN_DELAY && self.limits == WHEEL && self.level > 0
    }
}

/// What is known of a joint's stock servo.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Stock {
    /// As found at first.
    before: Option<Settings>,
    /// As read last.
    now: Option<Settings>,
}

/// Something to be done with the stock servos, one after the other.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Chore {
    purpose: Purpose,
    joint: usize,
    step: Step,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Purpose {
    /// To see what they are set to.
    Look,
    /// Ready for torque.
    Prepare,
    /// As they were found.
    Restore,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Step {
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
    fn is_kept(self) -> bool {
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
enum Errand {
    Read,
    Write(u8, Vec<u8, 4>),
}

impl Chore {
    pub(super) const LOOK: Self = Self {
        purpose: Purpose::Look,
        joint: 0,
        step: Step::Look,
    };
    pub(super) const PREPARE: Self = Self {
        purpose: Purpose::Prepare,
        joint: 0,
        step: Step::TorqueOff,
    };
    pub(super) const RESTORE: Self = Self {
        purpose: Purpose::Restore,
        joint: 0,
        step: Step::TorqueOff,
    };

    /// The step after this one; `None` after the last joint's last.
    fn after(self) -> Option<Self> {
        use Step::{
            Check, Delay, Level, Look, LookAgain, MakeItAnswer, Mode, Standstill, TorqueOff,
            TorqueOn,
        };
        let step = match (self.purpose, self.step) {
            (_, MakeItAnswer) => Some(LookAgain),
            // An EEPROM is written with torque off.
            (_, TorqueOff) => Some(Mode),
            (_, Mode) => Some(Delay),
            (Purpose::Restore, Delay) => Some(Level),
            (_, Delay) => Some(Standstill),
            (_, Standstill) => Some(TorqueOn),
            (_, TorqueOn) => Some(Check),
            (_, Check | Level | Look | LookAgain) => None,
        };
        match (step, self.purpose) {
            (Some(step), _) => Some(Self { step, ..self }),
            (None, _) if self.joint + 1 >= JOINTS => None,
            (None, purpose) => Some(Self {
                joint: self.joint + 1,
                ..match purpose {
                    Purpose::Look => Self::LOOK,
                    Purpose::Prepare => Self::PREPARE,
                    Purpose::Restore => Self::RESTORE,
                }
            }),
        }
    }

    /// What the servo shall be set to: ready, or as it was found.
    fn wanted(self, stock: &Stock) -> Option<Settings> {
        match self.purpose {
            Purpose::Look => stock.now,
            Purpose::Prepare => Some(Settings {
                return_delay: RETURN_DELAY,
                limits: WHEEL,
                level: stock.now?.level.max(LEVEL_READ),
                ..stock.now?
            }),
            Purpose::Restore => stock.before,
        }
    }

    /// What this step asks; `None` if there is nothing to do.
    fn errand(self, stock: &Stock) -> Option<Errand> {
        let write = |address, data: &[u8]| {
            Vec::from_slice(data)
                .ok()
                .map(|d| Errand::Write(address, d))
        };
        match self.step {
            Step::Look | Step::LookAgain | Step::Check => Some(Errand::Read),
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

impl Errand {
    fn packet(&self, id: u8) -> Option<(Packet, u8)> {
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

impl<S, D> Bridge<'_, S, D>
where
    S: Read<u8> + Write<u8> + SetBaud,
    D: OutputPin,
{
    /// Does this chore's request, or the next that has one.
    pub(super) fn do_chore(&mut self, mut chore: Chore) {
        loop {
            let stock = self.stock.get(chore.joint).copied().unwrap_or_default();
            let id = SERVO_IDS.get(chore.joint).map_or(0, |id| id.get());
            let errand = chore.errand(&stock);
            if let Some((packet, reply_bytes)) = errand.and_then(|errand| errand.packet(id)) {
                let asked = Asked {
                    id,
                    reply_bytes,
                    latency_us: latency_us(Firmware::Stock),
                };
                self.stage = Stage::Settle(chore);
                // Idle was just seen, and our own packets are short.
                let _ = self.master.ask(&packet, asked, self.now_us);
                return;
            }
            let Some(next) = chore.after() else {
                self.chores_done(chore);
                return;
            };
            chore = next;
        }
    }

    /// A chore's request has been answered, or not.
    pub(super) fn finish_chore(&mut self, chore: Chore) {
        let settings = self
            .master
            .reply()
            .and_then(|reply| Settings::of(&reply.data));
        let next = match (chore.step, settings) {
            (Step::Look | Step::LookAgain | Step::Check, Some(settings)) => {
                if let Some(stock) = self.stock.get_mut(chore.joint) {
                    stock.now = Some(settings);
                    if !settings.are_ready() {
                        stock.before = Some(settings);
                    }
                }
                if chore.step == Step::Check && !settings.are_ready() {
                    let _ = self
                        .end
                        .notices
                        .enqueue(Notice::Unprepared(chore.joint as u8));
                    self.search_again();
                    return;
                }
                chore.after()
            }
            // Status return level 0: READ is not answered.
            (Step::Look, None) => Some(Chore {
                step: Step::MakeItAnswer,
                ..chore
            }),
            (Step::LookAgain | Step::Check, None) => {
                self.report_absent(chore.joint, Missing::Silence);
                return;
            }
            (
                Step::MakeItAnswer
                | Step::Mode
                | Step::Delay
                | Step::Standstill
                | Step::TorqueOn
                | Step::TorqueOff
                | Step::Level,
                _,
            ) => chore.after(),
        };
        if chore.step.is_kept() {
            self.next_start_us = self.now_us + EEPROM_US;
        }
        match next {
            Some(next) => self.stage = Stage::Settle(next),
            None => self.chores_done(chore),
        }
    }

    fn chores_done(&mut self, chore: Chore) {
        match chore.purpose {
            Purpose::Look => self.begin_ticking(),
            Purpose::Prepare => {
                self.master.set_prepared(true);
                self.begin_ticking();
            }
            Purpose::Restore => {
                self.stock = [Stock::default(); JOINTS];
                self.stage = Stage::Released;
            }
        }
    }
}
