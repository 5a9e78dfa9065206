//! Servo of either firmware, as a device on the wire.

use super::lookahead::Schedule;
use super::receiver::Decoded;
use crate::morpheus_servo::{Action, Reading, Servo};
use crate::stock_servo::Ax12a;

/// A servo on the wire.
#[expect(
    clippy::large_enum_variant,
    reason = "a bus has few, and they are not moved"
)]
#[derive(Clone, Debug)]
pub enum Device {
    /// It runs Morpheus.
    Morpheus(Servo),
    /// It runs the stock firmware.
    Stock(Ax12a),
}

impl From<Servo> for Device {
    fn from(servo: Servo) -> Self {
        Self::Morpheus(servo)
    }
}

impl From<Ax12a> for Device {
    fn from(servo: Ax12a) -> Self {
        Self::Stock(servo)
    }
}

impl Device {
    /// The servo, if it runs Morpheus.
    pub fn morpheus(&self) -> Option<&Servo> {
        match self {
            Self::Morpheus(servo) => Some(servo),
            Self::Stock(_) => None,
        }
    }

    /// The servo, if it runs the stock firmware.
    pub fn stock(&self) -> Option<&Ax12a> {
        match self {
            Self::Morpheus(_) => None,
            Self::Stock(servo) => Some(servo),
        }
    }

    /// Mutable access, to properties that a master cannot change.
    pub fn stock_mut(&mut self) -> Option<&mut Ax12a> {
        match self {
            Self::Morpheus(_) => None,
            Self::Stock(servo) => Some(servo),
        }
    }

    /// The id in its EEPROM.
    pub fn id(&self) -> u8 {
        match self {
            Self::Morpheus(servo) => servo.id(),
            Self::Stock(servo) => servo.id(),
        }
    }

    /// PWM on the motor, 0..=2000, 1000 = off.
    pub fn pwm(&self) -> u16 {
        match self {
            Self::Morpheus(servo) => servo.pwm(),
            Self::Stock(servo) => servo.pwm(),
        }
    }

    /// Whether it is connected to the wire.
    pub fn connected(&self) -> bool {
        match self {
            Self::Morpheus(servo) => servo.connected(),
            Self::Stock(servo) => servo.connected(),
        }
    }

    pub(super) fn connect(&mut self, connected: bool) {
        match self {
            Self::Morpheus(servo) => servo.connect(connected),
            Self::Stock(servo) => servo.connect(connected),
        }
    }

    pub(super) fn power_cycle(&mut self, at_ns: u64) {
        match self {
            Self::Morpheus(servo) => servo.power_cycle(at_ns),
            Self::Stock(servo) => servo.power_cycle(at_ns),
        }
    }

    /// Whether its bus driver is on, which disconnects its receiver.
    pub(super) fn driving(&self) -> bool {
        match self {
            Self::Morpheus(servo) => servo.driving(),
            Self::Stock(servo) => servo.driving(),
        }
    }

    /// Length of one bit at its present rate.
    #[inline]
    pub(crate) fn bit_ns(&self) -> u64 {
        match self {
            Self::Morpheus(servo) => servo.bit_ns(),
            Self::Stock(servo) => servo.bit_ns(),
        }
    }

    /// Its next events.
    #[inline]
    pub(super) fn schedule(&self) -> Schedule {
        match self {
            Self::Morpheus(servo) => {
                let (next_ns, send_ns) = servo.schedule();
                Schedule { next_ns, send_ns }
            }
            Self::Stock(servo) => {
                let next_ns = servo.next_event_ns();
                Schedule {
                    next_ns,
                    send_ns: next_ns,
                }
            }
        }
    }

    /// Executes the event due at `now_ns`.
    pub(super) fn step(&mut self, now_ns: u64) -> Option<Action> {
        match self {
            Self::Morpheus(servo) => servo.step(now_ns),
            Self::Stock(servo) => servo.step(now_ns),
        }
    }

    /// Executes internal events from `now_ns` on that are before `limit_ns`.
    pub(super) fn run_ahead(&mut self, now_ns: u64, limit_ns: u64) {
        match self {
            Self::Morpheus(servo) => servo.run_ahead(now_ns, limit_ns),
            // It has few events, and most of them are actions.
            Self::Stock(_) => {}
        }
    }

    /// Whether a start bit would have an effect on its receiver now.
    pub(super) fn heeds_start_bits(&self) -> bool {
        match self {
            Self::Morpheus(servo) => servo.heeds_start_bits(),
            Self::Stock(_) => false,
        }
    }

    /// Passes the requested reading to its converter.
    pub(super) fn converted(&mut self, reading: Reading) {
        match self {
            Self::Morpheus(servo) => servo.converted(reading),
            Self::Stock(servo) => servo.converted(reading),
        }
    }

    /// Signals a start bit to its receiver.
    pub(super) fn start_bit(&mut self) {
        match self {
            Self::Morpheus(servo) => servo.start_bit(),
            // Its receiver is not known to lose bytes.
            Self::Stock(_) => {}
        }
    }

    /// Processes a received byte.
    pub(super) fn receive(&mut self, decoded: Decoded, now_ns: u64) {
        match self {
            // Morpheus ignores the stop bit.
            Self::Morpheus(servo) => servo.receive(decoded.byte),
            Self::Stock(servo) => servo.receive(decoded.byte, decoded.framing_error, now_ns),
        }
    }
}
