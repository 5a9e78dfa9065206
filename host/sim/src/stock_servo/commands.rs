//! Instructions: execution, reply, and timing.

use armbridge_shared::servo::protocol1::frame::FRAME_MAX;
use armbridge_shared::servo::protocol1::{
    Alarms, BROADCAST, Frame, Instruction, Status, SyncBlocks,
};

use super::memory::{at, eeprom_bytes};
use super::{Ax12a, EEPROM_BYTE_NS};

/// From the end of an instruction to its status packet, without return delay.
mod latency {
    pub(super) const PING_NS: u64 = 18_000;
    pub(super) const READ_NS: u64 = 22_000;
    pub(super) const WRITE_NS: u64 = 24_000;
    pub(super) const WRITE_BYTE_NS: u64 = 6_000;
}
/// Unit of the return delay register.
const RETURN_DELAY_NS: u64 = 2_000;
/// Code of a status packet without alarms.
const NO_INSTRUCTION: u8 = 0;
/// Bytes that a factory reset writes: the EEPROM's registers that can be.
const RESET_BYTES: u64 = 15;

/// A packet for this servo.
#[derive(Clone, Debug)]
pub(super) enum Packet {
    /// For it alone or for all.
    Intact {
        to_all: bool,
        code: u8,
        parameters: Vec<u8>,
    },
    /// For it alone, with a wrong checksum.
    Damaged,
}

impl Packet {
    pub(super) fn of(frame: &Frame) -> Self {
        Self::Intact {
            to_all: frame.id == BROADCAST,
            code: frame.code,
            parameters: frame.parameters.to_vec(),
        }
    }

    pub(super) fn damaged() -> Self {
        Self::Damaged
    }
}

/// A write that waits: for ACTION, or for its own status packet to have left.
pub(super) type Write = (u8, Vec<u8>);

/// Action after the status packet.
#[derive(Clone, Debug)]
pub(super) enum Deferred {
    Write(Write),
    Reset,
}

/// From which status return level on an instruction is answered.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Answered {
    Always,
    Reading,
    All,
}

/// Processing of an instruction.
struct Outcome {
    answered: Answered,
    latency_ns: u64,
    alarms: Alarms,
    parameters: Vec<u8>,
    then: Option<Deferred>,
}

impl Outcome {
    fn of(answered: Answered, latency_ns: u64, alarms: Alarms) -> Self {
        Self {
            answered,
            latency_ns,
            alarms,
            parameters: Vec::new(),
            then: None,
        }
    }

    /// Nothing but an answer.
    fn only(alarms: Alarms) -> Self {
        Self::of(Answered::All, latency::PING_NS, alarms)
    }

    fn write(alarms: Alarms, address: u8, data: &[u8]) -> Self {
        let latency_ns = latency::WRITE_NS + latency::WRITE_BYTE_NS * data.len() as u64;
        let write = || Deferred::Write((address, data.to_vec()));
        Self {
            then: alarms.is_empty().then(write),
            ..Self::of(Answered::All, latency_ns, alarms)
        }
    }
}

impl Ax12a {
    /// Executes a packet whose last stop bit ends at `end_ns`.
    pub(super) fn obey(&mut self, packet: &Packet, end_ns: u64) {
        // A packet before the reply cancels that, but is executed.
        self.do_deferred(end_ns);
        let (to_all, outcome) = match packet {
            Packet::Damaged => (false, Some(Outcome::only(Alarms::CHECKSUM))),
            Packet::Intact {
                to_all,
                code,
                parameters,
            } => (*to_all, self.outcome(*to_all, *code, parameters)),
        };
        let Some(outcome) = outcome else {
            return;
        };
        self.shut_down_for(outcome.alarms);
        let level = self.memory.byte(at::STATUS_RETURN_LEVEL);
        let is_answered = match outcome.answered {
            Answered::Always => true,
            Answered::Reading => level >= 1 && !to_all,
            Answered::All => level >= 2 && !to_all,
        };
        self.deferred = outcome.then;
        let status = Status {
            id: self.id(),
            alarms: self.alarms().or(outcome.alarms),
            parameters: &outcome.parameters,
        };
        match status.encode::<FRAME_MAX>() {
            Some(bytes) if is_answered => {
                let delay = u64::from(self.memory.byte(at::RETURN_DELAY)) * RETURN_DELAY_NS;
                let start_ns = end_ns + outcome.latency_ns + delay;
                self.sending.begin(start_ns, &bytes);
            }
            _ => {
                self.sending.begin(0, &[]);
                self.do_deferred(end_ns);
            }
        }
    }

    /// `None` for an instruction without effect and reply.
    fn outcome(&mut self, to_all: bool, code: u8, parameters: &[u8]) -> Option<Outcome> {
        let frame = Frame {
            id: self.id(),
            code,
            parameters,
        };
        let instruction = match Instruction::decode(&frame) {
            Ok(instruction) => instruction,
            Err(_) if code == NO_INSTRUCTION => return None,
            Err(_) => return Some(Outcome::only(Alarms::INSTRUCTION)),
        };
        Some(match instruction {
            Instruction::Ping => Outcome::of(Answered::Always, latency::PING_NS, Alarms::NONE),
            Instruction::Read { address, count } => self.read(address, count),
            Instruction::Write { address, data } => {
                Outcome::write(self.memory.check(address, data), address, data)
            }
            Instruction::RegWrite { address, data } => {
                let mut outcome = Outcome::write(self.memory.check(address, data), address, data);
                if outcome.then.take().is_some() {
                    self.registered = Some((address, data.to_vec()));
                    self.memory.set_byte(at::REGISTERED, 1);
                }
                outcome
            }
            Instruction::Action => self.action(),
            Instruction::FactoryReset => Outcome {
                then: Some(Deferred::Reset),
                ..Outcome::only(Alarms::NONE)
            },
            Instruction::SyncWrite {
                address,
                count,
                blocks,
            } if to_all => {
                let own = SyncBlocks::new(count, blocks).find(|(id, _)| *id == self.id());
                let (_, data) = own?;
                Outcome::write(self.memory.check(address, data), address, data)
            }
            // The last two are none of Protocol 1.0's.
            Instruction::SyncWrite { .. } | Instruction::Start | Instruction::Cycle => {
                Outcome::only(Alarms::INSTRUCTION)
            }
        })
    }

    fn read(&self, address: u8, count: u8) -> Outcome {
        let bytes = self.memory.read(address, count).filter(|_| count > 0);
        let alarms = match bytes {
            Some(_) => Alarms::NONE,
            None => Alarms::RANGE,
        };
        Outcome {
            parameters: bytes.unwrap_or_default().to_vec(),
            ..Outcome::of(Answered::Reading, latency::READ_NS, alarms)
        }
    }

    /// Time may have passed since the write was found to be right.
    fn action(&mut self) -> Outcome {
        self.memory.set_byte(at::REGISTERED, 0);
        match self.registered.take() {
            Some((address, data)) => {
                Outcome::write(self.memory.check(address, &data), address, &data)
            }
            None => Outcome::only(Alarms::INSTRUCTION),
        }
    }

    /// The action that waited for the status packet.
    pub(super) fn do_deferred(&mut self, now_ns: u64) {
        let eeprom = match self.deferred.take() {
            None => return,
            Some(Deferred::Write((address, data))) => {
                self.memory.write(address, &data);
                let end = usize::from(address) + data.len();
                let touches_goal = usize::from(address) < usize::from(at::GOAL_POSITION) + 2
                    && end > usize::from(at::GOAL_POSITION);
                if touches_goal && !self.memory.is_wheel() {
                    self.memory.set_byte(at::TORQUE_ENABLE, 1);
                    self.motor.new_goal();
                }
                eeprom_bytes(address, data.len())
            }
            Some(Deferred::Reset) => {
                self.memory.reset();
                RESET_BYTES
            }
        };
        self.deaf_until_ns = self.deaf_until_ns.max(now_ns + eeprom * EEPROM_BYTE_NS);
    }
}
