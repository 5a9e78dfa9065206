//! The virtual bench: servos, wire, arm and clock.
//!
//! | module    | what                                                         |
//! |-----------|--------------------------------------------------------------|
//! | [`servo`] | the servo firmware, byte for byte                            |
//! | [`wire`]  | the half-duplex bus between master and servos                |
//! | [`plant`] | the arm: dynamics, friction, encoders, motors                |
//! | [`uart`]  | the virtual board's serial port                              |
//! | [`board`] | what the bench drives; the application core in this process  |
//! | [`cosim`] | board, bus, arm and operator in one virtual time             |
//!
//! Everything here is simulated.

pub mod board;
pub mod cosim;
pub mod plant;
pub mod servo;
pub mod uart;
pub mod wire;

use armbridge_shared::arm::State;
use armbridge_shared::bridge::SERVO_IDS;
use plant::{Plant, Push};
use servo::{Reading, Servo};
use wire::{Disturbance, Mechanics, Wire};

/// Baud rate of the servo bus, the servos' default.
const BAUD: u32 = 1_000_000;
/// Time of a byte at [`BAUD`].
const BYTE_NS: u64 = 10_000;
/// Converter counts of a servo at room temperature: any will do, the firmware
/// does nothing with them.
const TEMPERATURE: u16 = 300;

/// Servos on a wire, moving an arm.
#[derive(Debug)]
pub struct Bench {
    wire: Wire,
    arm: Arm,
    line_free_ns: u64,
}

#[derive(Debug)]
struct Arm(Plant);

impl Mechanics for Arm {
    fn convert(&mut self, servo: usize, at_ns: u64) -> Reading {
        Reading {
            position: self.0.read(servo, at_ns),
            temperature: TEMPERATURE,
        }
    }

    fn drive(&mut self, servo: usize, at_ns: u64, pwm: u16) {
        self.0.drive(servo, at_ns, pwm);
    }
}

impl Bench {
    /// Servos with the bridge's ids, powered up at time 0, that move `plant`.
    pub fn new(plant: Plant) -> Self {
        let servos = SERVO_IDS
            .iter()
            .map(|id| Servo::with_id(id.get()))
            .collect();
        Self {
            wire: Wire::new(servos),
            arm: Arm(plant),
            line_free_ns: 0,
        }
    }

    /// Puts bytes on the wire, back to back, from `now_us` or from when the
    /// bytes before have left.
    pub fn send(&mut self, now_us: u64, bytes: &[u8]) {
        for byte in bytes {
            let start_ns = self.line_free_ns.max(now_us * 1_000);
            self.wire.send(start_ns, *byte, BAUD);
            self.line_free_ns = start_ns + BYTE_NS;
        }
    }

    /// When the bytes put on the wire will have left it, in µs, rounded up.
    pub fn line_free_us(&self) -> u64 {
        self.line_free_ns.div_ceil(1_000)
    }

    /// Goes on to `until_us`, or until `wanted` bytes have come from the servos,
    /// whichever is first. Returns the time in µs, rounded up, and adds what has
    /// come to `heard`.
    pub fn advance(&mut self, until_us: u64, wanted: Option<usize>, heard: &mut Vec<u8>) -> u64 {
        let enough = wanted.unwrap_or(usize::MAX);
        self.wire
            .advance_until(until_us.saturating_mul(1_000), enough, &mut self.arm);
        let mut count = 0;
        while let Some(byte) = self.wire.take_heard() {
            heard.push(byte.byte);
            count += 1;
            if count >= enough {
                return byte.end_ns.div_ceil(1_000);
            }
        }
        until_us
    }

    /// The PWM that servo `servo`'s motor gets, 0..=2000, 1000 = off.
    pub fn applied_pwm(&self, servo: usize) -> u16 {
        self.wire.servos()[servo].state().pwm
    }

    /// Takes servo `servo` off the wire; it stays powered and obeys on.
    pub fn disconnect(&mut self, servo: usize) {
        self.wire.connect(servo, false);
    }

    /// Lets something spoil the servos' replies from now on.
    pub fn disturb(&mut self, disturbance: Disturbance) {
        self.wire.disturb(disturbance);
    }

    /// Somebody pushes the arm. A push that should have begun begins now.
    pub fn push(&mut self, push: Push) {
        self.arm.0.push(push);
    }

    /// True angles and speeds at `at_us`, which is not before the time that
    /// [`Bench::advance`] has come to.
    pub fn state_at(&mut self, at_us: u64) -> State<f64> {
        self.arm.0.advance(at_us.saturating_mul(1_000));
        self.arm.0.state()
    }

    /// The true arm.
    pub fn plant(&self) -> &Plant {
        &self.arm.0
    }
}
