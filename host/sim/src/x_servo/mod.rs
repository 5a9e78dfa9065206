//! Virtual servo: an XL430, XL330, XM430 or XC330, with Dynamixel Protocol 2.0.
//!
//! | module    | model of                                                       |
//! |-----------|----------------------------------------------------------------|
//! | `specification` | what the models differ in                                |
//! | `table`   | the control table as data                                      |
//! | `memory`  | its bytes: EEPROM, RAM, indirect addresses, write checks       |
//! | `commands` | the instructions, and their replies                           |
//! | `effects` | what follows from a write; reboot and reset                    |
//! | `chain`   | the order of several servos' replies to one instruction        |
//! | `motor`   | the operating modes: from the encoder's count to the duty      |
//! | `protect` | heat, overload and supply; the hardware errors                 |
//! | `watchdog` | the stop when the bus is silent                               |
//!
//! Transmitter and bus driver are those of `status_transmitter`.
//!
//! # Sources
//!
//! The firmware is closed. Its behaviour is taken from ROBOTIS's e-Manual ("DYNAMIXEL Protocol
//! 2.0", and the pages of the models): instructions, errors, control table, units, operating
//! modes and their resets, bus watchdog, secondary id, homing offset, shutdown, PWM slope. The
//! layout of the joint packet of a fast read, and the time for a broadcast ping, are those that
//! ROBOTIS's `DynamixelSDK` expects.
//!
//! # Assumptions
//!
//! These have no source; a master should not depend on them.
//! - A reply begins [`PROCESSING_NS`] and the return delay after the instruction, or in a chain
//!   after the packet before; a part of a fast read without the return delay, except the first. Data
//!   are read when the instruction is received.
//! - The control step has a period of a thousandth more than a millisecond, so that it slides past
//!   a master's own, and begins with a phase that depends on the id; the duty changes
//!   [`CONTROL_NS`] after the position is sampled. Sending is not held up by it.
//! - Power-up, reboot and factory reset take [`BOOT_NS`], in which nothing is received. The motor
//!   is off from their beginning.
//! - RAM is written at once (e-Manual, "Reg Write"), EEPROM after the status packet, which has the
//!   old id and rate. Two bytes of EEPROM take 140 µs, in which nothing is received: two half-words
//!   of an STM32F103's flash, of up to 70 µs each.
//! - After an operating mode change the goal PWM is the PWM limit in PWM mode too, by the letter
//!   of the e-Manual: to enable torque without another goal is full duty.
//! - With torque off a goal position follows the position.
//! - An instruction that comes before the answer to the last is sent takes its place.
//! - Parameters that do not fit are a data length error. An unknown instruction, or a damaged
//!   packet with this servo's id, is answered where the status return level has a WRITE answered.
//!   A factory reset with torque on is an access error.
//! - A packet has at most [`PACKET_MAX`] bytes, so that noise that looks like a header costs as
//!   many at most, or the time to the next pause. A part that this servo adds to a fast status
//!   packet goes through its own decoder, or it would not find the end of the packet.
//! - See also those of `chain`, `motor`, `protect` and `watchdog`.
//!
//! LED, startup configuration and backup are registers only; the supply does not sag. Duties
//! become the PWM that [`Mechanics`](super::half_duplex_bus::Mechanics) takes, 1000 for off.

mod chain;
mod commands;
mod effects;
mod memory;
mod motor;
mod protect;
mod specification;
mod table;
#[cfg(test)]
mod tests;
mod watchdog;

use armbridge_servo::protocol2::frame::STATUS;
use armbridge_servo::protocol2::model::{Model, baud_rate};
use armbridge_servo::protocol2::register as at;
use armbridge_servo::protocol2::{PacketError, Protocol2};

use super::morpheus_servo::{Action, MotorDrive, Reading};
use super::packet_receiver::PacketReceiver;
use super::status_transmitter::Transmitter;
use chain::Turn;
use commands::Packet;
use effects::Deferred;
use memory::Memory;
use motor::{Motor, Output};
use protect::Protection;

/// Longest packet in bytes.
const PACKET_MAX: usize = 512;
/// Period of the control step.
const PERIOD_NS: u64 = 1_001_000;
/// The same in s.
const PERIOD_S: f64 = PERIOD_NS as f64 * 1e-9;
/// From the sample of the position to the change of the duty.
const CONTROL_NS: u64 = 50_000;
/// Phase difference of the control period between consecutive ids.
const PHASE_NS: u64 = 377_000;
/// From the end of a packet to the reply, without return delay.
const PROCESSING_NS: u64 = 20_000;
/// From power-up to the first instruction that is received.
const BOOT_NS: u64 = 100_000_000;
/// Values of the realtime tick, a millisecond each.
const TICKS: u64 = 32_768;
/// Bits of a byte on the wire.
const BYTE_BITS: u64 = 10;
/// The PWM that switches the motor off.
const OFF: u16 = 1000;

/// State of the control step.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Stage {
    /// It has been switched on or restarted.
    Boot,
    /// Waiting for its time.
    Idle,
    /// The position has been sampled.
    Running,
}

/// One servo, powered up together with its wire.
#[derive(Clone, Debug)]
pub struct XServo {
    model: &'static Model,
    memory: Memory,
    receiver: PacketReceiver<Protocol2, PACKET_MAX>,
    registered: Option<(u16, Vec<u8>)>,
    deferred: Option<Deferred>,
    turn: Option<Turn>,
    transmitter: Transmitter,
    /// The packet to send is a part of a joint one.
    sends_part: bool,
    motor: Motor,
    protection: Protection,
    stage: Stage,
    stage_end_ns: u64,
    started_ns: u64,
    last_instruction_ns: u64,
    count: u16,
    /// Speed of the shaft at that count.
    counts_per_s: Option<f64>,
    drive: MotorDrive,
    deaf_until_ns: u64,
    connected: bool,
}

impl XServo {
    /// A servo with factory settings except this id, and this code of the baud rate, see
    /// [`baud_rate`].
    pub fn new(model: &'static Model, id: u8, baud_code: u8) -> Self {
        let specification = specification::find(model);
        let mut memory = Memory::new(model, specification);
        memory.set_byte(at::ID, id);
        memory.set_byte(at::BAUD_RATE, baud_code);
        let mut servo = Self {
            model,
            memory,
            receiver: PacketReceiver::new(),
            registered: None,
            deferred: None,
            turn: None,
            transmitter: Transmitter::new(),
            sends_part: false,
            motor: Motor::new(model, specification),
            protection: Protection::new(model, specification),
            stage: Stage::Boot,
            stage_end_ns: 0,
            started_ns: 0,
            last_instruction_ns: 0,
            count: 0,
            counts_per_s: None,
            drive: OFF.into(),
            deaf_until_ns: 0,
            connected: true,
        };
        servo.power_cycle(0);
        servo
    }

    /// The model.
    pub fn model(&self) -> &'static Model {
        self.model
    }

    /// The id in its EEPROM.
    pub fn id(&self) -> u8 {
        self.memory.byte(at::ID)
    }

    /// Writes registers, as somebody has before the servo was connected.
    pub fn set_register(&mut self, address: u16, bytes: &[u8]) {
        let writes: Vec<(u16, u8)> = (address..).zip(bytes.iter().copied()).collect();
        self.apply(&writes);
    }

    /// Value of the register at an address of `armbridge_servo::protocol2::register`, if the model
    /// has it.
    pub fn register(&self, address: u16) -> Option<i32> {
        self.memory.value(address)
    }

    /// PWM on the motor, 0..=2000, 1000 = off.
    pub fn pwm(&self) -> u16 {
        self.drive.pwm
    }

    /// Whether a hardware error is set, as every status packet tells.
    pub fn is_alert(&self) -> bool {
        self.memory.byte(at::HARDWARE_ERROR) != 0
    }

    /// Whether it is connected to the wire.
    pub fn connected(&self) -> bool {
        self.connected
    }

    /// Sets the supply voltage, in 0.1 V.
    pub fn set_supply(&mut self, decivolt: u8) {
        self.protection.supply_decivolt = decivolt;
    }

    /// Sets the temperature, in °C.
    pub fn set_temperature(&mut self, celsius: f64) {
        self.protection.temperature_c = celsius;
    }

    /// Starts external heating, in °C a second.
    pub fn heat(&mut self, celsius_per_s: f64) {
        self.protection.external_c_per_s = celsius_per_s;
    }

    /// Ends external heating, and sets the temperature to that of the air.
    pub fn cool(&mut self) {
        self.protection.cool();
    }

    pub(crate) fn connect(&mut self, connected: bool) {
        self.connected = connected;
    }

    /// Power-cycles it: only EEPROM and temperature are retained.
    pub(crate) fn power_cycle(&mut self, at_ns: u64) {
        self.restart(at_ns);
        self.drive = OFF.into();
    }

    /// Starts it again. The motor is switched off with the next step.
    fn restart(&mut self, at_ns: u64) {
        let specification = specification::find(self.model);
        self.memory.power_up();
        self.receiver = PacketReceiver::new();
        self.registered = None;
        self.deferred = None;
        self.turn = None;
        self.transmitter = Transmitter::new();
        self.motor = Motor::new(self.model, specification);
        self.protection.power_up();
        self.stage = Stage::Boot;
        self.stage_end_ns = at_ns;
        self.started_ns = at_ns;
        self.last_instruction_ns = at_ns;
        self.deaf_until_ns = at_ns + BOOT_NS;
    }

    /// Whether its bus driver is on, which disconnects its receiver.
    pub(crate) fn driving(&self) -> bool {
        self.transmitter.driving()
    }

    /// Length of one bit at its present rate.
    pub(crate) fn bit_ns(&self) -> u64 {
        let baud = baud_rate(self.memory.byte(at::BAUD_RATE));
        1_000_000_000 / u64::from(baud.unwrap_or(57_600))
    }

    pub(crate) fn next_event_ns(&self) -> u64 {
        self.stage_end_ns.min(self.transmitter.next_event_ns())
    }

    /// Executes the event due at `now_ns`.
    pub(crate) fn step(&mut self, now_ns: u64) -> Option<Action> {
        if self.stage_end_ns <= now_ns {
            return self.control(now_ns);
        }
        let action = self.transmitter.step(now_ns, self.bit_ns());
        match action {
            Some(Action::Send { byte, start_ns }) if self.sends_part => {
                let end_ns = start_ns + BYTE_BITS * self.bit_ns();
                self.receiver.append(byte, end_ns);
            }
            Some(Action::Release) => self.run_deferred(now_ns),
            _ => {}
        }
        action
    }

    fn control(&mut self, now_ns: u64) -> Option<Action> {
        match self.stage {
            Stage::Boot => {
                self.stage = Stage::Idle;
                let phase_ns = (1 + u64::from(self.id())) * PHASE_NS % PERIOD_NS;
                self.stage_end_ns = now_ns + BOOT_NS - PERIOD_NS - CONTROL_NS + phase_ns;
                self.set_pwm(Output::default())
            }
            Stage::Idle => {
                self.stage = Stage::Running;
                self.stage_end_ns = now_ns + CONTROL_NS;
                Some(Action::Convert)
            }
            Stage::Running => {
                self.stage = Stage::Idle;
                self.stage_end_ns = now_ns + PERIOD_NS - CONTROL_NS;
                let output = self.output(now_ns);
                self.set_pwm(output)
            }
        }
    }

    /// A control step, to the duty.
    fn output(&mut self, now_ns: u64) -> Output {
        let ticks = now_ns.saturating_sub(self.started_ns) / 1_000_000 % TICKS;
        self.memory.set_short(at::REALTIME_TICK, ticks as i16);
        self.watch_bus(now_ns);
        let supply_v = self.protection.supply_v();
        let output = self
            .motor
            .step(&mut self.memory, self.count, self.counts_per_s, supply_v);
        let is_off = self
            .protection
            .step(&mut self.memory, output, now_ns, PERIOD_S);
        if is_off {
            self.memory.set_byte(at::TORQUE_ENABLE, 0);
            self.memory.is_shut_down = true;
            return Output::default();
        }
        output
    }

    fn set_pwm(&mut self, output: Output) -> Option<Action> {
        let pwm = |duty: i16| {
            let share = f64::from(duty) / f64::from(self.model.full_pwm);
            (f64::from(OFF) * (1.0 + share)).round() as u16
        };
        let drive = MotorDrive {
            pwm: pwm(output.duty),
            at_rest: pwm(output.at_rest),
        };
        let before = std::mem::replace(&mut self.drive, drive);
        (drive != before).then_some(Action::Pwm(drive))
    }

    pub(crate) fn converted(&mut self, reading: Reading) {
        self.count = reading.position;
    }

    /// Takes the speed of its shaft in counts a second, unless only the encoder shows it.
    pub(crate) fn turned(&mut self, counts_per_s: Option<f64>) {
        self.counts_per_s = counts_per_s;
    }

    /// Processes a received byte, three quarters into its stop bit.
    pub(crate) fn receive(&mut self, byte: u8, framing_error: bool, now_ns: u64) {
        if now_ns < self.deaf_until_ns {
            self.receiver.clear();
            return;
        }
        // Delays start at the end of the stop bit.
        let end_ns = now_ns + self.bit_ns() / 4;
        let id = self.id();
        let packet = match self.receiver.push(byte, framing_error, now_ns) {
            Some(Ok(frame)) if frame.code == STATUS => {
                let from = frame.id;
                return self.status_received(from, end_ns);
            }
            Some(Ok(frame)) => Packet::new(&frame),
            Some(Err(PacketError::Checksum { id: to })) if to == id => {
                return self.reply_to_damage(end_ns);
            }
            Some(Err(_)) => return,
            None => return self.part_received(end_ns),
        };
        self.execute(&packet, end_ns);
    }
}
