//! The microcontroller: the main loop, its interrupts and its clock.
//!
//! The firmware is one endless loop that polls for a message, executes it, and
//! every seventh turn ticks a timer; every eleventh tick starts a conversion,
//! from whose result the next tick computes a PWM. Bytes are received by an
//! interrupt that stretches the present stage of the loop. EEPROM writes run with
//! interrupts off.
//!
//! The loop is not executed turn by turn. It is a sequence of [`Stage`]s, each
//! ending at a known cycle; an interrupt delays the end of the stage in which it
//! occurs. Idle turns up to the next tick are one stage, which ends early when a
//! message is complete.

use std::collections::VecDeque;

use super::control::{Control, Gains};
use super::converter::Converter;
use super::receiver::Receiver;
use super::registers::{self, ROM_SIZE, Requests};
use super::state::{CycleState, Job, Stage};
use super::uart::Uart;
use super::{Action, cycle_costs};

/// Size of the firmware's transmit buffer.
const TRANSMIT_BUFFER: usize = 200;
/// The bit clock at power-up, modulo one bit at 1 Mbaud.
const BIT_CLOCK_PHASE: u64 = 14;

/// The running interrupt handler.
#[derive(Debug, Clone, Copy)]
enum Handler {
    None,
    Receive(u8),
    Conversion,
}

/// An event of the microcontroller. Of several at one cycle, the first of these precedes.
#[derive(Debug, Clone, Copy)]
pub(super) enum Due {
    /// The running handler takes effect.
    HandlerEffect,
    /// A conversion ends.
    Conversion,
    /// A handler starts.
    Interrupt,
    /// The stage of the main loop ends.
    Stage,
}

/// State of the microcontroller.
#[derive(Debug, Clone)]
pub(super) struct Mcu {
    pub(super) stage: Stage,
    pub(super) stage_end: u64,
    /// Whole idle turns inside the current stage.
    pub(super) idle_turns: u8,
    /// Turns until the next tick.
    pub(super) turns_left: u8,
    handler: Handler,
    /// End of the running interrupt handler, or of the last one.
    handler_end: u64,

    pub(super) uart: Uart,
    pub(super) receiver: Receiver,
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
    /// Working memory of the interpreter; its stale contents appear in replies to
    /// requests without arguments.
    pub(super) scratch: [u8; 256],
    pub(super) message_length: u8,
    /// Turns of a runaway WRITE inside the current stage.
    pub(super) runaway_turns: u16,
    pub(super) reply: VecDeque<u8>,
    pub(super) cycle_state: CycleState,
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
            stage: Stage::LoadEeprom { restored: 0 },
            stage_end: now + cycle_costs::BOOT,
            idle_turns: 0,
            turns_left: 0,
            handler: Handler::None,
            handler_end: now,
            uart: Uart::new(now + BIT_CLOCK_PHASE, 1),
            receiver: Receiver::new(),
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
            cycle_state: CycleState::NotStarted,
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

    /// Whether a long operation runs, during which the servo neither receives nor replies.
    pub(super) fn busy(&self) -> bool {
        !self.interrupts_on() || self.runaway()
    }

    pub(super) fn interrupts_on(&self) -> bool {
        !matches!(
            self.stage,
            Stage::StoreByte { .. }
                | Stage::LoadEeprom { .. }
                | Stage::EepromLoaded
                | Stage::ClearMarker
        )
    }

    /// Whether the receiver is set up, at the end of the start-up.
    pub(super) fn listening(&self) -> bool {
        self.job != Job::Boot
    }

    fn interrupt_at(&self) -> u64 {
        let pending = self.uart.has_byte() || self.converter.interrupts();
        let handler = !matches!(self.handler, Handler::None);
        if pending && !handler && self.interrupts_on() {
            self.handler_end
        } else {
            u64::MAX
        }
    }

    /// Cycle of the next internal event.
    pub(super) fn next_event(&self) -> u64 {
        self.next_due(0).0
    }

    /// Cycle at which a handler starts or takes effect.
    pub(super) fn interrupted_at(&self) -> u64 {
        self.interrupt_at().min(self.handler_effect_at())
    }

    /// The next internal event, and its cycle, which is `now` if it is overdue.
    pub(super) fn next_due(&self, now: u64) -> (u64, Due) {
        let mut next = (self.handler_effect_at().max(now), Due::HandlerEffect);
        for (at, due) in [
            (self.converter.result_at(), Due::Conversion),
            (self.interrupt_at(), Due::Interrupt),
            (self.stage_end, Due::Stage),
        ] {
            let at = at.max(now);
            if at < next.0 {
                next = (at, due);
            }
        }
        next
    }

    /// Executes the event due at `now`.
    pub(super) fn step(&mut self, now: u64) -> Option<Action> {
        self.execute_due(self.next_due(now).1, now)
    }

    /// Executes an event at `now`.
    pub(super) fn execute_due(&mut self, due: Due, now: u64) -> Option<Action> {
        match due {
            Due::HandlerEffect => self.finish_handler(),
            Due::Conversion => {
                self.converter.finish();
                return Some(Action::Convert);
            }
            Due::Interrupt => self.start_handler(now),
            Due::Stage => return self.run(now),
        }
        None
    }

    /// Starts an interrupt handler. It delays the main loop at once, and takes effect
    /// shortly before it ends.
    fn start_handler(&mut self, now: u64) {
        let mut cost = cycle_costs::INTERRUPT;
        self.handler = if let Some(byte) = self.uart.take() {
            cost += self.receiver.cost(byte, self.id);
            Handler::Receive(byte)
        } else {
            cost += cycle_costs::CONVERTED;
            Handler::Conversion
        };
        self.handler_end = now + cost;
        self.stage_end += cost;
    }

    /// Whether the running handler is that of a received byte.
    pub(super) fn handles_byte(&self) -> bool {
        matches!(self.handler, Handler::Receive(_))
    }

    /// Cycle at which the running handler takes effect.
    fn handler_effect_at(&self) -> u64 {
        if matches!(self.handler, Handler::None) {
            u64::MAX
        } else {
            self.handler_end - cycle_costs::HANDLER_RETURN
        }
    }

    fn finish_handler(&mut self) {
        match std::mem::replace(&mut self.handler, Handler::None) {
            Handler::None => {}
            Handler::Receive(byte) => {
                if let Some(pwm) = self.receiver.push(byte, self.id) {
                    self.requests.pwm_sync = pwm;
                }
                self.shorten_runaway(self.handler_end);
                self.shorten_idle_turns(self.handler_end);
            }
            Handler::Conversion => {
                self.converter.acknowledge();
            }
        }
    }

    /// Enters a stage that ends at cycle `end`.
    pub(super) fn enter(&mut self, stage: Stage, end: u64) -> Option<Action> {
        self.stage = stage;
        self.stage_end = end;
        None
    }

    pub(super) fn run(&mut self, now: u64) -> Option<Action> {
        match self.stage {
            Stage::PollMessages => self.poll_messages(now),
            Stage::Tick => self.tick(now),
            Stage::ReadConverter => self.sample(now),
            Stage::ApplyPwm => {
                self.after_tick(now);
                Some(Action::Pwm(self.control.applied.into()))
            }
            Stage::Transmit => self.transmit_byte(now),
            Stage::ReleaseBus => {
                self.driving = false;
                self.uart.clear_ran_empty(now);
                self.enter(Stage::PollMessages, now + cycle_costs::RELEASE_TO_POLL);
                Some(Action::Release)
            }
            _ => self.execute(now),
        }
    }

    /// Moves the reply to the transmit buffer.
    pub(super) fn queue_reply(&mut self) {
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
