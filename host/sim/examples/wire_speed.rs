//! Speed of the wire and two servos: 10 s of a 1 kHz loop of `SYNC_WR` (to
//! 0x0F) and CYCLE, printed as simulated seconds per second of wall clock.
//!
//! `cargo run --release -p armbridge-sim --example wire_speed`

use std::time::Instant;

use armbridge_sim::half_duplex_bus::{Mechanics, MotorDrive, Wire};
use armbridge_sim::morpheus_servo::{Reading, Servo};

const BAUD: u32 = 1_000_000;
const BYTE_NS: u64 = 10_000;
const TICK_NS: u64 = 1_000_000;
const TICKS: u64 = 10_000;
/// After START, until both slots are over.
const START_NS: u64 = 20_000_000;
/// Between the two packets of a tick: the first must be processed.
const GAP_NS: u64 = 20_000;

struct Still;

impl Mechanics for Still {
    fn convert(&mut self, servo: usize, _at_ns: u64) -> Reading {
        Reading {
            position: 500 + servo as u16,
            temperature: 300,
        }
    }

    fn drive(&mut self, _servo: usize, _at_ns: u64, _drive: MotorDrive) {}
}

/// Sends a packet and returns when it ends.
fn send(wire: &mut Wire, start_ns: u64, body: &[u8]) -> u64 {
    let sum = body.iter().fold(0_u8, |sum, &byte| sum.wrapping_add(!byte));
    let packet = [&[0xAA], body, &[sum]].concat();
    for (i, &byte) in packet.iter().enumerate() {
        wire.send(start_ns + i as u64 * BYTE_NS, byte, BAUD);
    }
    start_ns + packet.len() as u64 * BYTE_NS
}

fn main() {
    let mut wire = Wire::new(vec![Servo::with_id(1), Servo::with_id(2)]);
    send(&mut wire, TICK_NS, &[3, 0xFF, 0xFE, 0x06]);
    wire.advance(START_NS, &mut Still);
    while wire.take_received().is_some() {}

    let begun = Instant::now();
    let mut received = 0_u64;
    for tick in 0..TICKS {
        let start = START_NS + tick * TICK_NS;
        let [low, high] = (1000 + tick as u16 % 100).to_le_bytes();
        let pwm = [
            13, 0xFF, 0xFE, 0x83, 0x0F, 3, 1, 0, low, high, 2, 0, low, high,
        ];
        let end = send(&mut wire, start, &pwm);
        send(&mut wire, end + GAP_NS, &[3, 0xFF, 0xFE, 0x07]);
        wire.advance(start + TICK_NS, &mut Still);
        while wire.take_received().is_some() {
            received += 1;
        }
    }
    let wall = begun.elapsed().as_secs_f64();
    let simulated = (TICKS * TICK_NS) as f64 * 1e-9;
    println!(
        "{simulated} s simulated in {wall:.3} s, {:.0} times real time; {received} of {} bytes received",
        simulated / wall,
        TICKS * 14,
    );
}
