//! Packets for stock servos and those of the X series.

use super::verdict::{Verdict, is_controlled};
use crate::bridge::transparent_port::request::{BusQuery, PendingRequest, RegisterRead};
use crate::bridge::transparent_port::response::{Bytes, Responder};
use armbridge_servo::protocol1::BROADCAST;
use armbridge_servo::{
    Alarms, ClientRequest, Instruction, ServoIds, SyncBlocks, protocol1, protocol2,
};

/// Registers on which a verdict depends.
pub(super) struct Registers {
    /// Ids to which the servo answers or listens.
    ids: [u16; 2],
    /// The only register that does not affect the control loop.
    led: u16,
}

/// Those of a stock servo.
pub(super) const AX12A: Registers = Registers {
    ids: [protocol1::register::ID; 2],
    led: protocol1::register::LED,
};

/// Those of an X servo.
pub(super) const X: Registers = Registers {
    ids: [protocol2::register::ID, protocol2::register::SHADOW_ID],
    led: protocol2::register::LED,
};

/// Decides on a packet.
pub(super) fn decide(
    responder: Responder,
    registers: &Registers,
    controlled: ServoIds,
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
        Ok(instruction) if is_harmless(registers, controlled, id, instruction) => {
            // Refused if it is too long for any slot.
            Bytes::from_slice(request.bytes).map_or_else(
                |_| Verdict::Refuse(responder.refusal()),
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
fn is_harmless(
    registers: &Registers,
    controlled: ServoIds,
    id: u8,
    instruction: Instruction,
) -> bool {
    let is_free = |id: u8| id < BROADCAST && !is_controlled(controlled, id);
    // A servo that takes the id of one under control would answer in its place.
    let keeps_clear = |address: u16, data: &[u8]| {
        registers.ids.iter().all(|id| {
            id.checked_sub(address)
                .and_then(|offset| data.get(usize::from(offset)))
                .is_none_or(|new_id| is_free(*new_id))
        })
    };
    match instruction {
        Instruction::Ping => id < BROADCAST,
        Instruction::Write { address, data: [_] } if address == registers.led => id < BROADCAST,
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
        | Instruction::SyncRead { .. }
        | Instruction::FastSyncRead { .. }
        | Instruction::Action
        | Instruction::FactoryReset
        | Instruction::Start
        | Instruction::Cycle => false,
    }
}
