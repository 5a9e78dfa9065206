//! The stock servo as a master meets it, on the bench with the arm.

mod answers;
mod garbage;
mod motion;
mod timing;

use armbridge_servo::protocol1::{BROADCAST, Instruction};
use armbridge_servo::{Alarms, Firmware};

use crate::Bench;
use crate::half_duplex_bus::ReceivedByte;
use crate::plant::{Plant, PlantConfig};
use crate::servo_kind::ServoKind;

/// Longer than any answer with the return delay of a servo ex works, at 1 Mbaud.
const ANSWER_US: u64 = 2_000;
/// No answer.
const NOTHING: [u8; 0] = [];

/// A master, stock servos 1 and 2 on the arm, and others.
struct Rig {
    bench: Bench,
    now_us: u64,
}

impl Rig {
    fn new() -> Self {
        Self::with(&[(Firmware::Stock, 1), (Firmware::Stock, 2)])
    }

    fn with(servos: &[(Firmware, u8)]) -> Self {
        let kinds: Vec<ServoKind> = servos
            .iter()
            .map(|(firmware, id)| ServoKind::new(*firmware, *id, 1_000_000).unwrap())
            .collect();
        let plant = Plant::new(PlantConfig::default(), 1);
        let mut rig = Self {
            bench: Bench::with_servos(plant, &kinds),
            now_us: 0,
        };
        rig.wait(5_000);
        rig
    }

    /// Bytes received in this time.
    fn wait(&mut self, us: u64) -> Vec<ReceivedByte> {
        let mut received = Vec::new();
        self.now_us += us;
        self.bench.advance_timed(self.now_us, None, &mut received);
        received
    }

    fn send(&mut self, bytes: &[u8]) {
        self.bench.send(self.now_us, bytes);
    }

    /// Reply to these bytes.
    fn exchange(&mut self, bytes: &[u8]) -> Vec<u8> {
        self.send(bytes);
        let answer = self.wait(ANSWER_US);
        answer.iter().map(|received| received.byte).collect()
    }

    fn ask(&mut self, id: u8, instruction: Instruction) -> Vec<u8> {
        let bytes = instruction.encode::<259>(id).unwrap();
        self.exchange(&bytes)
    }

    /// Writes; the alarms that are answered with.
    fn write(&mut self, id: u8, address: u8, data: &[u8]) -> Option<Alarms> {
        let answer = self.ask(
            id,
            Instruction::Write {
                address: address.into(),
                data,
            },
        );
        answer.get(4).copied().map(Alarms::from_bits)
    }

    /// Writes permitted values.
    fn set(&mut self, id: u8, address: u8, data: &[u8]) {
        assert_eq!(self.write(id, address, data), Some(Alarms::NONE));
    }

    fn set_word(&mut self, id: u8, address: u8, value: u16) {
        self.set(id, address, &value.to_le_bytes());
    }

    /// Wheel mode, torque on.
    fn wheel(&mut self, id: u8) {
        self.set(id, 6, &[0; 4]);
        self.wait(50_000);
        self.set(id, 24, &[1]);
    }

    fn register(&self, servo: usize, name: &str) -> u32 {
        self.bench.servos()[servo]
            .stock()
            .unwrap()
            .register(name)
            .unwrap()
    }

    fn alarms(&mut self, id: u8) -> Alarms {
        let answer = self.ask(id, Instruction::Ping);
        Alarms::from_bits(answer[4])
    }

    fn broadcast(&mut self, instruction: Instruction) -> Vec<u8> {
        self.ask(BROADCAST, instruction)
    }
}
