//! Messages of a log as events, states and pushes.

use armbridge_client::event::{Event, EventKind};
use armbridge_link::message::ToHost;
use mcap::records::Record;
use prost::Message as _;

use super::{Item, Reader};
use crate::limits::{MESSAGE_BYTES, PUSHES};
use crate::mcap_records::parse;
use crate::topics::Topic;
use crate::{event_messages, proto, simulation, telemetry};

impl Reader {
    pub(super) fn item_of_record(&mut self, opcode: u8, body: &[u8]) -> Option<Item> {
        match parse(opcode, body) {
            Some(Record::Message { header, data }) => {
                let topic = *self.channels.get(&header.channel_id)?;
                let item = if data.len() > MESSAGE_BYTES {
                    Err(event_messages::Unreadable)
                } else {
                    self.decode_message(topic, &data)
                };
                item.unwrap_or_else(|_| {
                    self.unreadable += 1;
                    None
                })
            }
            Some(Record::Channel(_)) => {
                // A simulation's topic, or another program's.
                let _ = self.register_channel(body);
                None
            }
            _ => None,
        }
    }

    fn decode_message(
        &mut self,
        topic: Topic,
        bytes: &[u8],
    ) -> Result<Option<Item>, event_messages::Unreadable> {
        let is_same_schema = self.is_same_schema;
        let unreadable = |_| event_messages::Unreadable;
        let (host_ns, kind) = match topic {
            Topic::Telemetry => {
                let message = proto::Telemetry::decode(bytes).map_err(unreadable)?;
                let (sequence, record) =
                    telemetry::record(&message).ok_or(event_messages::Unreadable)?;
                self.last_tick = Some(record.tick);
                (
                    message.host_ns,
                    EventKind::Received(sequence, ToHost::Record(record)),
                )
            }
            Topic::Commands => {
                let message = proto::Command::decode(bytes).map_err(unreadable)?;
                let kind = event_messages::host_message(&message, is_same_schema)
                    .ok_or(event_messages::Unreadable)?;
                (message.host_ns, kind)
            }
            Topic::Events => {
                let message = proto::Event::decode(bytes).map_err(unreadable)?;
                match event_messages::event(&message, is_same_schema)? {
                    Some(kind) => (message.host_ns, kind),
                    None => return Ok(None),
                }
            }
            Topic::Parameters => {
                let message = proto::Parameters::decode(bytes).map_err(unreadable)?;
                let kind = event_messages::settings(&message, is_same_schema)
                    .ok_or(event_messages::Unreadable)?;
                (message.host_ns, kind)
            }
            Topic::SimulationState if self.reads_states => {
                let message = proto::SimulationState::decode(bytes).map_err(unreadable)?;
                let state = simulation::state(&message).ok_or(event_messages::Unreadable)?;
                return Ok(Some(Item::State(state.0, state.1)));
            }
            Topic::SimulationPush => {
                let message = proto::SimulationPush::decode(bytes).map_err(unreadable)?;
                let push = simulation::push(&message).ok_or(event_messages::Unreadable)?;
                if self.pushes.len() < PUSHES {
                    self.pushes.push(push);
                }
                return Ok(None);
            }
            // Left out, and derived from the other messages.
            Topic::SimulationState
            | Topic::Statistics
            | Topic::Log
            | Topic::JointStates
            | Topic::Transforms
            | Topic::Scene => return Ok(None),
        };
        Ok(Some(Item::Event(Event { host_ns, kind })))
    }
}
