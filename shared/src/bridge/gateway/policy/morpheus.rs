//! Packets for Morpheus servos.

use super::{Verdict, is_controlled};
use crate::JOINTS;
use crate::bridge::gateway::job::{Ask, Job, Reading, Target};
use crate::bridge::gateway::voice::{Bytes, Voice};
use crate::servo::morpheus::frame::OVERHEAD;
use crate::servo::morpheus::{BROADCAST, HEADER, Request, ServoId, checksum};
use crate::servo::protocol1::Alarms;
use heapless::Vec;

/// Commands that are not refused (`Serial.h` of the firmware).
mod command {
    pub(super) const PING: u8 = 0x01;
    pub(super) const READ: u8 = 0x02;
    pub(super) const CYCLE: u8 = 0x07;
}

/// Below it, an address may be taken for a register.
const CLIENT_MIN: u8 = 0x20;

pub(super) fn judge(
    controlled: [ServoId; JOINTS],
    samples: [Option<u16>; JOINTS],
    packet: &[u8],
) -> Verdict {
    let [HEADER, body @ .., sum] = packet else {
        return Verdict::SILENT_REFUSAL;
    };
    let &[length, id, client, ref data @ ..] = body else {
        return Verdict::SILENT_REFUSAL;
    };
    if usize::from(length) != data.len() + 2 {
        return Verdict::SILENT_REFUSAL;
    }
    if checksum(body) != *sum {
        return Verdict::Answer(Bytes::new());
    }
    let voice = Voice::Morpheus { id, client };
    let is_client = (CLIENT_MIN..BROADCAST).contains(&client) && !is_controlled(controlled, client);
    match (ServoId::new(id), data) {
        _ if !is_client => Verdict::Refuse(voice.refuses()),
        (Some(servo), [command::PING]) => ping(voice, servo),
        (Some(servo), [command::READ, address, count]) => {
            let position = position(controlled, samples, servo);
            read(voice, Target::Morpheus(servo, position), *address, *count)
        }
        (None, [command::CYCLE]) if id == BROADCAST => {
            Verdict::Answer(cycle(controlled, samples, client))
        }
        _ => Verdict::Refuse(voice.refuses()),
    }
}

fn ping(voice: Voice, servo: ServoId) -> Verdict {
    let packet = Request::Ping(servo).encode();
    let ask = Ask {
        // Shorter than any reading.
        packet: Bytes::from_slice(&packet).unwrap_or_default(),
        id: servo.get(),
        reply_bytes: OVERHEAD as u8 + 1,
    };
    Verdict::Ask(Job::single(voice, ask))
}

fn read(voice: Voice, target: Target, address: u8, count: u8) -> Verdict {
    match Reading::new(target, address, count) {
        None => Verdict::Refuse(voice.refuses()),
        // The position alone.
        Some(reading) if reading.is_complete() => {
            Verdict::Answer(voice.says(Alarms::NONE, reading.data()))
        }
        Some(reading) => Verdict::Ask(Job::read(voice, reading)),
    }
}

fn position(
    controlled: [ServoId; JOINTS],
    samples: [Option<u16>; JOINTS],
    servo: ServoId,
) -> Option<u16> {
    let joint = controlled.iter().position(|id| *id == servo)?;
    *samples.get(joint)?
}

/// What the servos would answer, one after another in the order of their ids.
fn cycle(controlled: [ServoId; JOINTS], samples: [Option<u16>; JOINTS], client: u8) -> Bytes {
    let mut servos: Vec<_, JOINTS> = controlled.into_iter().zip(samples).collect();
    servos.sort_unstable_by_key(|(servo, _)| servo.get());
    let mut answers = Bytes::new();
    for (servo, counts) in &servos {
        let id = servo.get();
        if let Some(counts) = counts {
            let answer = Voice::Morpheus { id, client }.says(Alarms::NONE, &counts.to_be_bytes());
            // There is room for all joints.
            let _ = answers.extend_from_slice(&answer);
        }
    }
    answers
}
