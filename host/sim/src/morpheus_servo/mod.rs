//! A virtual servo: an AX-12A that runs the Morpheus V1.2 firmware.
//!
//! The firmware has its own protocol (`AA LEN DEST SRC data checksum`),
//! applies PWM as commanded and has many hazards: servos stop receiving when they
//! misread each other's replies, a long packet stops command processing until
//! power-off, an EEPROM write disables reception for 8.4 ms a byte, and no timeout
//! ever stops the motor. All of these are modelled, because a master has to be tested
//! against them.
//!
//! | module        | model of                                                |
//! |---------------|---------------------------------------------------------|
//! | `uart`        | the serial port: two byte buffer, overruns, bit clock   |
//! | `receiver`    | the receive state machine and the two message buffers   |
//! | `commands`    | the commands                                            |
//! | `write`       | the commands that write registers                       |
//! | `registers`   | the EEPROM and the register map                         |
//! | `control`     | PWM, position and speed control                         |
//! | `converter`   | sampling times of position and temperature              |
//! | `mcu`         | the main loop and the interrupts in time                |
//! | `main_loop`   | one turn of the main loop: timer tick, transmitter      |
//! | `run_ahead`   | events that concern no other part of the bus            |
//! | `cycle_costs` | execution time of each part of the firmware             |
//!
//! Internal times are processor cycles of 62.5 ns, times of the interface are
//! nanoseconds. A servo acts only at events, so the result does not depend on the
//! steps in which time is advanced.

mod commands;
mod control;
mod converter;
mod cycle_costs;
mod main_loop;
mod mcu;
mod receiver;
mod registers;
mod run_ahead;
mod state;
mod uart;
mod write;

pub use receiver::ReceiverState;
pub use registers::{DEFAULT_ROM, ROM_SIZE};

use control::Mode;
use mcu::Mcu;

/// Inputs of a servo's converter, in counts, 0..=1023.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Reading {
    /// Position.
    pub position: u16,
    /// Temperature.
    pub temperature: u16,
}

/// Reason for which a servo does not answer a ping.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Deafness {
    /// Its receiver waits for the rest of a packet.
    MidPacket,
    /// It processes no packet until it is switched off and on.
    MessageStuck,
    /// It executes a long operation.
    Busy,
}

/// What a servo's motor gets, 0..=2000, 1000 = off.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct MotorDrive {
    /// The PWM on it.
    pub pwm: u16,
    /// The PWM of the same torque at rest: where a servo controls the current, the rest of the PWM
    /// balances the back-EMF of a motor that turns, also of one without torque.
    pub at_rest: u16,
}

impl From<u16> for MotorDrive {
    fn from(pwm: u16) -> Self {
        Self { pwm, at_rest: pwm }
    }
}

/// External actions of a servo.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Action {
    /// Reads the converter's inputs.
    Convert,
    /// The PWM on the motor changes.
    Pwm(MotorDrive),
    /// Switches its bus driver off.
    Release,
    /// Switches its bus driver on and sends a byte, starting at `start_ns`.
    Send { byte: u8, start_ns: u64 },
}

/// Registers and variables, for tests and displays.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct State {
    /// PWM on the motor, 0..=2000, 1000 = off.
    pub pwm: u16,
    /// Position and speed control decide the PWM.
    pub position_mode: bool,
    /// State of the receiver.
    pub receiving: ReceiverState,
    /// Bytes after which the receiver resets itself.
    pub failsafe: u8,
    /// Baud register in use.
    pub baud: u8,
    /// EEPROM registers.
    pub rom: [u8; ROM_SIZE],
    /// Position register.
    pub position: u16,
    /// Speed register: counts over 14 samples, without sign.
    pub speed: u8,
    /// Temperature register, in converter counts.
    pub temperature: u16,
    /// PWM register.
    pub pwm_requested: u16,
    /// Last PWM taken from a sync write.
    pub pwm_sync: u16,
    /// Value from which a sync write must differ to take effect.
    pub pwm_before: u16,
    /// Goal register.
    pub goal_requested: u16,
    /// Value from which a new goal must differ.
    pub goal_before: u16,
    /// Goal that position control uses.
    pub goal: u16,
    /// Speed register as written.
    pub speed_requested: u16,
    /// Speed that position control uses.
    pub goal_speed: u16,
}

/// One servo, powered up together with its wire.
#[derive(Debug, Clone)]
pub struct Servo {
    mcu: Mcu,
    connected: bool,
    overruns: u32,
}

/// Nanoseconds at processor cycle `cycle`.
fn nanoseconds(cycle: u64) -> u64 {
    match cycle {
        u64::MAX => u64::MAX,
        _ => cycle * 125 / 2,
    }
}

/// First processor cycle not before `at_ns`.
fn cycle(at_ns: u64) -> u64 {
    (at_ns * 2).div_ceil(125)
}

impl Servo {
    /// A servo with this EEPROM; see [`DEFAULT_ROM`].
    pub fn new(rom: [u8; ROM_SIZE]) -> Self {
        Self {
            mcu: Mcu::new(0, rom),
            connected: true,
            overruns: 0,
        }
    }

    /// A servo with default settings and this id.
    pub fn with_id(id: u8) -> Self {
        let mut rom = DEFAULT_ROM;
        rom[usize::from(registers::ID)] = id;
        Self::new(rom)
    }

    /// The id in its EEPROM.
    pub fn id(&self) -> u8 {
        self.mcu.rom[usize::from(registers::ID)]
    }

    /// PWM on the motor, 0..=2000, 1000 = off.
    pub fn pwm(&self) -> u16 {
        self.mcu.control.applied
    }

    /// Whether it is connected to the wire.
    pub fn connected(&self) -> bool {
        self.connected
    }

    /// Bytes lost in its receiver since power-up.
    pub fn overruns(&self) -> u32 {
        self.overruns + self.mcu.uart.overruns()
    }

    /// Reason for which it does not answer a ping now; `None` if it does.
    pub fn deafness(&self) -> Option<Deafness> {
        if self.mcu.busy() {
            Some(Deafness::Busy)
        } else if self.mcu.receiver.stuck() {
            Some(Deafness::MessageStuck)
        } else if self.mcu.receiver.state() != ReceiverState::Idle {
            Some(Deafness::MidPacket)
        } else {
            None
        }
    }

    /// Registers and variables.
    pub fn state(&self) -> State {
        let mcu = &self.mcu;
        State {
            pwm: mcu.control.applied,
            position_mode: mcu.control.mode == Mode::Position,
            receiving: mcu.receiver.state(),
            failsafe: mcu.receiver.failsafe(),
            baud: mcu.baud,
            rom: mcu.rom,
            position: mcu.control.position as u16,
            speed: mcu.control.speed as u8,
            temperature: mcu.control.temperature,
            pwm_requested: mcu.requests.pwm,
            pwm_sync: mcu.requests.pwm_sync,
            pwm_before: mcu.requests.pwm_before,
            goal_requested: mcu.requests.goal,
            goal_before: mcu.requests.goal_before,
            goal: mcu.control.goal as u16,
            speed_requested: mcu.requests.speed,
            goal_speed: mcu.control.goal_speed as u16,
        }
    }

    pub(crate) fn connect(&mut self, connected: bool) {
        self.connected = connected;
    }

    /// Power-cycles it: only the EEPROM is retained.
    pub(crate) fn power_cycle(&mut self, at_ns: u64) {
        self.overruns = self.overruns();
        self.mcu = Mcu::new(cycle(at_ns), self.mcu.rom);
    }

    /// Whether its bus driver is on, which disconnects its receiver.
    pub(crate) fn driving(&self) -> bool {
        self.mcu.driving
    }

    /// Length of one bit at its present rate.
    pub(crate) fn bit_ns(&self) -> u64 {
        nanoseconds(self.mcu.uart.bit())
    }

    /// Executes the event due at `at_ns`.
    pub(crate) fn step(&mut self, at_ns: u64) -> Option<Action> {
        self.mcu.step(cycle(at_ns))
    }

    /// Executes internal events from `now_ns` on that are before `limit_ns`.
    pub(crate) fn run_ahead(&mut self, now_ns: u64, limit_ns: u64) {
        // Twice the time must be a number.
        let limit = cycle(limit_ns.min(u64::MAX / 2));
        self.mcu.run_ahead(cycle(now_ns), limit);
    }

    /// Its next event, and a time before which it begins no byte, unless it receives another
    /// one.
    pub(crate) fn schedule(&self) -> (u64, u64) {
        let next = self.mcu.next_event();
        (nanoseconds(next), nanoseconds(self.mcu.earliest_send(next)))
    }

    /// Whether a start bit would have an effect on its receiver now.
    pub(crate) fn heeds_start_bits(&self) -> bool {
        self.mcu.uart.is_full()
    }

    pub(crate) fn converted(&mut self, reading: Reading) {
        self.mcu
            .converter
            .converted(reading.position, reading.temperature);
    }

    /// Signals a start bit to its receiver.
    pub(crate) fn start_bit(&mut self) {
        self.mcu.uart.start_bit();
    }

    /// Processes a received byte.
    pub(crate) fn receive(&mut self, byte: u8) {
        if self.mcu.listening() {
            self.mcu.uart.arrived(byte);
        }
    }
}
