//! Packets for stock servos.

use super::verdict::{Verdict, is_controlled};
use crate::JOINTS;
use crate::bridge::gateway::request::{BusQuery, PendingRequest, RegisterRead};
use crate::bridge::gateway::response::Responder;
use crate::servo::protocol1::{Alarms, BROADCAST, register};
use crate::servo::{ClientRequest, Instruction, ServoId, SyncBlocks};

pub(super) fn judge(
    responder: Responder,
    controlled: [ServoId; JOINTS],
    request: &ClientRequest,
) -> Verdict {
    let id = request.destination;
    if !request.is_intact {
        return Verdict::Answer(responder.reply(Alarms::CHECKSUM, &[]));
    }
    match request.instruction {
        Ok(Instruction::Read { address, count }) if id < BROADCAST => {
            RegisterRead::new(responder, None, address, count).map_or_else(
                || Verdict::Answer(responder.reply(Alarms::RANGE, &[])),
                |read| Verdict::Ask(PendingRequest::read(responder, read)),
            )
        }
        Ok(instruction) if is_harmless(controlled, id, instruction) => {
            // Refused if it is longer than there is ever time for.
            instruction.encode(id).map_or_else(
                || Verdict::Refuse(responder.refusal()),
                |packet| {
                    // Answered with no more than an error byte, and if it goes to all
                    // servos with nothing.
                    let reply_bytes = request.expected_reply().reply_bytes;
                    Verdict::Ask(PendingRequest::single(
                        responder,
                        BusQuery {
                            packet,
                            id,
                            reply_bytes,
                        },
                    ))
                },
            )
        }
        Ok(_) | Err(_) => Verdict::Refuse(responder.refusal()),
    }
}

/// Whether a servo under control is none the worse for it.
fn is_harmless(controlled: [ServoId; JOINTS], id: u8, instruction: Instruction) -> bool {
    let is_free = |id: u8| id < BROADCAST && !is_controlled(controlled, id);
    // What has an id that is under control would answer in its place.
    let keeps_clear = |address: u8, data: &[u8]| {
        register::ID
            .checked_sub(address)
            .and_then(|offset| data.get(usize::from(offset)))
            .is_none_or(|new_id| is_free(*new_id))
    };
    match instruction {
        Instruction::Ping
        // The one thing to write that a control loop does not mind.
        | Instruction::Write {
            address: register::LED,
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
        Instruction::Read { .. }
        | Instruction::Action
        | Instruction::FactoryReset
        | Instruction::Start
        | Instruction::Cycle => false,
    }
}
