//! [`Protocol`] of Dynamixel Protocol 1.0 on stock AX-12A servos.

use super::frame::{BROADCAST, FRAME_MAX, Frame, HEADER, OVERHEAD, checksum};
use super::{Protocol1, Status, register};
use crate::protocol::{Extent, Protocol, Reply, word_start};
use crate::{ControlMode, DecodeError, Firmware, Instruction, Packet, Query, ServoId};
use heapless::Vec;

/// Registers from the angle limits through the moving speed.
const OFF_BYTES: u16 = register::MOVING_SPEED + 2 - register::ANGLE_LIMITS;
/// Moving speed without its direction, bit 10.
const MAGNITUDE: u16 = (1 << 10) - 1;

/// Longest return delay of a stock servo, 254 times 2 µs, and 300 µs of processing time.
pub(super) const LATENCY_US: u32 = RETURN_DELAY_MAX_US as u32 + 300;
pub(super) const RETURN_DELAY_MAX_US: u64 = 508;

impl Protocol for Protocol1 {
    type Frame<'a> = Frame<'a>;

    const FIRMWARE: Firmware = Firmware::Stock;
    const HEADER: &'static [u8] = &[HEADER; 2];
    const DESTINATION: usize = 2;
    const READ_BYTES: usize = 8;
    const OVERHEAD: usize = OVERHEAD;
    const FRAME_MAX: usize = FRAME_MAX;
    const PONG_BYTES: u16 = OVERHEAD as u16;
    const TICK_REPLY_MAX: usize = FRAME_MAX;
    const BROADCAST: u8 = BROADCAST;
    const MASTER: Option<u8> = None;
    const MEMORY_BYTES: u16 = 50;
    const TEMPERATURE: (u16, u16) = (register::PRESENT_TEMPERATURE, 1);
    const RESET_MARK: Option<u16> = Some(register::TORQUE_ENABLE);
    const UNREADABLE: Option<u16> = None;
    const REFUSAL: &'static [u8] = &[];

    fn extent(bytes: &[u8]) -> Extent {
        match *bytes {
            // Of more headers than two the last two count.
            [HEADER, HEADER, HEADER, ..] => Extent::NoHeader,
            [HEADER, HEADER, _, length @ 2..=255, ..] => Extent::Whole(usize::from(length) + 4),
            [HEADER, HEADER, _, _, ..] => Extent::BadLength,
            [] | [HEADER] | [HEADER, HEADER] | [HEADER, HEADER, _] => Extent::Incomplete,
            _ => Extent::NoHeader,
        }
    }

    fn frame(packet: &[u8]) -> Option<Frame<'_>> {
        let &[HEADER, HEADER, id, length, code, ref parameters @ .., _] = packet else {
            return None;
        };
        (usize::from(length) == parameters.len() + 2).then_some(Frame {
            id,
            code,
            parameters,
        })
    }

    fn is_intact(packet: &[u8]) -> bool {
        matches!(packet, [_, _, body @ .., sum] if checksum(body) == *sum)
    }

    fn addresses(frame: &Frame) -> (u8, u8) {
        (frame.id, frame.id)
    }

    fn is_master(_source: u8) -> bool {
        true
    }

    fn instruction<'a>(frame: &Self::Frame<'a>) -> Result<Instruction<'a>, DecodeError> {
        Instruction::decode(frame)
    }

    fn reply<'a>(frame: &Self::Frame<'a>) -> Option<Reply<'a>> {
        Status::decode(frame).map(|status| Reply {
            id: status.id,
            alarms: status.alarms,
            data: status.parameters,
        })
    }

    fn encode_reply<const N: usize>(reply: &Reply, _to: u8) -> Option<Vec<u8, N>> {
        let status = Status {
            id: reply.id,
            alarms: reply.alarms,
            parameters: reply.data,
        };
        (reply.id < BROADCAST).then(|| status.encode()).flatten()
    }

    fn expected(instruction: Result<Instruction, DecodeError>, is_broadcast: bool) -> (u16, u32) {
        let data = match (instruction, is_broadcast) {
            (Ok(Instruction::Ping), true) => 0,
            (_, true) => return (0, 0),
            (Ok(Instruction::Read { count, .. }), false) => count,
            (_, false) => 0,
        };
        // More bytes than this no servo has.
        (data.saturating_add(OVERHEAD as u16).min(255), LATENCY_US)
    }

    fn ping_query(servo: ServoId) -> Query {
        query(servo.get(), &Instruction::Ping, 0).unwrap_or_default()
    }

    /// Every status packet is a pong, whatever its data.
    fn is_pong(_data: &[u8]) -> bool {
        true
    }

    fn position(data: &[u8]) -> Option<u16> {
        let counts = u16::from_le_bytes(data.try_into().ok()?);
        (counts <= 1023).then_some(counts)
    }

    fn read_query<const N: usize>(id: u8, address: u16, count: u16) -> Option<Query<N>> {
        let is_known = address.checked_add(count)? <= Self::MEMORY_BYTES;
        let query = || query(id, &Instruction::Read { address, count }, count);
        is_known.then(query).flatten()
    }

    fn write_query<const N: usize>(id: u8, address: u16, data: &[u8]) -> Option<Query<N>> {
        query(id, &Instruction::Write { address, data }, 0)
    }

    fn read_reply(_address: u16, count: u16, data: &[u8]) -> Option<&[u8]> {
        (data.len() == usize::from(count)).then_some(data)
    }

    fn lead_bytes(_address: u16) -> u16 {
        0
    }

    fn register_start(address: u16) -> u16 {
        word_start(register::WORDS, address)
    }

    /// Reads angle limits through moving speed: torque enable alone would not distinguish a
    /// servo that holds still from one that is on its way, and a moving speed of 0
    /// is standstill in wheel mode, but the highest speed in joint mode.
    fn off_query(servo: ServoId, _mode: ControlMode) -> Query {
        Self::read_query(servo.get(), register::ANGLE_LIMITS, OFF_BYTES).unwrap_or_default()
    }

    fn decode_off(data: &[u8]) -> Option<bool> {
        let data = Self::read_reply(register::ANGLE_LIMITS, OFF_BYTES, data)?;
        let from = |address: u16| data.get(usize::from(address - register::ANGLE_LIMITS)..);
        let is_wheel = from(register::ANGLE_LIMITS)?.starts_with(&[0; 4]);
        let speed = u16::from_le_bytes(*from(register::MOVING_SPEED)?.first_chunk()?);
        match from(register::TORQUE_ENABLE)?.first()? {
            0 => Some(true),
            1 => Some(is_wheel && speed & MAGNITUDE == 0),
            _ => None,
        }
    }
}

fn query<const N: usize>(id: u8, instruction: &Instruction, data: u16) -> Option<Query<N>> {
    Some(Query {
        packet: instruction.encode(id)?,
        id,
        reply_bytes: data.saturating_add(OVERHEAD as u16).min(255),
    })
}

/// Torque enable 0 to all stock servos: they release the shaft. No reply.
pub(crate) fn torque_off() -> Packet {
    let off = Instruction::Write {
        address: register::TORQUE_ENABLE,
        data: &[0],
    };
    // Eight bytes, for which there is room.
    off.encode(BROADCAST).unwrap_or_default()
}
