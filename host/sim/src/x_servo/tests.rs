//! The X servo as a master meets it, on the wire.

mod answers;
mod chains;
mod garbage;
mod motion;
mod safety;

use armbridge_servo::protocol2::{Instruction, Parser, Status, StatusError, model};

use super::XServo;
use crate::half_duplex_bus::{Device, Mechanics, MotorDrive, ReceivedByte, Wire};
use crate::morpheus_servo::Reading;

/// Longer than the answer to one servo, with the return delay from the factory, at 1 Mbaud.
const ANSWER_NS: u64 = 3_000_000;
/// Longer than a servo needs to start.
const START_NS: u64 = 105_000_000;
/// Code of 1 Mbaud.
const CODE_1M: u8 = 3;

/// Shafts at fixed counts, and the PWM that each motor gets.
#[derive(Clone, Debug, Default)]
struct Shafts {
    counts: [u16; 3],
    /// Counts per ms.
    speeds: [u16; 3],
    driven: Vec<(usize, u64, u16)>,
}

impl Shafts {
    /// Last change of a motor's PWM: time, and PWM.
    fn last(&self, servo: usize) -> Option<(u64, u16)> {
        let mut changes = self.driven.iter().rev();
        let last = changes.find(|(driven, ..)| *driven == servo);
        last.map(|(_, at_ns, pwm)| (*at_ns, *pwm))
    }
}

impl Mechanics for Shafts {
    fn convert(&mut self, servo: usize, _at_ns: u64) -> Reading {
        let count = &mut self.counts[servo];
        *count = (*count + self.speeds[servo]) % 4_096;
        Reading {
            position: *count,
            temperature: 0,
        }
    }

    fn drive(&mut self, servo: usize, at_ns: u64, drive: MotorDrive) {
        let pwm = drive.pwm;
        self.driven.push((servo, at_ns, pwm));
    }
}

/// A master and servos.
struct Rig {
    wire: Wire,
    shafts: Shafts,
    now_ns: u64,
    baud: u32,
}

impl Rig {
    /// Servos with these model numbers and ids, at 1 Mbaud.
    fn new(servos: &[(u16, u8)]) -> Self {
        let device = |(number, id): &(u16, u8)| {
            let model = model::find(*number).unwrap();
            Device::from(XServo::new(model, *id, CODE_1M))
        };
        Self::with(servos.iter().map(device).collect())
    }

    fn with(servos: Vec<Device>) -> Self {
        let mut rig = Self {
            wire: Wire::new(servos),
            shafts: Shafts::default(),
            now_ns: 0,
            baud: 1_000_000,
        };
        rig.wait(START_NS);
        rig
    }

    fn servo(&mut self, servo: usize) -> &mut XServo {
        self.wire.servo_mut(servo).x_series_mut().unwrap()
    }

    fn register(&mut self, servo: usize, address: u16) -> i32 {
        self.servo(servo).register(address).unwrap()
    }

    fn send(&mut self, bytes: &[u8]) {
        let byte_ns = 10 * (1_000_000_000 / u64::from(self.baud));
        for (start_ns, byte) in (self.now_ns..).step_by(byte_ns as usize).zip(bytes) {
            self.wire.send(start_ns, *byte, self.baud);
        }
    }

    fn wait(&mut self, ns: u64) -> Vec<ReceivedByte> {
        self.now_ns += ns;
        self.wire.advance(self.now_ns, &mut self.shafts);
        std::iter::from_fn(|| self.wire.take_received()).collect()
    }

    /// Bytes received within this time after these are sent.
    fn exchange_for(&mut self, bytes: &[u8], ns: u64) -> Vec<u8> {
        self.send(bytes);
        let answer = self.wait(ns);
        answer.iter().map(|received| received.byte).collect()
    }

    fn exchange(&mut self, bytes: &[u8]) -> Vec<u8> {
        self.exchange_for(bytes, ANSWER_NS)
    }

    fn ask(&mut self, id: u8, instruction: Instruction) -> Vec<u8> {
        let bytes = instruction.encode::<259>(id).unwrap();
        self.exchange(&bytes)
    }

    /// Writes.
    ///
    /// # Errors
    /// The error of the answer, or nothing if there is no answer.
    fn write(&mut self, id: u8, address: u16, data: &[u8]) -> Result<(), Option<StatusError>> {
        let answer = self.ask(id, Instruction::Write { address, data });
        match statuses(&answer).first() {
            None => Err(None),
            Some(status) => status.error.map_or(Ok(()), |error| Err(Some(error))),
        }
    }

    /// Writes permitted values.
    fn set(&mut self, id: u8, address: u16, data: &[u8]) {
        assert_eq!(self.write(id, address, data), Ok(()), "{address}");
    }

    /// Power-cycles all servos with their shafts at these counts.
    fn restart_at(&mut self, counts: [u16; 3]) {
        self.shafts.counts = counts;
        for servo in 0..self.wire.servos().len() {
            self.wire.power_cycle(servo, &mut self.shafts);
        }
        self.wait(START_NS);
    }

    /// The only status packet of an answer.
    fn status(&mut self, id: u8, instruction: Instruction) -> Answer {
        let answer = self.ask(id, instruction);
        let mut statuses = statuses(&answer);
        assert_eq!(statuses.len(), 1);
        statuses.remove(0)
    }
}

/// A status packet.
#[derive(Clone, Debug, PartialEq, Eq)]
struct Answer {
    id: u8,
    is_alert: bool,
    error: Option<StatusError>,
    parameters: Vec<u8>,
}

/// The status packets among some bytes.
fn statuses(bytes: &[u8]) -> Vec<Answer> {
    let mut parser = Parser::<1024>::new();
    let mut found = Vec::new();
    for byte in bytes {
        if let Some(Ok(frame)) = parser.push(*byte)
            && let Some(status) = Status::decode(&frame)
        {
            found.push(Answer {
                id: status.id,
                is_alert: status.is_alert,
                error: status.error,
                parameters: status.parameters.to_vec(),
            });
        }
    }
    found
}
