//! Random bytes, mixed wires, determinism.

use armbridge_servo::protocol1;
use armbridge_servo::protocol2::register as at;
use armbridge_servo::protocol2::{Frame, Instruction, model};
use rand_distr::{Distribution, Uniform};
use rand_pcg::Pcg32;

use super::super::XServo;
use super::super::table;
use super::{CODE_1M, Rig, statuses};
use crate::half_duplex_bus::Device;
use crate::stock_servo::Ax12a;

const STREAMS: usize = 4_000;
/// Longer than the pause that ends a packet, and than a start.
const PAUSE_NS: u64 = 250_000_000;

struct Random(Pcg32);

impl Random {
    fn below(&mut self, end: u8) -> u8 {
        Uniform::new(0, end).map_or(0, |range| range.sample(&mut self.0))
    }

    fn byte(&mut self) -> u8 {
        match self.below(4) {
            0 => 0xFF,
            1 => 0xFD,
            2 => self.below(4),
            _ => self.below(255),
        }
    }

    /// Bytes rich in headers, or an instruction with random contents, sometimes damaged.
    fn stream(&mut self) -> Vec<u8> {
        let count = self.below(24);
        let parameters: Vec<u8> = (0..count).map(|_| self.byte()).collect();
        if self.below(4) == 0 {
            return parameters;
        }
        let known = [
            1, 2, 3, 3, 3, 4, 5, 6, 8, 0x10, 0x82, 0x83, 0x8A, 0x92, 0x93, 0x9A, 0x55,
        ];
        let code = known[usize::from(self.below(known.len() as u8))];
        let id = [1, 2, 0xFE][usize::from(self.below(3))];
        let frame = Frame {
            id,
            code,
            parameters: &parameters,
        };
        let mut bytes = frame.encode::<128>().unwrap().to_vec();
        if self.below(8) == 0 {
            let place = usize::from(self.below(bytes.len() as u8));
            bytes[place] ^= 1 << self.below(8);
        }
        bytes
    }
}

/// Feeds random streams; returns all that is received.
fn run(seed: u64) -> (Vec<u8>, Rig) {
    let mut rig = Rig::new(&[(1060, 1), (1200, 2)]);
    let mut random = Random(Pcg32::new(seed, 5));
    let mut received = Vec::new();
    for stream in 0..STREAMS {
        let bytes = random.stream();
        rig.shafts.counts[0] = u16::from(random.below(255)) * 16;
        received.extend(rig.exchange(&bytes));
        assert!(rig.shafts.last(0).is_none_or(|(_, pwm)| pwm <= 2_000));
        if stream % 50 == 0 {
            for servo in 0..2 {
                rig.wire.power_cycle(servo, &mut rig.shafts);
                let (id, code) = (1 + servo as u8, CODE_1M);
                let memory = &mut rig.servo(servo).memory;
                memory.reset_eeprom();
                memory.set_byte(at::ID, id);
                memory.set_byte(at::BAUD_RATE, code);
            }
            rig.wait(PAUSE_NS);
            let status = rig.status(1, Instruction::Ping);
            assert_eq!((status.id, status.parameters.len()), (1, 3));
        }
    }
    (received, rig)
}

#[test]
fn random_bytes_do_no_harm_and_equal_ones_give_equal_results() {
    let (received, mut rig) = run(1);
    for servo in 0..2 {
        let servo = rig.servo(servo);
        let specification = super::super::specification::find(servo.model());
        for register in table::registers(servo.model(), specification) {
            let value = servo.register(register.address).unwrap();
            if let Some([lowest, highest]) = register.range
                && register.address != at::BUS_WATCHDOG
            {
                assert!((lowest..=highest).contains(&value), "{register:?} {value}");
            }
        }
    }
    let (again, other) = run(1);
    assert_eq!(received, again);
    assert_eq!(rig.shafts.driven, other.shafts.driven);
    assert_ne!(run(2).0, received);
}

#[test]
fn both_protocols_share_a_wire() {
    let x = XServo::new(model::find(1060).unwrap(), 1, CODE_1M);
    let servos: Vec<Device> = vec![x.into(), Ax12a::new(2, 1).into(), Ax12a::new(1, 1).into()];
    let mut rig = Rig::with(servos);
    for _ in 0..20 {
        // Each of the two with id 1 answers its own protocol only.
        let answer = rig.ask(1, Instruction::Ping);
        assert_eq!(answer.len(), 14);
        assert_eq!(statuses(&answer).len(), 1);
        let read = Instruction::Read {
            address: at::PRESENT_POSITION,
            count: 4,
        };
        assert_eq!(statuses(&rig.ask(1, read)).len(), 1);
        for id in [1, 2] {
            let ping = protocol1::Instruction::Ping.encode::<16>(id).unwrap();
            let answer = rig.exchange(&ping);
            assert_eq!(answer[..5], [0xFF, 0xFF, id, 2, 0]);
            assert_eq!(answer.len(), 6);
        }
    }
}
