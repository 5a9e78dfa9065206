//! Instructions: execution, reply, and timing.

use armbridge_servo::protocol2::register as at;
use armbridge_servo::protocol2::{
    BROADCAST, Frame, Instruction, InstructionError, Status, StatusError,
};

use super::chain;
use super::effects::Deferred;
use super::table;
use super::{BYTE_BITS, PROCESSING_NS, Stage, XServo};

/// Unit of the return delay register (e-Manual, "Return Delay Time").
const RETURN_DELAY_NS: u64 = 2_000;
/// Time that each id has in the answers to a broadcast ping, beside that of a status packet: what
/// ROBOTIS's `DynamixelSDK` waits for ("broadcastPing").
const PING_SLOT_NS: u64 = 3_000_000;
/// Bytes of the answer to a ping.
const PING_BYTES: u64 = 14;
/// Longest reply.
pub(super) const REPLY_MAX: usize = 1_024;

/// An instruction packet.
#[derive(Clone, Debug)]
pub(super) struct Packet {
    pub(super) id: u8,
    code: u8,
    parameters: Vec<u8>,
}

impl Packet {
    pub(super) fn new(frame: &Frame) -> Self {
        Self {
            id: frame.id,
            code: frame.code,
            parameters: frame.parameters.to_vec(),
        }
    }
}

/// Whom an instruction means.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Addressee {
    This,
    All,
    /// All with the same secondary id.
    Group,
}

/// Status return level from which on an instruction has a reply.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum ReplyLevel {
    Always,
    Reading,
    All,
}

/// Reply of an instruction to one servo.
type Reply = (ReplyLevel, Result<Vec<u8>, StatusError>);

impl XServo {
    /// Executes an intact instruction packet whose last stop bit ends at `end_ns`.
    pub(super) fn execute(&mut self, packet: &Packet, end_ns: u64) {
        self.last_instruction_ns = end_ns;
        self.turn = None;
        let to = match packet.id {
            id if id == self.id() => Addressee::This,
            BROADCAST => Addressee::All,
            id if id == self.memory.byte(at::SHADOW_ID) => Addressee::Group,
            _ => return,
        };
        // A packet before the reply cancels the reply, and is executed.
        self.transmit(0, &[]);
        self.run_deferred(end_ns);
        if self.stage == Stage::Boot {
            return;
        }
        let frame = Frame {
            id: packet.id,
            code: packet.code,
            parameters: &packet.parameters,
        };
        match Instruction::decode(&frame) {
            Ok(instruction) => self.execute_instruction(to, &instruction, end_ns),
            Err(InstructionError::Unknown(_)) => {
                let reply = (ReplyLevel::All, Err(StatusError::Instruction));
                self.reply(to, reply, end_ns);
            }
            Err(InstructionError::Length) => {
                let reply = (ReplyLevel::All, Err(StatusError::DataLength));
                self.reply(to, reply, end_ns);
            }
        }
        // Without a reply, there is nothing to wait for.
        if self.transmitter.next_event_ns() == u64::MAX {
            self.run_deferred(end_ns);
        }
    }

    /// Replies to a damaged packet that has this servo's id.
    pub(super) fn reply_to_damage(&mut self, end_ns: u64) {
        let reply = (ReplyLevel::All, Err(StatusError::Crc));
        self.reply(Addressee::This, reply, end_ns);
    }

    fn execute_instruction(&mut self, to: Addressee, instruction: &Instruction, end_ns: u64) {
        let is_group = to == Addressee::Group;
        let done = |result: Result<(), StatusError>| (ReplyLevel::All, result.map(|()| Vec::new()));
        let reply = match *instruction {
            Instruction::Ping if to == Addressee::All => return self.reply_in_slot(end_ns),
            Instruction::Ping => (ReplyLevel::Always, self.identity()),
            Instruction::Read { address, count } => {
                (ReplyLevel::Reading, self.memory.read(address, count))
            }
            Instruction::Write { address, data } => done(self.write(address, data, is_group)),
            Instruction::RegWrite { address, data } => {
                let checked = self.memory.check(address, data, is_group);
                if checked.is_ok() {
                    self.registered = Some((address, data.to_vec()));
                    self.memory.set_byte(at::REGISTERED_INSTRUCTION, 1);
                }
                done(checked.map(|_| ()))
            }
            Instruction::Action => done(self.act(is_group)),
            Instruction::FactoryReset(option) => done(self.reset(option, to)),
            Instruction::Reboot => {
                self.deferred = Some(Deferred::Reboot);
                done(Ok(()))
            }
            Instruction::ClearTurns => done(self.clear_turns()),
            Instruction::SyncWrite {
                count,
                blocks,
                address,
            } => {
                return self.sync_write(address, count, blocks);
            }
            Instruction::BulkWrite(blocks) => return self.bulk_write(blocks),
            Instruction::SyncRead { .. }
            | Instruction::FastSyncRead { .. }
            | Instruction::BulkRead(_)
            | Instruction::FastBulkRead(_) => {
                if let Some(place) = chain::place(instruction, self.id()) {
                    self.read_in_turn(&place, end_ns);
                }
                return;
            }
        };
        self.reply(to, reply, end_ns);
    }

    /// Model number and firmware version.
    fn identity(&self) -> Result<Vec<u8>, StatusError> {
        let mut identity = self.memory.read(at::MODEL_NUMBER, 2)?;
        identity.push(self.memory.byte(at::FIRMWARE_VERSION));
        Ok(identity)
    }

    fn write(&mut self, address: u16, data: &[u8], is_group: bool) -> Result<(), StatusError> {
        let writes = self.memory.check(address, data, is_group)?;
        if writes.iter().any(|(address, _)| *address < table::RAM) {
            self.deferred = Some(Deferred::Write(writes));
        } else {
            self.apply(&writes);
        }
        Ok(())
    }

    /// ACTION: checks the registered write again, because registers may have changed.
    fn act(&mut self, is_group: bool) -> Result<(), StatusError> {
        self.memory.set_byte(at::REGISTERED_INSTRUCTION, 0);
        let (address, data) = self.registered.take().ok_or(StatusError::Instruction)?;
        self.write(address, &data, is_group)
    }

    fn reset(&mut self, option: u8, to: Addressee) -> Result<(), StatusError> {
        let is_known = [0xFF, 1, 2].contains(&option);
        // Firmware 42 and above do not reset all ids at once.
        let is_to_all = option == 0xFF && to == Addressee::All;
        if !is_known {
            return Err(StatusError::DataRange);
        }
        if self.memory.torque_on() || is_to_all || to == Addressee::Group {
            return Err(StatusError::Access);
        }
        self.deferred = Some(Deferred::Reset(option));
        Ok(())
    }

    fn clear_turns(&mut self) -> Result<(), StatusError> {
        if self.memory.byte(at::MOVING) != 0 {
            return Err(StatusError::Failed);
        }
        self.motor.clear_turns();
        self.motor.stop(&mut self.memory);
        Ok(())
    }

    fn sync_write(&mut self, address: u16, count: u16, blocks: &[u8]) {
        let mut blocks = blocks.chunks_exact(usize::from(count) + 1);
        let own = blocks.find_map(|block| {
            let (id, data) = block.split_first()?;
            (*id == self.id()).then_some(data)
        });
        if let Some(data) = own {
            // It is never answered.
            let _ = self.write(address, data, false);
        }
    }

    fn bulk_write(&mut self, mut blocks: &[u8]) {
        while let &[id, a, b, c, d, ref rest @ ..] = blocks {
            let count = usize::from(u16::from_le_bytes([c, d]));
            let Some((data, others)) = rest.split_at_checked(count) else {
                return;
            };
            if id == self.id() {
                // It is never answered.
                let _ = self.write(u16::from_le_bytes([a, b]), data, false);
                return;
            }
            blocks = others;
        }
    }

    fn reply(&mut self, to: Addressee, (reply_level, result): Reply, end_ns: u64) {
        let level = self.memory.byte(at::STATUS_RETURN_LEVEL);
        let is_replied = match reply_level {
            ReplyLevel::Always => true,
            ReplyLevel::Reading => level >= 1,
            ReplyLevel::All => level >= 2,
        };
        if is_replied && to == Addressee::This {
            let status = self.status(&result);
            self.transmit(self.reply_start_ns(end_ns), &status);
        }
    }

    /// The answer to a broadcast ping, after those of all lower ids.
    fn reply_in_slot(&mut self, end_ns: u64) {
        let slot_ns = PING_SLOT_NS + PING_BYTES * BYTE_BITS * self.bit_ns();
        let start_ns = self.reply_start_ns(end_ns) + u64::from(self.id()) * slot_ns;
        let status = self.status(&self.identity());
        self.transmit(start_ns, &status);
    }

    pub(super) fn reply_start_ns(&self, end_ns: u64) -> u64 {
        let delay = u64::from(self.memory.byte(at::RETURN_DELAY)) * RETURN_DELAY_NS;
        end_ns + PROCESSING_NS + delay
    }

    /// Bytes of a status packet.
    pub(super) fn status(&self, result: &Result<Vec<u8>, StatusError>) -> Vec<u8> {
        let status = |parameters, error| Status {
            id: self.id(),
            is_alert: self.is_alert(),
            error,
            parameters,
        };
        let bytes = match result {
            Ok(parameters) => status(parameters, None).encode::<REPLY_MAX>(),
            Err(error) => status(&[], Some(*error)).encode(),
        };
        // More than fits is refused.
        let failed = || status(&[], Some(StatusError::Failed)).encode();
        bytes.or_else(failed).unwrap_or_default().to_vec()
    }

    pub(super) fn transmit(&mut self, start_ns: u64, bytes: &[u8]) {
        self.transmitter.begin(start_ns, bytes);
        self.sends_part = false;
    }
}
