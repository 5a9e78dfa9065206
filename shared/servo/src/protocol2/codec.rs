//! [`Protocol`] of Dynamixel Protocol 2.0 on servos of the X series.

use super::crc::checksum;
use super::fast_status::{FastStatus, Part, PartError};
use super::frame::{
    BROADCAST, Frame, HEAD, HEADER, ID_MAX, MARK, OVERHEAD, Protocol2, STATUS, is_fast, unstuff,
};
use super::instruction::{Instruction as Instruction2, InstructionError};
use super::status::{Status, StatusError};
use super::{model, register};
use crate::protocol::{Extent, Protocol, Reply};
use crate::{
    Alarms, ControlMode, DecodeError, Firmware, Instruction, JOINTS, Packet, Query, ServoId,
};
use heapless::Vec;

/// Bytes of a status packet beside its data: with the error byte.
const STATUS_OVERHEAD: usize = OVERHEAD + 1;
/// Largest present current of a motor that is off, in counts: noise of its measurement, which no
/// document specifies, so an assumption. It is at most 2.5 % of the stall current of any model
/// ([`model`]), which moves no joint.
const OFF_CURRENT_COUNTS: u16 = 20;
/// Bytes of a present position.
pub(super) const POSITION_BYTES: u16 = 4;

/// Longest return delay, 254 times 2 µs, and 300 µs of processing time, of which the e-Manual
/// says nothing.
pub(super) const LATENCY_US: u32 = 508 + 300;

impl Protocol for Protocol2 {
    type Frame<'a> = Frame<'a>;

    const FIRMWARE: Firmware = Firmware::XSeries;
    /// Two of its four: the others are not the same.
    const HEADER: &'static [u8] = &[0xFF; 2];
    const DESTINATION: usize = 4;
    const READ_BYTES: usize = 14;
    const OVERHEAD: usize = STATUS_OVERHEAD;
    const FRAME_MAX: usize = HEAD + u16::MAX as usize;
    const PONG_BYTES: u16 = STATUS_OVERHEAD as u16 + 3;
    const TICK_REPLY_MAX: usize = positions_bytes(JOINTS);
    const BROADCAST: u8 = BROADCAST;
    const MASTER: Option<u8> = None;
    const MEMORY_BYTES: u16 = register::END;
    const TEMPERATURE: (u16, u16) = (register::PRESENT_TEMPERATURE, 1);
    /// That of the watchdog.
    const RESET_MARK: Option<u16> = Some(register::BUS_WATCHDOG);
    const UNREADABLE: Option<u16> = None;
    const REFUSAL: &'static [u8] = &[];

    fn extent(bytes: &[u8]) -> Extent {
        match *bytes {
            [0xFF, 0xFF, 0xFD, 0, _, low, high, ..] => {
                match usize::from(u16::from_le_bytes([low, high])) {
                    ..3 => Extent::BadLength,
                    length => Extent::Whole(HEAD + length),
                }
            }
            _ if bytes.len() < HEADER.len() && HEADER.starts_with(bytes) => Extent::Incomplete,
            _ if bytes.starts_with(&HEADER) => Extent::Incomplete,
            _ => Extent::NoHeader,
        }
    }

    fn frame(packet: &[u8]) -> Option<Frame<'_>> {
        let &[_, _, _, _, id, low, high, code, ref parameters @ .., _, _] = packet else {
            return None;
        };
        let length = usize::from(u16::from_le_bytes([low, high]));
        (length == parameters.len() + 3).then_some(Frame {
            id,
            code,
            parameters,
        })
    }

    fn is_intact(packet: &[u8]) -> bool {
        matches!(packet, [body @ .., low, high] if checksum(body) == u16::from_le_bytes([*low, *high]))
    }

    fn is_stuffed(packet: &[u8]) -> bool {
        let body = packet.get(HEAD..).unwrap_or_default();
        !is_fast(packet) && body.windows(MARK.len()).any(|three| *three == MARK)
    }

    fn unstuff<const N: usize>(packet: &mut Vec<u8, N>) -> bool {
        unstuff(packet)
    }

    fn addresses(frame: &Frame) -> (u8, u8) {
        (frame.id, frame.id)
    }

    fn is_master(_source: u8) -> bool {
        true
    }

    fn instruction<'a>(frame: &Self::Frame<'a>) -> Result<Instruction<'a>, DecodeError> {
        Ok(match Instruction2::decode(frame) {
            Ok(Instruction2::Ping) => Instruction::Ping,
            Ok(Instruction2::Read { address, count }) => Instruction::Read { address, count },
            Ok(Instruction2::Write { address, data }) => Instruction::Write { address, data },
            Ok(Instruction2::RegWrite { address, data }) => Instruction::RegWrite { address, data },
            Ok(Instruction2::Action) => Instruction::Action,
            Ok(Instruction2::FactoryReset(_)) => Instruction::FactoryReset,
            Ok(Instruction2::SyncWrite {
                address,
                count,
                blocks,
            }) => Instruction::SyncWrite {
                address,
                count,
                blocks,
            },
            Ok(Instruction2::SyncRead { count, ids, .. }) => Instruction::SyncRead { count, ids },
            Ok(Instruction2::FastSyncRead { count, ids, .. }) => {
                Instruction::FastSyncRead { count, ids }
            }
            Ok(
                Instruction2::Reboot
                | Instruction2::ClearTurns
                | Instruction2::BulkRead(_)
                | Instruction2::FastBulkRead(_)
                | Instruction2::BulkWrite(_),
            ) => return Err(DecodeError::Unknown(frame.code)),
            Err(InstructionError::Unknown(code)) => return Err(DecodeError::Unknown(code)),
            Err(InstructionError::Length) => return Err(DecodeError::Length),
        })
    }

    /// The data of a fast status packet are all its parts.
    fn reply<'a>(frame: &Self::Frame<'a>) -> Option<Reply<'a>> {
        if (frame.id, frame.code) == (BROADCAST, STATUS) {
            return Some(Reply {
                id: BROADCAST,
                alarms: Alarms::NONE,
                data: frame.parameters,
            });
        }
        Status::decode(frame).map(|status| Reply {
            id: status.id,
            alarms: alarms(status.is_alert, status.error),
            data: status.parameters,
        })
    }

    fn encode_reply<const N: usize>(reply: &Reply, _to: u8) -> Option<Vec<u8, N>> {
        let status = Status {
            id: reply.id,
            is_alert: reply.alarms.contains(Alarms::HARDWARE),
            error: error(reply.alarms),
            parameters: reply.data,
        };
        (reply.id <= ID_MAX).then(|| status.encode()).flatten()
    }

    fn expected(instruction: Result<Instruction, DecodeError>, is_broadcast: bool) -> (u16, u32) {
        let overhead = STATUS_OVERHEAD as u16;
        let bytes = match (instruction, is_broadcast) {
            (Ok(Instruction::Ping), _) => Self::PONG_BYTES,
            (Ok(Instruction::SyncRead { count, ids }), _) => {
                (ids.len() as u16).saturating_mul(count.saturating_add(overhead))
            }
            (Ok(Instruction::FastSyncRead { count, ids }), _) => {
                FastStatus::packet_bytes(ids.len(), count.into()) as u16
            }
            (_, true) => return (0, 0),
            (Ok(Instruction::Read { count, .. }), false) => count.saturating_add(overhead),
            (_, false) => overhead,
        };
        (bytes, LATENCY_US)
    }

    fn ping_query(servo: ServoId) -> Query {
        query(servo.get(), &Instruction2::Ping, 3).unwrap_or_default()
    }

    /// Model number and version.
    fn is_pong(data: &[u8]) -> bool {
        data.len() == 3
    }

    /// Within a turn. The servo counts turns, from one that depends on its homing offset, its modes
    /// and its past; a joint's limits are less than half a turn from its zero.
    fn position(data: &[u8]) -> Option<u16> {
        let counts = i32::from_le_bytes(data.try_into().ok()?);
        Some(counts.rem_euclid(i32::from(model::TURN)) as u16)
    }

    fn read_query<const N: usize>(id: u8, address: u16, count: u16) -> Option<Query<N>> {
        let is_known = address.checked_add(count)? <= Self::MEMORY_BYTES;
        let query = || query(id, &Instruction2::Read { address, count }, count);
        is_known.then(query).flatten()
    }

    fn write_query<const N: usize>(id: u8, address: u16, data: &[u8]) -> Option<Query<N>> {
        query(id, &Instruction2::Write { address, data }, 0)
    }

    fn read_reply(_address: u16, count: u16, data: &[u8]) -> Option<&[u8]> {
        (data.len() == usize::from(count)).then_some(data)
    }

    fn lead_bytes(_address: u16) -> u16 {
        0
    }

    fn register_start(address: u16) -> u16 {
        register::start(address)
    }

    /// Reads the PWM on the motor. In every tick with motors off the bridge disables torque, or
    /// has goal PWM or goal current 0, so that this shows what has become of it. A current of 0
    /// takes a PWM while the motor turns, so that in current control mode the present current, which is
    /// the next register, counts as well.
    fn off_query(servo: ServoId, mode: ControlMode) -> Query {
        let bytes = match mode {
            ControlMode::Pwm => 2,
            ControlMode::Current => 4,
        };
        Self::read_query(servo.get(), register::PRESENT_PWM, bytes).unwrap_or_default()
    }

    fn decode_off(data: &[u8]) -> Option<bool> {
        let (pwm, current) = data.split_first_chunk::<2>()?;
        let has_little_current = match current {
            [] => false,
            [low, high] => {
                let counts = i16::from_le_bytes([*low, *high]);
                counts.unsigned_abs() <= OFF_CURRENT_COUNTS
            }
            _ => return None,
        };
        Some(*pwm == [0; 2] || has_little_current)
    }
}

/// Alarms of the error byte: a hardware error by its alert, a refusal by its number.
fn alarms(is_alert: bool, error: Option<StatusError>) -> Alarms {
    let refusal = match error {
        None => Alarms::NONE,
        Some(StatusError::Crc) => Alarms::CHECKSUM,
        Some(StatusError::DataRange | StatusError::DataLength | StatusError::DataLimit) => {
            Alarms::RANGE
        }
        Some(
            StatusError::Failed
            | StatusError::Instruction
            | StatusError::Access
            | StatusError::Unknown(_),
        ) => Alarms::INSTRUCTION,
    };
    if is_alert {
        refusal.or(Alarms::HARDWARE)
    } else {
        refusal
    }
}

/// The error of these alarms, the most specific first.
fn error(alarms: Alarms) -> Option<StatusError> {
    let errors = [
        (Alarms::CHECKSUM, StatusError::Crc),
        (Alarms::RANGE, StatusError::DataRange),
        (Alarms::INSTRUCTION, StatusError::Instruction),
    ];
    let found = errors.iter().find(|(alarm, _)| alarms.contains(*alarm));
    found.map(|(_, error)| *error)
}

impl Part<'_> {
    /// Alarms of the part's servo.
    pub(crate) fn alarms(&self) -> Alarms {
        alarms(self.is_alert, self.error)
    }
}

/// Parts of the reply to a tick's `FAST_SYNC_READ`, as far as it has come.
pub(crate) fn position_parts(packet: &[u8]) -> impl Iterator<Item = Result<Part<'_>, PartError>> {
    FastStatus::new(packet, POSITION_BYTES.into())
        .into_iter()
        .flatten()
}

/// Whether so many bytes of the reply of `servos` to a tick's `FAST_SYNC_READ` end with the part of
/// a servo: those after it are silent.
pub(crate) fn ends_with_part(bytes: usize, servos: usize) -> bool {
    (1..servos).any(|servos| bytes == positions_bytes(servos))
}

/// Bytes of the reply of this number of servos to a tick's `FAST_SYNC_READ`.
pub(crate) const fn positions_bytes(servos: usize) -> usize {
    FastStatus::packet_bytes(servos, POSITION_BYTES as usize)
}

fn query<const N: usize>(id: u8, instruction: &Instruction2, data: u16) -> Option<Query<N>> {
    Some(Query {
        packet: instruction.encode(id)?,
        id,
        reply_bytes: data.saturating_add(STATUS_OVERHEAD as u16),
    })
}

/// Torque enable 0 to all servos of the X series: they release the shaft. No reply.
pub(crate) fn torque_off() -> Packet {
    let off = Instruction2::Write {
        address: register::TORQUE_ENABLE,
        data: &[0],
    };
    // Thirteen bytes, for which there is room.
    off.encode(BROADCAST).unwrap_or_default()
}
