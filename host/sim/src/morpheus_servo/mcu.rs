//! The microcontroller: the main loop, its interrupts and its clock.
//!
//! The firmware is one endless loop that looks for a message, executes it, and
//! every seventh turn ticks a timer; every eleventh tick starts a conversion,
//! whose result the next tick turns into a PWM. Bytes are received by an
//! interrupt that stretches the present stage of the loop. EEPROM writes run with
//! interrupts off.
//!
//! The loop is not executed turn by turn. It is a chain of [`Stage`]s, each
//! ending at a known cycle; an interrupt moves the end of the stage it falls
//! into. Idle turns up to the next tick are one stage, cut short when a
//! message is complete.

use std::collections::VecDeque;

use super::control::{Control, Gains};
use super::converter::Converter;
use super::receiver::Inbox;
use super::registers::{self, ROM_SIZE, Requests};
use super::state::{Bus, Job, Stage};
use super::uart::Uart;
use super::{Action, cycle_costs};

/// Size of the firmware's transmit buffer.
const TRANSMIT_BUFFER: usize = 200;
/// The bit clock at power-up, modulo one bit at 1 Mbaud.
const BIT_CLOCK_PHASE: u64 = 14;

/// Task of the running interrupt handler.
#[derive(Debug, Clone, Copy)]
enum Handling {
    Nothing,
    Byte(u8),
    Conversion,
}

#[derive(Debug, Clone)]
pub(super) struct Mcu {
    pub(super) stage: Stage,
    pub(super) stage_end: u64,
    /// Whole idle turns inside the current stage.
    pub(super) idle_turns: u8,
    /// Turns until the next tick.
    pub(super) turns_left: u8,
    handling: Handling,
    /// End of the running interrupt handler, or of the last one.
    handler_end: u64,

    pub(super) uart: Uart,
    pub(super) inbox: Inbox,
    pub(super) transmit: VecDeque<u8>,
    pub(super) driving: bool,

    pub(super) converter: Converter,
    pub(super) control: Control,
    pub(super) rom: [u8; ROM_SIZE],
    pub(super) rom_ready: u64,
    /// Variables loaded from the EEPROM.
    pub(super) id: u8,
    pub(super) baud: u8,
    pub(super) gains: Gains,
    pub(super) requests: Requests,

    pub(super) job: Job,
    /// The interpreter's working memory; stale contents show in replies to
    /// requests without arguments.
    pub(super) scratch: [u8; 256],
    pub(super) message_length: u8,
    /// Turns of a runaway WRITE inside the current stage.
    pub(super) runaway_turns: u16,
    pub(super) reply: VecDeque<u8>,
    pub(super) bus: Bus,
    pub(super) predecessor: u8,
    pub(super) predecessors: u8,
    pub(super) cycle_pending: bool,
    pub(super) master: u8,
    pub(super) delay_ticks: u16,
}

impl Mcu {
    /// Powered up at cycle `now` with this EEPROM.
    pub(super) fn new(now: u64, rom: [u8; ROM_SIZE]) -> Self {
        let mut mcu = Self {
            stage: Stage::Load { restored: 0 },
            stage_end: now + cycle_costs::BOOT,
            idle_turns: 0,
            turns_left: 0,
            handling: Handling::Nothing,
            handler_end: now,
            uart: Uart::new(now + BIT_CLOCK_PHASE, 1),
            inbox: Inbox::new(),
            transmit: VecDeque::new(),
            driving: false,
            converter: Converter::new(now),
            control: Control::new(),
            rom,
            rom_ready: now,
            id: 0,
            baud: 1,
            gains: Gains::default(),
            requests: Requests::default(),
            job: Job::Boot,
            scratch: [0; 256],
            message_length: 0,
            runaway_turns: 0,
            reply: VecDeque::new(),
            bus: Bus::Unknown,
            predecessor: 0,
            predecessors: 0,
            cycle_pending: false,
            master: 0,
            delay_ticks: 0,
        };
        if rom[0] == registers::MARKER_VALID {
            mcu.load_variables();
            mcu.uart = Uart::new(now + BIT_CLOCK_PHASE, mcu.baud);
            mcu.stage = Stage::Tick;
        }
        mcu
    }

    /// A long operation, during which the servo neither receives nor replies.
    pub(super) fn busy(&self) -> bool {
        !self.interrupts_on() || self.runaway()
    }

    fn interrupts_on(&self) -> bool {
        !matches!(
            self.stage,
            Stage::Store { .. } | Stage::Load { .. } | Stage::Loaded | Stage::Reset
        )
    }

    /// The receiver is set up at the end of the start-up.
    pub(super) fn listening(&self) -> bool {
        self.job != Job::Boot
    }

    fn interrupt_at(&self) -> u64 {
        let pending = self.uart.has_byte() || self.converter.interrupts();
        let handling = !matches!(self.handling, Handling::Nothing);
        if pending && !handling && self.interrupts_on() {
            self.handler_end
        } else {
            u64::MAX
        }
    }

    /// The cycle of the next event inside.
    pub(super) fn next_event(&self) -> u64 {
        self.stage_end
            .min(self.interrupt_at())
            .min(self.converter.result_at())
            .min(self.handled_at())
    }

    /// Makes the event due at `now` happen.
    pub(super) fn step(&mut self, now: u64) -> Option<Action> {
        if self.handled_at() <= now {
            self.handled();
            return None;
        }
        if self.converter.result_at() <= now {
            self.converter.finish();
            return Some(Action::Convert);
        }
        if self.interrupt_at() <= now {
            self.interrupt(now);
            return None;
        }
        self.run(now)
    }

    /// An interrupt handler starts. It delays the main loop at once, and its
    /// effects are there shortly before it ends.
    fn interrupt(&mut self, now: u64) {
        let mut cost = cycle_costs::INTERRUPT;
        self.handling = if let Some(byte) = self.uart.take() {
            cost += self.inbox.cost(byte, self.id);
            Handling::Byte(byte)
        } else {
            cost += cycle_costs::CONVERTED;
            Handling::Conversion
        };
        self.handler_end = now + cost;
        self.stage_end += cost;
    }

    fn handled_at(&self) -> u64 {
        if matches!(self.handling, Handling::Nothing) {
            u64::MAX
        } else {
            self.handler_end - cycle_costs::HANDLER_RETURN
        }
    }

    fn handled(&mut self) {
        match std::mem::replace(&mut self.handling, Handling::Nothing) {
            Handling::Nothing => {}
            Handling::Byte(byte) => {
                if let Some(pwm) = self.inbox.push(byte, self.id) {
                    self.requests.pwm_sync = pwm;
                }
                self.cut_runaway(self.handler_end);
                self.cut_idle_turns(self.handler_end);
            }
            Handling::Conversion => {
                self.converter.acknowledge();
            }
        }
    }

    pub(super) fn go(&mut self, stage: Stage, end: u64) -> Option<Action> {
        self.stage = stage;
        self.stage_end = end;
        None
    }

    fn run(&mut self, now: u64) -> Option<Action> {
        match self.stage {
            Stage::Look => self.look(now),
            Stage::Tick => self.tick(now),
            Stage::Sample => self.sample(now),
            Stage::Control => {
                self.after_tick(now);
                Some(Action::Pwm(self.control.applied))
            }
            Stage::Feed => self.feed(now),
            Stage::Release => {
                self.driving = false;
                self.uart.clear_ran_empty(now);
                self.go(Stage::Look, now + cycle_costs::RELEASE_TO_LOOK);
                Some(Action::Release)
            }
            _ => self.obey(now),
        }
    }

    /// Puts a packet into the transmit buffer.
    pub(super) fn send_reply(&mut self) {
        while let Some(byte) = self.reply.pop_front() {
            if self.transmit.len() < TRANSMIT_BUFFER {
                self.transmit.push_back(byte);
            }
        }
    }

    pub(super) fn load_variables(&mut self) {
        self.id = self.rom[1];
        self.baud = self.rom[10];
        self.gains = registers::gains(&self.rom);
    }
}
