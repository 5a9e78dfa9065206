//! A million random byte streams into a wire with two servos: nothing may
//! panic, and the work per byte stays bounded.
//!
//! The streams are random bytes, bytes rich in headers and ids, and packets
//! with a byte changed. The servos are not reset in between, so that streams
//! meet servos that are deaf, stuck or in position mode; every thousandth
//! stream finds them switched off and on.

use armbridge_sim::half_duplex_bus::{Mechanics, MotorDrive, Wire};
use armbridge_sim::morpheus_servo::{Reading, Servo};
use armbridge_tests::random::Random;

const STREAMS: usize = 1_000_000;
const STREAMS_PER_POWER_CYCLE: usize = 1_000;
const BAUD: u32 = 1_000_000;
const BYTE_NS: u64 = 10_000;
/// Longest stream of random bytes.
const LONGEST: u64 = 12;
/// No servo may have more events than this in the time of one byte. A byte
/// costs a servo about five, its main loop and converter one more.
const EVENTS_PER_BYTE: u64 = 100;

fn packet(random: &mut Random) -> Vec<u8> {
    let parameters = random.below(8) as u8;
    let mut packet = vec![0xAA, parameters + 3];
    packet.push(random.one_of(&[1, 2, 0xFF, 0xFF]));
    packet.push(random.one_of(&[0xFE, 0xFE, 1, 2, 7]));
    packet.push(random.one_of(&[1, 2, 3, 6, 7, 9, 0x83, 0x83, 5]));
    for _ in 0..parameters {
        let chosen = random.one_of(&[0, 1, 2, 0x0B, 0x0D, 0x0F, 0x10, 3]);
        packet.push(if random.below(3) == 0 {
            random.byte()
        } else {
            chosen
        });
    }
    let sum = packet[1..]
        .iter()
        .fold(0_u8, |sum, &byte| sum.wrapping_add(!byte));
    packet.push(sum);
    packet
}

fn random_bytes(random: &mut Random) -> Vec<u8> {
    match random.below(4) {
        0 => (0..random.below(LONGEST)).map(|_| random.byte()).collect(),
        1 => (0..random.below(LONGEST))
            .map(|_| random.one_of(&[0xAA, 3, 4, 1, 2, 0xFF, 0xFE, 0x83, 0x10]))
            .collect(),
        2 => packet(random),
        _ => {
            let mut packet = packet(random);
            let place = random.below(packet.len() as u64) as usize;
            packet[place] = random.byte();
            packet
        }
    }
}

/// Sensors that move by themselves.
struct Moving {
    counts: u16,
    worst_pwm: u16,
}

impl Mechanics for Moving {
    fn convert(&mut self, _servo: usize, _at_ns: u64) -> Reading {
        self.counts = (self.counts + 7) % 1024;
        Reading {
            position: self.counts,
            temperature: 1023 - self.counts,
        }
    }

    fn drive(&mut self, _servo: usize, _at_ns: u64, drive: MotorDrive) {
        self.worst_pwm = self.worst_pwm.max(drive.pwm);
    }
}

#[test]
fn random_streams() {
    let mut random = Random::new(0x5EED_0001);
    let mut wire = Wire::new(vec![Servo::with_id(1), Servo::with_id(2)]);
    let mut sensors = Moving {
        counts: 500,
        worst_pwm: 0,
    };
    let mut replied = 0_usize;
    for number in 0..STREAMS {
        if number % STREAMS_PER_POWER_CYCLE == 0 {
            for servo in 0..2 {
                wire.power_cycle(servo, &mut sensors);
            }
        }
        let bytes = random_bytes(&mut random);
        let gap_ns = random.below(3) * 20_000;
        let start = wire.now_ns() + gap_ns;
        for (i, &byte) in bytes.iter().enumerate() {
            wire.send(start + i as u64 * BYTE_NS, byte, BAUD);
        }
        let end = start + bytes.len() as u64 * BYTE_NS;
        let mut events = 0;
        while wire.next_event_ns() <= end {
            wire.advance(wire.next_event_ns(), &mut sensors);
            events += 1;
        }
        wire.advance(end, &mut sensors);
        let bound = EVENTS_PER_BYTE * (end - start + gap_ns + BYTE_NS) / BYTE_NS;
        assert!(events <= bound, "{events} events in stream {number}");
        while wire.take_received().is_some() {
            replied += 1;
        }
    }
    assert!(replied > STREAMS / 100, "only {replied} reply bytes");
    assert!(sensors.worst_pwm <= 2000, "PWM {}", sensors.worst_pwm);
}
