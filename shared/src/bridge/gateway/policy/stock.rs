//! Packets for stock servos.

use super::{Verdict, is_controlled};
use crate::JOINTS;
use crate::bridge::gateway::job::{Ask, Job, Reading, Target};
use crate::bridge::gateway::voice::{Bytes, Voice};
use crate::servo::morpheus::ServoId;
use crate::servo::protocol1::frame::{HEADER, OVERHEAD, checksum};
use crate::servo::protocol1::{Alarms, BROADCAST, Frame, Instruction, SyncBlocks};

/// Address of `led` in the table: the one thing to write that a control loop
/// does not mind.
const LED: u8 = 25;
/// Address of `id`.
const ID: u8 = 3;

pub(super) fn judge(controlled: [ServoId; JOINTS], packet: &[u8]) -> Verdict {
    let [HEADER, HEADER, body @ .., sum] = packet else {
        return Verdict::SILENT_REFUSAL;
    };
    let &[id, length, code, ref parameters @ ..] = body else {
        return Verdict::SILENT_REFUSAL;
    };
    if usize::from(length) != parameters.len() + 2 {
        return Verdict::SILENT_REFUSAL;
    }
    let voice = Voice::Stock { id };
    if checksum(body) != *sum {
        return Verdict::Answer(voice.says(Alarms::CHECKSUM, &[]));
    }
    let frame = Frame {
        id,
        code,
        parameters,
    };
    match Instruction::decode(&frame) {
        Ok(Instruction::Read { address, count }) if id < BROADCAST => {
            Reading::new(Target::Stock(id), address, count).map_or_else(
                || Verdict::Answer(voice.says(Alarms::RANGE, &[])),
                |reading| Verdict::Ask(Job::read(voice, reading)),
            )
        }
        Ok(instruction) if is_harmless(controlled, id, instruction) => {
            // Refused if it is longer than there is ever time for.
            instruction.encode(id).map_or_else(
                || Verdict::Refuse(voice.refuses()),
                |packet| Verdict::Ask(Job::single(voice, ask(id, packet))),
            )
        }
        Ok(_) | Err(_) => Verdict::Refuse(voice.refuses()),
    }
}

/// A request that is answered with no more than an error byte, and if it goes
/// to all servos with nothing.
fn ask(id: u8, packet: Bytes) -> Ask {
    Ask {
        packet,
        id,
        reply_bytes: if id < BROADCAST { OVERHEAD as u8 } else { 0 },
    }
}

/// Whether a servo under control is none the worse for it.
fn is_harmless(controlled: [ServoId; JOINTS], id: u8, instruction: Instruction) -> bool {
    let is_free = |id: u8| id < BROADCAST && !is_controlled(controlled, id);
    // What has an id that is under control would answer in its place.
    let keeps_clear = |address: u8, data: &[u8]| {
        ID.checked_sub(address)
            .and_then(|offset| data.get(usize::from(offset)))
            .is_none_or(|new_id| is_free(*new_id))
    };
    match instruction {
        Instruction::Ping
        | Instruction::Write {
            address: LED,
            data: [_],
        } => id < BROADCAST,
        Instruction::Write { address, data } | Instruction::RegWrite { address, data } => {
            is_free(id) && keeps_clear(address, data)
        }
        Instruction::SyncWrite {
            address,
            count,
            blocks,
        } => {
            id == BROADCAST
                && SyncBlocks::new(count, blocks)
                    .all(|(id, data)| is_free(id) && keeps_clear(address, data))
        }
        Instruction::Read { .. } | Instruction::Action | Instruction::FactoryReset => false,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::servo::table::AX12A;

    #[test]
    fn addresses_are_the_tables() {
        assert_eq!(AX12A.by_name("led").map(|led| led.address), Some(LED));
        assert_eq!(AX12A.by_name("id").map(|id| id.address), Some(ID));
    }
}
