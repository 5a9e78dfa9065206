//! [`Protocol`] of the Morpheus firmware.

use super::codes::command::{CYCLE, PING, READ, RESET, START, SYNC_WR, WRITE};
use super::codes::register;
use super::frame::{
    BROADCAST, FRAME_MAX, Frame, HEADER, LENGTH_HEARD_MAX, LENGTH_MIN, OVERHEAD, checksum,
};
use super::{MASTER, Morpheus, Request, safe_read};
use crate::protocol::{Extent, Protocol, Reply, word_start};
use crate::{Alarms, ControlMode, DecodeError, Firmware, Instruction, JOINTS, Pwm, Query, ServoId};
use core::ops::RangeInclusive;
use heapless::Vec;

/// Addresses of a master: above those that a servo may mistake for a register, and
/// not the broadcast.
const MASTERS: RangeInclusive<u8> = 0x20..=0xFE;

/// Bytes of all replies to CYCLE.
const POSITIONS_BYTES: u16 = ((OVERHEAD + 2) * JOINTS) as u16;
/// Payload of a servo that rejects a request.
const NOK: u8 = 0x08;

/// A ping is answered within 87 µs; the rest is reserve.
pub(super) const LATENCY_US: u32 = 340;
/// START is answered 4.74 ms times the id later: enough for the first few.
const START_LATENCY_US: u32 = 20_000;

/// Registers of two bytes: bit n is set if one begins at address n.
const WORDS: u64 = 1 << register::POSITION | 1 << register::TEMPERATURE | 1 << register::PWM;

/// The READ that fetches these registers without harm, if one does.
fn safe_read(address: u16, count: u16) -> Option<safe_read::Plan> {
    let [address, count] = [address, count].map(u8::try_from);
    safe_read::plan(address.ok()?, count.ok()?).ok()
}

impl Protocol for Morpheus {
    type Frame<'a> = Frame<'a>;

    const FIRMWARE: Firmware = Firmware::Morpheus;
    const HEADER: &'static [u8] = &[HEADER];
    const DESTINATION: usize = 2;
    const READ_BYTES: usize = 8;
    const OVERHEAD: usize = OVERHEAD;
    const FRAME_MAX: usize = FRAME_MAX;
    const PONG_BYTES: u16 = OVERHEAD as u16 + 1;
    /// A position.
    const TICK_REPLY_MAX: usize = OVERHEAD + 2;
    const BROADCAST: u8 = BROADCAST;
    const MASTER: Option<u8> = Some(MASTER);
    const MEMORY_BYTES: u16 = register::END as u16;
    const TEMPERATURE: (u16, u16) = (0x0E, 2);
    const RESET_MARK: Option<u16> = None;
    const UNREADABLE: Option<u16> = Some(register::POSITION as u16);
    const REFUSAL: &'static [u8] = &[NOK];

    /// Finds packets of more than [`FRAME_MAX`] bytes too: a servo accepts LEN up to 200,
    /// and such a packet must be detected to be refused.
    fn extent(bytes: &[u8]) -> Extent {
        match *bytes {
            [] | [HEADER] => Extent::Incomplete,
            [HEADER, length @ LENGTH_MIN..=LENGTH_HEARD_MAX, ..] => {
                Extent::Whole(usize::from(length) + 3)
            }
            [HEADER, ..] => Extent::BadLength,
            _ => Extent::NoHeader,
        }
    }

    fn frame(packet: &[u8]) -> Option<Frame<'_>> {
        let &[HEADER, length, destination, source, ref data @ .., _] = packet else {
            return None;
        };
        (usize::from(length) == data.len() + 2).then_some(Frame {
            destination,
            source,
            data,
        })
    }

    fn is_intact(packet: &[u8]) -> bool {
        matches!(packet, [_, body @ .., sum] if checksum(body) == *sum)
    }

    fn addresses(frame: &Frame) -> (u8, u8) {
        (frame.destination, frame.source)
    }

    fn is_master(source: u8) -> bool {
        MASTERS.contains(&source)
    }

    fn instruction<'a>(frame: &Self::Frame<'a>) -> Result<Instruction<'a>, DecodeError> {
        Ok(match *frame.data {
            [PING] => Instruction::Ping,
            [READ, address, count] => Instruction::Read {
                address: address.into(),
                count: count.into(),
            },
            [WRITE, address, ref data @ ..] if !data.is_empty() => Instruction::Write {
                address: address.into(),
                data,
            },
            [START] => Instruction::Start,
            [CYCLE] => Instruction::Cycle,
            [RESET] => Instruction::FactoryReset,
            [SYNC_WR, address, count, ref blocks @ ..]
                if blocks.len().is_multiple_of(usize::from(count) + 1) =>
            {
                Instruction::SyncWrite {
                    address: address.into(),
                    count: count.into(),
                    blocks,
                }
            }
            [] | [PING | READ | WRITE | START | CYCLE | RESET | SYNC_WR, ..] => {
                return Err(DecodeError::Length);
            }
            [code, ..] => return Err(DecodeError::Unknown(code)),
        })
    }

    fn reply<'a>(frame: &Self::Frame<'a>) -> Option<Reply<'a>> {
        Some(Reply {
            id: frame.source,
            alarms: Alarms::NONE,
            data: frame.data,
        })
    }

    fn encode_reply<const N: usize>(reply: &Reply, to: u8) -> Option<Vec<u8, N>> {
        let frame = Frame {
            destination: to,
            source: ServoId::new(reply.id)?.get(),
            data: reply.data,
        };
        frame.encode()
    }

    fn expected(instruction: Result<Instruction, DecodeError>, is_broadcast: bool) -> (u16, u32) {
        let data = match (instruction, is_broadcast) {
            (Ok(Instruction::Start), true) => {
                return (Self::PONG_BYTES, START_LATENCY_US);
            }
            (Ok(Instruction::Cycle), true) => return (POSITIONS_BYTES, LATENCY_US),
            (_, true) => return (0, 0),
            (Ok(Instruction::Read { count, .. }), false) => count,
            // OK or NOK.
            (_, false) => 1,
        };
        // More bytes than this no servo has.
        (data.saturating_add(OVERHEAD as u16).min(255), LATENCY_US)
    }

    fn ping_query(servo: ServoId) -> Query {
        Query {
            packet: Request::Ping(servo).encode(),
            id: servo.get(),
            reply_bytes: Self::PONG_BYTES,
        }
    }

    fn is_pong(data: &[u8]) -> bool {
        data == [PING]
    }

    /// The reply to CYCLE: high byte first.
    fn position(data: &[u8]) -> Option<u16> {
        let counts = u16::from_be_bytes(data.try_into().ok()?);
        (counts <= 1023).then_some(counts)
    }

    fn read_query<const N: usize>(id: u8, address: u16, count: u16) -> Option<Query<N>> {
        let plan = safe_read(address, count)?;
        Some(Query {
            packet: Vec::from_slice(&plan.request(ServoId::new(id)?)).ok()?,
            id,
            reply_bytes: (OVERHEAD + plan.range().len()) as u16,
        })
    }

    /// None: a Morpheus servo has no settings that the bridge changes.
    fn write_query<const N: usize>(_id: u8, _address: u16, _data: &[u8]) -> Option<Query<N>> {
        None
    }

    fn read_reply(address: u16, count: u16, data: &[u8]) -> Option<&[u8]> {
        safe_read(address, count)?.extract(data)
    }

    fn lead_bytes(address: u16) -> u16 {
        safe_read(address, 1).map_or(0, |plan| address.saturating_sub(plan.range().start.into()))
    }

    fn register_start(address: u16) -> u16 {
        word_start(WORDS, address)
    }

    /// The low byte of the PWM.
    fn off_query(servo: ServoId, _mode: ControlMode) -> Query {
        let plan = safe_read::PWM_LOW;
        Query {
            packet: plan.request(servo),
            id: servo.get(),
            reply_bytes: (OVERHEAD + plan.range().len()) as u16,
        }
    }

    fn decode_off(data: &[u8]) -> Option<bool> {
        let [off, _] = Pwm::OFF.counts().to_le_bytes();
        let &[low] = safe_read::PWM_LOW.extract(data)? else {
            return None;
        };
        Some(low == off)
    }
}
