//! Random bytes: no register leaves its range,
//! and a valid request is answered.

use armbridge_client::servo_table::{AX12A, Access};
use armbridge_servo::protocol1::{Frame, Instruction};
use rand_distr::{Distribution, Uniform};
use rand_pcg::Pcg32;

use crate::half_duplex_bus::{Device, Mechanics, MotorDrive, Wire};
use crate::morpheus_servo::Reading;
use crate::stock_servo::Ax12a;

const STREAMS: usize = 20_000;
/// Between two streams: the answer to most.
const ANSWER_NS: u64 = 10_000_000;
const STREAMS_PER_POWER_CYCLE: usize = 20;
/// Longer than a factory reset, and than the pause that ends a packet.
const PAUSE_NS: u64 = 200_000_000;

struct Turning {
    counts: u16,
    largest_pwm: u16,
}

impl Mechanics for Turning {
    fn convert(&mut self, _servo: usize, _at_ns: u64) -> Reading {
        self.counts = (self.counts + 1) % 1024;
        Reading {
            position: self.counts,
            temperature: 0,
        }
    }

    fn drive(&mut self, _servo: usize, _at_ns: u64, drive: MotorDrive) {
        let pwm = drive.pwm;
        self.largest_pwm = self.largest_pwm.max(pwm);
    }
}

struct Random(Pcg32);

impl Random {
    fn below(&mut self, end: u8) -> u8 {
        Uniform::new(0, end).map_or(0, |range| range.sample(&mut self.0))
    }

    /// Bytes rich in headers, or an instruction with random contents, occasionally
    /// damaged.
    fn stream(&mut self, id: u8) -> Vec<u8> {
        if self.below(4) == 0 {
            let count = self.below(20);
            return (0..count)
                .map(|_| {
                    if self.below(3) == 0 {
                        0xFF
                    } else {
                        self.below(255)
                    }
                })
                .collect();
        }
        let known = [1, 2, 3, 3, 3, 4, 5, 6, 0x83, 0x92];
        let place = usize::from(self.below(known.len() as u8));
        let address = self.below(AX12A.size as u8 + 2);
        let mut parameters = vec![address];
        for _ in 0..=self.below(4) {
            let byte = if self.below(2) == 0 {
                self.below(4)
            } else {
                self.below(255)
            };
            parameters.push(byte);
        }
        let frame = Frame {
            id: if self.below(4) == 0 { 0xFE } else { id },
            code: known[place],
            parameters: &parameters,
        };
        let mut bytes = frame.encode::<32>().unwrap().to_vec();
        if self.below(8) == 0 {
            let place = usize::from(self.below(bytes.len() as u8));
            bytes[place] ^= 1 << self.below(8);
        }
        bytes
    }
}

fn stock(wire: &Wire) -> &Ax12a {
    wire.servos().first().and_then(Device::stock).unwrap()
}

fn settings(servo: &Ax12a) -> Vec<Option<u32>> {
    let writable = AX12A
        .registers
        .iter()
        .filter(|r| r.access == Access::ReadWrite);
    writable.map(|r| servo.register(r.name)).collect()
}

#[test]
fn anything_at_all_leaves_the_servo_sound() {
    let mut random = Random(Pcg32::new(1, 0));
    let mut wire = Wire::new(vec![Ax12a::new(1, 1)]);
    let mut turning = Turning {
        counts: 0,
        largest_pwm: 0,
    };
    let (mut changes, mut last) = (0, Vec::new());
    let send = |wire: &mut Wire, turning: &mut Turning, bytes: &[u8], pause_ns: u64| {
        let bit_ns = 500 * (1 + u64::from(stock(wire).register("baud_rate").unwrap()));
        let (start_ns, baud) = (wire.now_ns(), (1_000_000_000 / bit_ns) as u32);
        for (i, byte) in bytes.iter().enumerate() {
            wire.send(start_ns + i as u64 * 10 * bit_ns, *byte, baud);
        }
        wire.advance(
            start_ns + bytes.len() as u64 * 10 * bit_ns + pause_ns,
            turning,
        );
        std::iter::from_fn(|| wire.take_received()).count()
    };
    for number in 0..STREAMS {
        if number % STREAMS_PER_POWER_CYCLE == 0 {
            // Out of the lock.
            wire.power_cycle(0, &mut turning);
            send(&mut wire, &mut turning, &[], PAUSE_NS);
            last = settings(stock(&wire));
        }
        let bytes = random.stream(stock(&wire).id());
        send(&mut wire, &mut turning, &bytes, ANSWER_NS);
        let servo = stock(&wire);
        for register in AX12A.registers {
            let value = servo.register(register.name).unwrap();
            assert!(
                register.range.contains(&value),
                "{} {value} {bytes:02x?}",
                register.name
            );
        }
        let now = settings(servo);
        changes += usize::from(now != last);
        last = now;
        if number % 7 == 0 {
            send(&mut wire, &mut turning, &[], PAUSE_NS);
            let ping = Instruction::Ping.encode::<6>(stock(&wire).id()).unwrap();
            assert_eq!(
                send(&mut wire, &mut turning, &ping, PAUSE_NS),
                6,
                "{number}"
            );
        }
    }
    assert!(changes > 500, "only {changes} streams changed anything");
    assert!((1001..=2000).contains(&turning.largest_pwm));
}
