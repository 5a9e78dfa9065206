//! Virtual servo: a stock AX-12A, with Dynamixel Protocol 1.0.
//!
//! | module    | model of                                                    |
//! |-----------|-------------------------------------------------------------|
//! | `memory`  | the control table: EEPROM, RAM, write checks                |
//! | `commands` | the instructions, and their replies                        |
//! | `motor`   | wheel and joint mode: from the position to the duty         |
//! | `protect` | heat, overload and supply; the alarms                       |
//!
//! Transmitter and bus driver are those of `status_transmitter`.
//!
//! # Sources
//!
//! The firmware is closed. Its behaviour is taken from ROBOTIS's e-Manual
//! ("AX-12A", "DYNAMIXEL Protocol 1.0") and the AX-12 manual of 2006; its timing
//! from measurements at the wire (Xevel, "Dynamixel protocol notes" of the
//! USB2AX): with a return delay of 0 a status packet begins 18 µs after a PING,
//! 22 after a READ, 24 and 6 a byte after a WRITE; each millisecond an interrupt
//! of 130 µs controls the motor and nothing is sent meanwhile, which can split a
//! packet; a write is checked, answered, and then done; an EEPROM byte takes
//! 6 ms, in which nothing is received. The documents' examples show that a new id
//! and a new rate hold from after the status packet on.
//!
//! # Assumptions
//!
//! These have no source; a master should not depend on them.
//! - The control period is a thousandth longer than a millisecond, so that it
//!   slides past a master's own, and begins with a phase that depends on the id.
//!   Nothing is received before the first.
//! - The bus driver is switched off when the last stop bit is out, or when the
//!   interrupt that falls on it is over.
//! - Torque must be enabled, in wheel mode too; a goal in joint mode enables it.
//! - A register that is only read, locked, or in the EEPROM while torque is on
//!   refuses with a range error. With an error nothing is written.
//! - An instruction that comes before the answer to the last is sent takes its
//!   place. Code 0 is the status packet of another servo of the same id, and is
//!   not answered, or the two would reply without end.
//! - Parameters that do not fit are an instruction error. An unknown instruction,
//!   or a damaged packet, is answered where the status return level has a WRITE answered.
//! - See also those of `motor` and `protect`.
//!
//! The LED is only a register; the supply does not sag. Duties become the
//! PWM that [`Mechanics`](super::half_duplex_bus::Mechanics) takes, 1000 for off: all that
//! is known of either bridge is its duty.

mod commands;
mod memory;
mod motor;
mod protect;
#[cfg(test)]
mod tests;

use armbridge_client::servo_table::AX12A;
use armbridge_servo::Alarms;
use armbridge_servo::protocol1::frame::FRAME_MAX;
use armbridge_servo::protocol1::{BROADCAST, PacketError, Protocol1};

use super::morpheus_servo::{Action, Reading};
use super::packet_receiver::PacketReceiver;
use super::status_transmitter::Transmitter;
use commands::{Deferred, Packet, Write};
use memory::{Memory, at};
use motor::{FULL, Motor};
use protect::Protection;

/// Period of the control step.
const PERIOD_NS: u64 = 1_001_000;
/// The same in s.
const PERIOD_S: f64 = PERIOD_NS as f64 * 1e-9;
/// Execution time of a control step.
const INTERRUPT_NS: u64 = 130_000;
/// Phase difference of the control period between consecutive ids.
const PHASE_NS: u64 = 377_000;
/// Time for one byte of EEPROM.
const EEPROM_BYTE_NS: u64 = 6_000_000;
/// The PWM that switches the motor off.
const OFF: u16 = 1000;

/// State of the control step.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Stage {
    /// Waiting for its time.
    Idle,
    /// The position has been sampled, the interrupt runs.
    Running,
}

/// One servo, powered up together with its wire.
#[derive(Clone, Debug)]
pub struct Ax12a {
    memory: Memory,
    receiver: PacketReceiver<Protocol1, FRAME_MAX>,
    registered: Option<Write>,
    deferred: Option<Deferred>,
    transmitter: Transmitter,
    motor: Motor,
    protection: Protection,
    stage: Stage,
    stage_end_ns: u64,
    position: u16,
    pwm: u16,
    deaf_until_ns: u64,
    connected: bool,
}

/// PWM of a duty, in counts of `Mechanics`: off is 1000, full 0 and 2000.
fn pwm(duty: i16) -> u16 {
    let share = f64::from(duty) / f64::from(FULL);
    (f64::from(OFF) * (1.0 + share)).round() as u16
}

impl Ax12a {
    /// A servo with factory settings except this id, and a rate of
    /// 2 000 000 / (`baud_rate` + 1) baud.
    pub fn new(id: u8, baud_rate: u8) -> Self {
        let mut memory = Memory::new();
        memory.set_byte(at::ID, id);
        memory.set_byte(at::BAUD_RATE, baud_rate);
        let mut servo = Self {
            memory,
            receiver: PacketReceiver::new(),
            registered: None,
            deferred: None,
            transmitter: Transmitter::new(),
            motor: Motor::new(),
            protection: Protection::new(),
            stage: Stage::Idle,
            stage_end_ns: 0,
            position: 0,
            pwm: OFF,
            deaf_until_ns: 0,
            connected: true,
        };
        servo.power_cycle(0);
        servo
    }

    /// The id in its EEPROM.
    pub fn id(&self) -> u8 {
        self.memory.byte(at::ID)
    }

    /// Value of a register, by its name in
    /// [`AX12A`].
    pub fn register(&self, name: &str) -> Option<u32> {
        let register = AX12A.by_name(name)?;
        let bytes = self.memory.read(0, AX12A.size)?;
        register.value_in(bytes, 0)
    }

    /// PWM on the motor, 0..=2000, 1000 = off.
    pub fn pwm(&self) -> u16 {
        self.pwm
    }

    /// Alarms in every status packet.
    pub fn alarms(&self) -> Alarms {
        self.protection.alarms(&self.memory)
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
        self.memory.power_up();
        self.receiver = PacketReceiver::new();
        self.registered = None;
        self.deferred = None;
        self.transmitter = Transmitter::new();
        self.motor = Motor::new();
        self.protection.power_up();
        self.stage = Stage::Idle;
        self.stage_end_ns = at_ns + (1 + u64::from(self.id())) * PHASE_NS % PERIOD_NS;
        self.pwm = OFF;
        self.deaf_until_ns = self.stage_end_ns + INTERRUPT_NS;
    }

    /// Whether its bus driver is on, which disconnects its receiver.
    pub(crate) fn driving(&self) -> bool {
        self.transmitter.driving()
    }

    /// Length of one bit at its present rate.
    pub(crate) fn bit_ns(&self) -> u64 {
        500 * (u64::from(self.memory.byte(at::BAUD_RATE)) + 1)
    }

    pub(crate) fn next_event_ns(&self) -> u64 {
        self.stage_end_ns.min(self.transmitter.next_event_ns())
    }

    /// Executes the event due at `now_ns`.
    pub(crate) fn step(&mut self, now_ns: u64) -> Option<Action> {
        if self.stage_end_ns <= now_ns {
            return self.control(now_ns);
        }
        if self.stage == Stage::Running {
            self.transmitter.wait_until(self.stage_end_ns);
            return None;
        }
        let action = self.transmitter.step(now_ns, self.bit_ns());
        if let Some(Action::Release) = action {
            self.run_deferred(now_ns);
        }
        action
    }

    fn control(&mut self, now_ns: u64) -> Option<Action> {
        if self.stage == Stage::Idle {
            self.stage = Stage::Running;
            self.stage_end_ns = now_ns + INTERRUPT_NS;
            return Some(Action::Convert);
        }
        self.stage = Stage::Idle;
        self.stage_end_ns = now_ns + PERIOD_NS - INTERRUPT_NS;
        let output = self.motor.step(&mut self.memory, self.position, PERIOD_S);
        let alarms = self
            .protection
            .step(&mut self.memory, output, now_ns, PERIOD_S);
        let is_off = self.shut_down_for(alarms);
        let duty = if is_off { 0 } else { output.duty };
        let before = std::mem::replace(&mut self.pwm, pwm(duty));
        (self.pwm != before).then_some(Action::Pwm(self.pwm.into()))
    }

    /// Switches torque off, if it is on, for those of these alarms that are in the
    /// shutdown mask. The motor is off from the next control step on.
    fn shut_down_for(&mut self, alarms: Alarms) -> bool {
        let mask = Alarms::from_bits(self.memory.byte(at::SHUTDOWN));
        let shuts_down = self.memory.torque_on() && !alarms.and(mask).is_empty();
        if shuts_down {
            self.memory.set_byte(at::TORQUE_ENABLE, 0);
            self.memory.set_word(at::TORQUE_LIMIT, 0);
        }
        shuts_down
    }

    pub(crate) fn converted(&mut self, reading: Reading) {
        self.position = reading.position;
    }

    /// Processes a received byte, three quarters into its stop bit.
    pub(crate) fn receive(&mut self, byte: u8, framing_error: bool, now_ns: u64) {
        if now_ns < self.deaf_until_ns {
            self.receiver.clear();
            return;
        }
        let id = self.id();
        let packet = match self.receiver.push(byte, framing_error, now_ns) {
            Some(Ok(frame)) if frame.id == id || frame.id == BROADCAST => Packet::intact(&frame),
            Some(Err(PacketError::Checksum { id: to })) if to == id => Packet::damaged(),
            _ => return,
        };
        // The delay of the reply starts at the end of the stop bit.
        let end_ns = now_ns + self.bit_ns() / 4;
        self.execute(&packet, end_ns);
    }
}
