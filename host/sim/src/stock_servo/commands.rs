//! Instructions: execution, reply, and timing.

use armbridge_servo::Alarms;
use armbridge_servo::protocol1::frame::FRAME_MAX;
use armbridge_servo::protocol1::{BROADCAST, Frame, Instruction, Status, SyncBlocks};

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
/// Bytes that a factory reset writes: the writable registers of the EEPROM.
const RESET_BYTES: u64 = 15;

/// A packet for this servo.
#[derive(Clone, Debug)]
pub(super) enum Packet {
    /// Addressed to this servo or broadcast.
    Intact {
        is_broadcast: bool,
        code: u8,
        parameters: Vec<u8>,
    },
    /// Addressed to this servo, with a wrong checksum.
    Damaged,
}

impl Packet {
    pub(super) fn intact(frame: &Frame) -> Self {
        Self::Intact {
            is_broadcast: frame.id == BROADCAST,
            code: frame.code,
            parameters: frame.parameters.to_vec(),
        }
    }

    pub(super) fn damaged() -> Self {
        Self::Damaged
    }
}

/// A pending write: until ACTION, or until its status packet has been sent.
pub(super) type Write = (u16, Vec<u8>);

/// Action after the status packet.
#[derive(Clone, Debug)]
pub(super) enum Deferred {
    Write(Write),
    Reset,
}

/// Status return level from which on an instruction has a reply.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum ReplyLevel {
    Always,
    Reading,
    All,
}

/// Result of executing an instruction.
struct Execution {
    reply_level: ReplyLevel,
    latency_ns: u64,
    alarms: Alarms,
    parameters: Vec<u8>,
    deferred_action: Option<Deferred>,
}

impl Execution {
    fn new(reply_level: ReplyLevel, latency_ns: u64, alarms: Alarms) -> Self {
        Self {
            reply_level,
            latency_ns,
            alarms,
            parameters: Vec::new(),
            deferred_action: None,
        }
    }

    /// A reply without an effect.
    fn reply_only(alarms: Alarms) -> Self {
        Self::new(ReplyLevel::All, latency::PING_NS, alarms)
    }

    fn write(alarms: Alarms, address: u16, data: &[u8]) -> Self {
        let latency_ns = latency::WRITE_NS + latency::WRITE_BYTE_NS * data.len() as u64;
        let write = || Deferred::Write((address, data.to_vec()));
        Self {
            deferred_action: alarms.is_empty().then(write),
            ..Self::new(ReplyLevel::All, latency_ns, alarms)
        }
    }
}

impl Ax12a {
    /// Executes a packet whose last stop bit ends at `end_ns`.
    pub(super) fn execute(&mut self, packet: &Packet, end_ns: u64) {
        // A packet before the reply cancels the reply, and is executed.
        self.run_deferred(end_ns);
        let (is_broadcast, outcome) = match packet {
            Packet::Damaged => (false, Some(Execution::reply_only(Alarms::CHECKSUM))),
            Packet::Intact {
                is_broadcast,
                code,
                parameters,
            } => (
                *is_broadcast,
                self.execute_instruction(*is_broadcast, *code, parameters),
            ),
        };
        let Some(outcome) = outcome else {
            return;
        };
        self.shut_down_for(outcome.alarms);
        let level = self.memory.byte(at::STATUS_RETURN_LEVEL);
        let is_replied = match outcome.reply_level {
            ReplyLevel::Always => true,
            ReplyLevel::Reading => level >= 1 && !is_broadcast,
            ReplyLevel::All => level >= 2 && !is_broadcast,
        };
        self.deferred = outcome.deferred_action;
        let status = Status {
            id: self.id(),
            alarms: self.alarms().or(outcome.alarms),
            parameters: &outcome.parameters,
        };
        match status.encode::<FRAME_MAX>() {
            Some(bytes) if is_replied => {
                let delay = u64::from(self.memory.byte(at::RETURN_DELAY)) * RETURN_DELAY_NS;
                let start_ns = end_ns + outcome.latency_ns + delay;
                self.transmitter.begin(start_ns, &bytes);
            }
            _ => {
                self.transmitter.begin(0, &[]);
                self.run_deferred(end_ns);
            }
        }
    }

    /// `None` for an instruction without effect and reply.
    fn execute_instruction(
        &mut self,
        is_broadcast: bool,
        code: u8,
        parameters: &[u8],
    ) -> Option<Execution> {
        let frame = Frame {
            id: self.id(),
            code,
            parameters,
        };
        let instruction = match Instruction::decode(&frame) {
            Ok(instruction) => instruction,
            Err(_) if code == NO_INSTRUCTION => return None,
            Err(_) => return Some(Execution::reply_only(Alarms::INSTRUCTION)),
        };
        Some(match instruction {
            Instruction::Ping => Execution::new(ReplyLevel::Always, latency::PING_NS, Alarms::NONE),
            Instruction::Read { address, count } => self.read(address, count),
            Instruction::Write { address, data } => {
                Execution::write(self.memory.check(address, data), address, data)
            }
            Instruction::RegWrite { address, data } => {
                let mut outcome = Execution::write(self.memory.check(address, data), address, data);
                if outcome.deferred_action.take().is_some() {
                    self.registered = Some((address, data.to_vec()));
                    self.memory.set_byte(at::REGISTERED, 1);
                }
                outcome
            }
            Instruction::Action => self.action(),
            Instruction::FactoryReset => Execution {
                deferred_action: Some(Deferred::Reset),
                ..Execution::reply_only(Alarms::NONE)
            },
            Instruction::SyncWrite {
                address,
                count,
                blocks,
            } if is_broadcast => {
                let own = SyncBlocks::new(count, blocks).find(|(id, _)| *id == self.id());
                let (_, data) = own?;
                Execution::write(self.memory.check(address, data), address, data)
            }
            // The others are not part of Protocol 1.0.
            Instruction::SyncWrite { .. }
            | Instruction::SyncRead { .. }
            | Instruction::FastSyncRead { .. }
            | Instruction::Start
            | Instruction::Cycle => Execution::reply_only(Alarms::INSTRUCTION),
        })
    }

    fn read(&self, address: u16, count: u16) -> Execution {
        let bytes = self.memory.read(address, count).filter(|_| count > 0);
        let alarms = match bytes {
            Some(_) => Alarms::NONE,
            None => Alarms::RANGE,
        };
        Execution {
            parameters: bytes.unwrap_or_default().to_vec(),
            ..Execution::new(ReplyLevel::Reading, latency::READ_NS, alarms)
        }
    }

    /// ACTION: checks the registered write again, because registers may have changed.
    fn action(&mut self) -> Execution {
        self.memory.set_byte(at::REGISTERED, 0);
        match self.registered.take() {
            Some((address, data)) => {
                Execution::write(self.memory.check(address, &data), address, &data)
            }
            None => Execution::reply_only(Alarms::INSTRUCTION),
        }
    }

    /// Executes the action that was deferred until after the status packet.
    pub(super) fn run_deferred(&mut self, now_ns: u64) {
        let eeprom = match self.deferred.take() {
            None => return,
            Some(Deferred::Write((address, data))) => {
                self.memory.write(address, &data);
                let end = usize::from(address) + data.len();
                let writes_goal = usize::from(address) < usize::from(at::GOAL_POSITION) + 2
                    && end > usize::from(at::GOAL_POSITION);
                if writes_goal && !self.memory.is_wheel() {
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
