//! Servo of any firmware, as a device on the wire.

use super::lookahead::Schedule;
use super::receiver::Decoded;
use crate::morpheus_servo::{Action, Reading, Servo};
use crate::stock_servo::Ax12a;
use crate::x_servo::XServo;
use armbridge_control::encoder::Encoder;

/// A servo on the wire.
#[derive(Clone, Debug)]
pub enum Device {
    /// It runs Morpheus.
    Morpheus(Servo),
    /// It runs the stock firmware.
    Stock(Ax12a),
    /// It is one of the X series.
    X(XServo),
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

impl From<XServo> for Device {
    fn from(servo: XServo) -> Self {
        Self::X(servo)
    }
}

impl Device {
    /// The servo, if it runs Morpheus.
    pub fn morpheus(&self) -> Option<&Servo> {
        match self {
            Self::Morpheus(servo) => Some(servo),
            Self::Stock(_) | Self::X(_) => None,
        }
    }

    /// The servo, if it runs the stock firmware.
    pub fn stock(&self) -> Option<&Ax12a> {
        match self {
            Self::Morpheus(_) | Self::X(_) => None,
            Self::Stock(servo) => Some(servo),
        }
    }

    /// Mutable access, to properties that a master cannot change.
    pub fn stock_mut(&mut self) -> Option<&mut Ax12a> {
        match self {
            Self::Morpheus(_) | Self::X(_) => None,
            Self::Stock(servo) => Some(servo),
        }
    }

    /// The servo, if it is one of the X series.
    pub fn x_series(&self) -> Option<&XServo> {
        match self {
            Self::Morpheus(_) | Self::Stock(_) => None,
            Self::X(servo) => Some(servo),
        }
    }

    /// Mutable access, to properties that a master cannot change.
    pub fn x_series_mut(&mut self) -> Option<&mut XServo> {
        match self {
            Self::Morpheus(_) | Self::Stock(_) => None,
            Self::X(servo) => Some(servo),
        }
    }

    /// Its position encoder.
    pub const fn encoder(&self) -> Encoder {
        match self {
            Self::Morpheus(_) | Self::Stock(_) => Encoder::Ax12a,
            Self::X(_) => Encoder::XSeries,
        }
    }

    /// The id in its EEPROM.
    pub fn id(&self) -> u8 {
        match self {
            Self::Morpheus(servo) => servo.id(),
            Self::Stock(servo) => servo.id(),
            Self::X(servo) => servo.id(),
        }
    }

    /// PWM on the motor, 0..=2000, 1000 = off.
    pub fn pwm(&self) -> u16 {
        match self {
            Self::Morpheus(servo) => servo.pwm(),
            Self::Stock(servo) => servo.pwm(),
            Self::X(servo) => servo.pwm(),
        }
    }

    /// Whether it is connected to the wire.
    pub fn connected(&self) -> bool {
        match self {
            Self::Morpheus(servo) => servo.connected(),
            Self::Stock(servo) => servo.connected(),
            Self::X(servo) => servo.connected(),
        }
    }

    pub(super) fn connect(&mut self, connected: bool) {
        match self {
            Self::Morpheus(servo) => servo.connect(connected),
            Self::Stock(servo) => servo.connect(connected),
            Self::X(servo) => servo.connect(connected),
        }
    }

    pub(super) fn power_cycle(&mut self, at_ns: u64) {
        match self {
            Self::Morpheus(servo) => servo.power_cycle(at_ns),
            Self::Stock(servo) => servo.power_cycle(at_ns),
            Self::X(servo) => servo.power_cycle(at_ns),
        }
    }

    /// Whether its bus driver is on, which disconnects its receiver.
    pub(super) fn driving(&self) -> bool {
        match self {
            Self::Morpheus(servo) => servo.driving(),
            Self::Stock(servo) => servo.driving(),
            Self::X(servo) => servo.driving(),
        }
    }

    /// Length of one bit at its present rate.
    #[inline]
    pub(crate) fn bit_ns(&self) -> u64 {
        match self {
            Self::Morpheus(servo) => servo.bit_ns(),
            Self::Stock(servo) => servo.bit_ns(),
            Self::X(servo) => servo.bit_ns(),
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
            Self::Stock(servo) => Schedule::of_sender(servo.next_event_ns()),
            Self::X(servo) => Schedule::of_sender(servo.next_event_ns()),
        }
    }

    /// Executes the event due at `now_ns`.
    pub(super) fn step(&mut self, now_ns: u64) -> Option<Action> {
        match self {
            Self::Morpheus(servo) => servo.step(now_ns),
            Self::Stock(servo) => servo.step(now_ns),
            Self::X(servo) => servo.step(now_ns),
        }
    }

    /// Executes internal events from `now_ns` on that are before `limit_ns`.
    pub(super) fn run_ahead(&mut self, now_ns: u64, limit_ns: u64) {
        match self {
            Self::Morpheus(servo) => servo.run_ahead(now_ns, limit_ns),
            // They have few events, and most of them are actions.
            Self::Stock(_) | Self::X(_) => {}
        }
    }

    /// Whether a start bit would have an effect on its receiver now.
    pub(super) fn heeds_start_bits(&self) -> bool {
        match self {
            Self::Morpheus(servo) => servo.heeds_start_bits(),
            Self::Stock(_) | Self::X(_) => false,
        }
    }

    /// Passes the requested reading to its converter.
    pub(super) fn converted(&mut self, reading: Reading) {
        match self {
            Self::Morpheus(servo) => servo.converted(reading),
            Self::Stock(servo) => servo.converted(reading),
            Self::X(servo) => servo.converted(reading),
        }
    }

    /// Signals a start bit to its receiver.
    pub(super) fn start_bit(&mut self) {
        match self {
            Self::Morpheus(servo) => servo.start_bit(),
            // Their receivers are not known to lose bytes.
            Self::Stock(_) | Self::X(_) => {}
        }
    }

    /// Processes a received byte.
    pub(super) fn receive(&mut self, decoded: Decoded, now_ns: u64) {
        match self {
            // Morpheus ignores the stop bit.
            Self::Morpheus(servo) => servo.receive(decoded.byte),
            Self::Stock(servo) => servo.receive(decoded.byte, decoded.framing_error, now_ns),
            Self::X(servo) => servo.receive(decoded.byte, decoded.framing_error, now_ns),
        }
    }
}
