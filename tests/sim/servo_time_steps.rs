//! Virtual servos act alike whichever steps time is advanced in: a simulation that jumps
//! and a server that follows the wall clock see the same.

use armbridge_sim::half_duplex_bus::{Mechanics, MotorDrive, ReceivedByte, Record, Wire};
use armbridge_sim::morpheus_servo::{Reading, Servo, State};

/// A sensor that moves with time, and everything the servos did to the motor.
#[derive(Debug, Default, PartialEq)]
struct Rig {
    drives: Vec<(usize, u64, u16)>,
    conversions: Vec<(usize, u64)>,
}

impl Mechanics for Rig {
    fn convert(&mut self, servo: usize, at_ns: u64) -> Reading {
        self.conversions.push((servo, at_ns));
        Reading {
            position: 300 + (at_ns / 100_000 % 400) as u16,
            temperature: 300,
        }
    }

    fn drive(&mut self, servo: usize, at_ns: u64, drive: MotorDrive) {
        self.drives.push((servo, at_ns, drive.pwm));
    }
}

/// START, position control, a collision, an EEPROM write in mid traffic.
const TRAFFIC: [(u64, &[u8]); 6] = [
    (1_000_000, &[0xAA, 3, 0xFF, 0xFE, 6, 0xF6]),
    (15_000_000, &[0xAA, 3, 0xFF, 0xFE, 7, 0xF5]),
    (16_000_000, &[0xAA, 3, 0xFF, 0xFE, 1, 0xFB]),
    (
        17_000_000,
        &[0xAA, 7, 0xFF, 0xFE, 3, 0x0B, 0x58, 0x02, 5, 0x87],
    ),
    (25_000_000, &[0xAA, 5, 1, 0xFE, 3, 6, 9, 0xE4]),
    (26_000_000, &[0xAA, 3, 2, 0xFE, 1, 0xF8]),
];
const END_NS: u64 = 50_000_000;

fn run(step_ns: u64) -> (Rig, Vec<ReceivedByte>, Vec<Record>, Vec<State>) {
    let mut wire = Wire::new(vec![Servo::with_id(1), Servo::with_id(2)]);
    wire.record();
    let mut rig = Rig::default();
    for (start, packet) in TRAFFIC {
        for (i, &byte) in packet.iter().enumerate() {
            wire.send(start + i as u64 * 10_000, byte, 1_000_000);
        }
    }
    while wire.now_ns() < END_NS {
        wire.advance((wire.now_ns() + step_ns).min(END_NS), &mut rig);
    }
    let received = std::iter::from_fn(|| wire.take_received()).collect();
    let states = wire.morpheus().map(Servo::state).collect();
    (rig, received, wire.take_records(), states)
}

#[test]
fn steps_do_not_matter() {
    let whole = run(END_NS);
    assert!(whole.0.drives.len() > 10, "position control acts");
    assert!(whole.1.len() > 30, "replies are heard");
    for step_ns in [333, 10_000, 1_234_567] {
        assert_eq!(run(step_ns), whole, "steps of {step_ns} ns");
    }
}
