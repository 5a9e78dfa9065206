//! Conversion of all events but records to messages of the log, and back.
//!
//! | event                    | message      |
//! |--------------------------|--------------|
//! | sent by the host         | `Command`    |
//! | a record                 | `Telemetry`, see [`telemetry`](super::telemetry) |
//! | settings                 | `Parameters` |
//! | other messages of the board, lost and damaged frames, disconnection | `Event` |

use armbridge_client::enum_names;
use armbridge_client::event::{Direction, EventKind};
use armbridge_link::experiment::{Conclusion, ExperimentEnd};
use armbridge_link::frame::FrameError;
use armbridge_link::message::{Command, ToBoard, ToHost};

use super::payload_codec::{exact, value};
use super::{event_text, proto, telemetry};

/// Message for a message of the host.
pub(super) fn command(host_ns: u64, sequence: u16, content: &ToBoard) -> proto::Command {
    let mut message = proto::Command {
        host_ns,
        sequence: sequence.into(),
        kind: match content {
            ToBoard::Hello(_) => "hello",
            ToBoard::Heartbeat => "heartbeat",
            ToBoard::Stop => "stop",
            ToBoard::Goodbye => "goodbye",
            ToBoard::Command(command) => enum_names::command(command),
        }
        .into(),
        exact: Some(exact(content)),
        ..proto::Command::default()
    };
    match content {
        ToBoard::Command(Command::Torque(torque_nm)) => message.torque_nm = torque_nm.to_vec(),
        ToBoard::Command(Command::Regulate(angle_rad)) => {
            message.reference_rad = angle_rad.to_vec();
        }
        ToBoard::Command(Command::Stream {
            at_us,
            angle_rad,
            speed_rad_s,
        }) => {
            message.time_s = Some(telemetry::seconds(*at_us));
            message.reference_rad = angle_rad.to_vec();
            message.reference_speed_rad_s =
                speed_rad_s.map(|speed| speed.to_vec()).unwrap_or_default();
        }
        ToBoard::Hello(_)
        | ToBoard::Heartbeat
        | ToBoard::Stop
        | ToBoard::Goodbye
        | ToBoard::Command(
            Command::Idle
            | Command::Park
            | Command::Arm { .. }
            | Command::Follow(_)
            | Command::Experiment(_)
            | Command::Float
            | Command::Prepare
            | Command::Release
            | Command::ClearFault
            | Command::Configure(_)
            | Command::Limit(_)
            | Command::Save,
        ) => {}
    }
    message
}

/// The host's message, from a message of the log.
pub(super) fn host_message(message: &proto::Command, is_same_schema: bool) -> Option<EventKind> {
    let content = value(message.exact.as_ref()?, is_same_schema)?;
    Some(EventKind::Sent(message.sequence.try_into().ok()?, content))
}

/// Message for a message of the board, other than records and settings.
pub(super) fn board_event(host_ns: u64, sequence: u16, content: &ToHost) -> proto::Event {
    let (kind, severity, text) = event_text::describe(content);
    let mut message = proto::Event {
        host_ns,
        severity: severity.into(),
        kind: kind.into(),
        text,
        sequence: Some(sequence.into()),
        exact: Some(exact(content)),
        ..proto::Event::default()
    };
    match *content {
        ToHost::Ack {
            sequence, moment, ..
        } => {
            message.of_sequence = Some(sequence.into());
            message.tick = moment.map(|moment| moment.tick);
            message.time_s = moment.map(|moment| telemetry::seconds(moment.at_us));
        }
        ToHost::Departs { sequence, moment } => {
            message.of_sequence = Some(sequence.into());
            message.tick = Some(moment.tick);
            message.time_s = Some(telemetry::seconds(moment.at_us));
        }
        ToHost::Began(moment) => {
            message.tick = Some(moment.tick);
            message.time_s = Some(telemetry::seconds(moment.at_us));
        }
        ToHost::Absent { joint, .. }
        | ToHost::Unprepared { joint }
        | ToHost::Temperature { joint, .. } => message.joint = Some(u32::from(joint) + 1),
        ToHost::Tripped(trip) => {
            message.joint = trip.joint.map(|joint| u32::from(joint) + 1);
            message.tick = Some(trip.tick);
            message.time_s = Some(telemetry::seconds(trip.at_us));
            message.value = Some(trip.value);
            message.limit = Some(trip.limit);
        }
        ToHost::Concluded(Conclusion { tick, end }) => {
            message.tick = Some(tick);
            if let ExperimentEnd::Angle {
                joint,
                value_rad: value,
            }
            | ExperimentEnd::Speed {
                joint,
                value_rad_s: value,
            } = end
            {
                message.joint = Some(u32::from(joint) + 1);
                message.value = Some(value);
            }
        }
        ToHost::Hello(_)
        | ToHost::Settings(_)
        | ToHost::Found { .. }
        | ToHost::Mixed(_)
        | ToHost::Passthrough
        | ToHost::Port(_)
        | ToHost::Board(_)
        | ToHost::Off(_)
        | ToHost::Record(_) => {}
    }
    message
}

/// Message for an event of the link itself; `None` for a message of host or
/// board.
pub(super) fn link_event(host_ns: u64, kind: &EventKind) -> Option<proto::Event> {
    let event = proto::Event {
        host_ns,
        severity: proto::Severity::Warning.into(),
        ..proto::Event::default()
    };
    match *kind {
        EventKind::Sent(..) | EventKind::Received(..) => None,
        EventKind::Lost(direction, count) => Some(proto::Event {
            kind: "lost".into(),
            text: event_text::lost(direction, count),
            is_towards_board: direction == Direction::ToBoard,
            count: count.into(),
            ..event
        }),
        EventKind::Damaged(direction, error) => {
            let (garbled, version, text) = event_text::garbled(direction, error);
            Some(proto::Event {
                kind: "garbled".into(),
                text,
                is_towards_board: direction == Direction::ToBoard,
                garbled,
                version,
                ..event
            })
        }
        EventKind::Disconnected => Some(proto::Event {
            kind: "parted".into(),
            text: "the link broke".into(),
            ..event
        }),
    }
}

/// The event, from its message; `Ok(None)` for an event of the recorder itself.
///
/// # Errors
/// If it cannot be decoded.
pub(super) fn event(
    message: &proto::Event,
    is_same_schema: bool,
) -> Result<Option<EventKind>, Unreadable> {
    let direction = if message.is_towards_board {
        Direction::ToBoard
    } else {
        Direction::ToHost
    };
    match (message.kind.as_str(), &message.exact) {
        (_, Some(exact)) => {
            let sequence = message.sequence.and_then(|number| number.try_into().ok());
            let content = value(exact, is_same_schema);
            let (Some(sequence), Some(content)) = (sequence, content) else {
                return Err(Unreadable);
            };
            Ok(Some(EventKind::Received(sequence, content)))
        }
        ("lost", None) => {
            let count = message.count.try_into().map_err(|_| Unreadable)?;
            Ok(Some(EventKind::Lost(direction, count)))
        }
        ("garbled", None) => {
            let error = match message.garbled {
                1 => FrameError::Damaged,
                2 => FrameError::Version(message.version.try_into().map_err(|_| Unreadable)?),
                3 => FrameError::Direction,
                4 => FrameError::Schema,
                _ => return Err(Unreadable),
            };
            Ok(Some(EventKind::Damaged(direction, error)))
        }
        ("parted", None) => Ok(Some(EventKind::Disconnected)),
        // Of the recorder, or of a later version.
        (_, None) => Ok(None),
    }
}

/// A message of another schema, or a damaged one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Unreadable;

/// The board's settings, from their message.
pub(super) fn settings(message: &proto::Parameters, is_same_schema: bool) -> Option<EventKind> {
    let settings = value(message.exact.as_ref()?, is_same_schema)?;
    let sequence = message.sequence.try_into().ok()?;
    Some(EventKind::Received(sequence, ToHost::Settings(settings)))
}
