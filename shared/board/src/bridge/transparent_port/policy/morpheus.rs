//! Packets for Morpheus servos.

use super::verdict::{Verdict, is_controlled};
use crate::bridge::transparent_port::request::{BusQuery, PendingRequest, RegisterRead};
use crate::bridge::transparent_port::response::{Bytes, Responder};
use armbridge_servo::{Alarms, ClientRequest, Instruction, JOINTS, ServoId, ServoIds};
use heapless::Vec;

/// Decides on a packet for Morpheus servos.
pub(super) fn decide(
    responder: Responder,
    controlled: ServoIds,
    samples: [Option<u16>; JOINTS],
    request: &ClientRequest,
) -> Verdict {
    if !request.is_intact {
        return Verdict::Answer(Bytes::new());
    }
    let is_client = request.is_from_master() && !is_controlled(controlled, request.source);
    match (ServoId::new(request.destination), request.instruction) {
        _ if !is_client => Verdict::Refuse(responder.refusal()),
        (Some(servo), Ok(Instruction::Ping)) => {
            let ping = responder.firmware.ping_query(servo);
            let query = BusQuery {
                // Shorter than any read.
                packet: Bytes::from_slice(&ping.packet).unwrap_or_default(),
                id: ping.id,
                reply_bytes: ping.reply_bytes,
            };
            Verdict::Query(PendingRequest::single(responder, query))
        }
        (Some(servo), Ok(Instruction::Read { address, count })) => {
            let joint = controlled.iter().position(|id| *id == servo);
            let position = joint.and_then(|joint| *samples.get(joint)?);
            match RegisterRead::new(responder, position, address, count) {
                None => Verdict::Refuse(responder.refusal()),
                // The position alone.
                Some(read) if read.is_complete() => {
                    Verdict::Answer(responder.reply(Alarms::NONE, read.data()))
                }
                Some(read) => Verdict::Query(PendingRequest::read(responder, read)),
            }
        }
        (None, Ok(Instruction::Cycle)) if request.is_broadcast() => {
            Verdict::Answer(cycle(responder, controlled, samples))
        }
        _ => Verdict::Refuse(responder.refusal()),
    }
}

/// Answer to CYCLE: the replies of the servos in the order of their ids.
fn cycle(responder: Responder, controlled: ServoIds, samples: [Option<u16>; JOINTS]) -> Bytes {
    let mut servos: Vec<_, JOINTS> = Vec::new();
    for pair in controlled.iter().zip(samples) {
        // There is room for each joint's.
        let _ = servos.push(pair);
    }
    servos.sort_unstable_by_key(|(servo, _)| servo.get());
    let mut answers = Bytes::new();
    for (servo, counts) in &servos {
        let servo = Responder {
            id: servo.get(),
            ..responder
        };
        if let Some(counts) = counts {
            let answer = servo.reply(Alarms::NONE, &counts.to_be_bytes());
            // There is room for all joints.
            let _ = answers.extend_from_slice(&answer);
        }
    }
    answers
}
