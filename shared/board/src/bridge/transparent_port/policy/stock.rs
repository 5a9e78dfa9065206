//! Packets for stock servos.

use super::verdict::{Verdict, is_controlled};
use crate::bridge::transparent_port::request::{BusQuery, PendingRequest, RegisterRead};
use crate::bridge::transparent_port::response::Responder;
use armbridge_servo::protocol1::{BROADCAST, register};
use armbridge_servo::{Alarms, ClientRequest, Instruction, JOINTS, ServoId, SyncBlocks};

/// Decides on a packet for stock servos.
pub(super) fn decide(
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
                |read| Verdict::Query(PendingRequest::read(responder, read)),
            )
        }
        Ok(instruction) if is_harmless(controlled, id, instruction) => {
            // Refused if it is too long for any slot.
            instruction.encode(id).map_or_else(
                || Verdict::Refuse(responder.refusal()),
                |packet| {
                    // Answered with an error byte only; a broadcast is not answered.
                    let reply_bytes = request.expected_reply().reply_bytes;
                    Verdict::Query(PendingRequest::single(
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

/// Whether an instruction affects no servo under control.
fn is_harmless(controlled: [ServoId; JOINTS], id: u8, instruction: Instruction) -> bool {
    let is_free = |id: u8| id < BROADCAST && !is_controlled(controlled, id);
    // A servo that takes the id of one under control would answer in its place.
    let keeps_clear = |address: u16, data: &[u8]| {
        register::ID
            .checked_sub(address)
            .and_then(|offset| data.get(usize::from(offset)))
            .is_none_or(|new_id| is_free(*new_id))
    };
    match instruction {
        Instruction::Ping
        // The only register that does not affect the control loop.
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
