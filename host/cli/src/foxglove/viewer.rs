//! A viewer: its connection, its subscriptions, and what waits for it.
//!
//! Everything of a viewer is bounded. Of messages that it does not fetch the oldest are
//! dropped; a viewer that does not fetch replies either, or shows no life for 3 s, is
//! disconnected.

use std::collections::{HashMap, HashSet, VecDeque};
use std::net::TcpStream;
use std::time::{Duration, Instant};

use armbridge_log::message_encoder;
use armbridge_log::topics::Topic;
use foxglove::websocket::{Parameter, Status};
use foxglove::ws_protocol::client::ClientMessage;
use foxglove::ws_protocol::server::{
    MessageData, ParameterValues, ServiceCallFailure, ServiceCallResponse,
};
use foxglove::ws_protocol::{BinaryMessage, JsonMessage};
use tungstenite::protocol::WebSocketConfig;
use tungstenite::{Bytes, Error, Message, WebSocket};

use super::access::Right;
use super::pending_requests::{Call, Reply, Service, ViewerRequest};

/// Messages that wait for a viewer; more than 2 s of all topics. Then its oldest go.
const BACKLOG: usize = 4_096;
/// Replies that wait for a viewer; with the longest message, this bounds their bytes.
const REPLIES_MAX: usize = 128;
/// Messages taken from a viewer in a poll; more wait at the sender.
const READS_MAX: usize = 32;
/// Parameters whose updates a viewer can subscribe to, and the longest of their names.
const NAMES_MAX: usize = 1_024;
const NAME_MAX: usize = 64;
/// Longest message of a viewer: several times all parameters.
const MESSAGE_MAX: usize = 16 * 1_024;
/// Interval of pings, which a viewer answers without its user.
const PING_INTERVAL: Duration = Duration::from_millis(500);
/// Time without any message, after which a viewer's connection counts as broken.
const SILENCE: Duration = Duration::from_secs(3);

/// Answer to a command of a viewer without the token.
const WATCHES_ONLY: &str = "this viewer may watch, /stop and /disarm: open the address with the \
                            token, which `armbridge foxglove` has printed, to command";

/// Limits of a connection's buffers.
pub(super) fn limits() -> WebSocketConfig {
    WebSocketConfig::default()
        .read_buffer_size(4 * 1_024)
        .write_buffer_size(32 * 1_024)
        .max_write_buffer_size(512 * 1_024)
        .max_message_size(Some(MESSAGE_MAX))
        .max_frame_size(Some(MESSAGE_MAX))
}

/// Number of a viewer; never used again.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ViewerId(pub(super) u64);

/// A viewer.
#[derive(Debug)]
pub(super) struct Viewer {
    pub(super) id: ViewerId,
    pub(super) right: Right,
    socket: WebSocket<TcpStream>,
    /// Its number for each topic that it has subscribed to.
    subscriptions: HashMap<u64, u32>,
    /// Parameters whose updates it has subscribed to.
    parameters: HashSet<String>,
    replies: VecDeque<Message>,
    messages: VecDeque<Message>,
    heard: Instant,
    pinged: Instant,
}

/// The connection has ended.
#[derive(Debug)]
pub(super) struct Gone;

impl Viewer {
    /// A viewer that gets this greeting first.
    pub(super) fn new(
        id: ViewerId,
        right: Right,
        socket: WebSocket<TcpStream>,
        greeting: &[Message],
    ) -> Self {
        Self {
            id,
            right,
            socket,
            subscriptions: HashMap::new(),
            parameters: HashSet::new(),
            replies: greeting.iter().cloned().collect(),
            messages: VecDeque::new(),
            heard: Instant::now(),
            pinged: Instant::now(),
        }
    }

    /// Takes what has come; passes requests on that it may make.
    pub(super) fn read(
        &mut self,
        requests: &mut Vec<(ViewerId, ViewerRequest)>,
    ) -> Result<(), Gone> {
        for _ in 0..READS_MAX {
            let message = match self.socket.read() {
                Ok(message) => message,
                Err(error) if is_busy(&error) => break,
                Err(_) => return Err(Gone),
            };
            self.heard = Instant::now();
            let parsed = match &message {
                Message::Text(text) => ClientMessage::parse_json(text),
                Message::Binary(bytes) => ClientMessage::parse_binary(bytes),
                Message::Ping(_) | Message::Pong(_) | Message::Close(_) | Message::Frame(_) => {
                    continue;
                }
            };
            match parsed {
                Ok(message) => self.take(message, requests),
                Err(error) => self.reply(Reply::Error(format!("invalid message: {error}"))),
            }
        }
        if self.heard.elapsed() > SILENCE || self.replies.len() > REPLIES_MAX {
            return Err(Gone);
        }
        if self.pinged.elapsed() > PING_INTERVAL {
            self.pinged = Instant::now();
            self.replies.push_back(Message::Ping(Bytes::new()));
        }
        Ok(())
    }

    fn take(&mut self, message: ClientMessage<'_>, requests: &mut Vec<(ViewerId, ViewerRequest)>) {
        let mut pass_on = |request| requests.push((self.id, request));
        let may_command = self.right == Right::Command;
        match message {
            ClientMessage::Subscribe(message) => {
                let known = 0..Topic::ALL.len() as u64;
                for one in message.subscriptions {
                    if known.contains(&one.channel_id) {
                        self.subscriptions.insert(one.channel_id, one.id);
                    }
                }
            }
            ClientMessage::Unsubscribe(message) => {
                let ended = message.subscription_ids;
                self.subscriptions.retain(|_, id| !ended.contains(id));
            }
            ClientMessage::SubscribeParameterUpdates(message) => {
                let room = NAMES_MAX.saturating_sub(self.parameters.len());
                let names = message.parameter_names.into_iter();
                let names = names.filter(|name| name.len() <= NAME_MAX);
                self.parameters.extend(names.take(room));
            }
            ClientMessage::UnsubscribeParameterUpdates(message) => {
                for name in message.parameter_names {
                    self.parameters.remove(&name);
                }
            }
            ClientMessage::GetParameters(message) => {
                pass_on(ViewerRequest::Get(message.parameter_names, message.id));
            }
            ClientMessage::SetParameters(message) if may_command => {
                pass_on(ViewerRequest::Set(message.parameters, message.id));
            }
            ClientMessage::SetParameters(message) => {
                // Answered with the values in force.
                let names = message.parameters.into_iter().map(|one| one.name);
                pass_on(ViewerRequest::Get(names.collect(), message.id));
                self.reply(Reply::Error(WATCHES_ONLY.into()));
            }
            ClientMessage::ServiceCallRequest(message) => {
                let service = Service::ALL.get(message.service_id as usize).copied();
                let call = Call {
                    service_id: message.service_id,
                    call_id: message.call_id,
                };
                match service {
                    Some(service) if may_command || service.is_free() => {
                        pass_on(ViewerRequest::Call(service, call));
                    }
                    Some(_) => self.reply(Reply::Failed(call, WATCHES_ONLY.into())),
                    None => self.reply(Reply::Failed(call, "unknown service".into())),
                }
            }
            _ => self.reply(Reply::Error("this server does not offer that".into())),
        }
    }

    /// Queues a reply.
    pub(super) fn reply(&mut self, reply: Reply) {
        let message = match reply {
            Reply::Parameters(parameters, id) => {
                let mut values = ParameterValues::new(parameters);
                values.id = id;
                Message::text(values.to_string())
            }
            Reply::Done(call) => {
                let response = ServiceCallResponse {
                    service_id: call.service_id,
                    call_id: call.call_id,
                    encoding: "json".into(),
                    payload: br#"{"success":true,"message":""}"#.into(),
                };
                Message::binary(response.to_bytes())
            }
            Reply::Failed(call, message) => {
                let failure = ServiceCallFailure {
                    service_id: call.service_id,
                    call_id: call.call_id,
                    message,
                };
                Message::text(failure.to_string())
            }
            Reply::Error(error) => Message::text(Status::error(error).to_string()),
        };
        self.replies.push_back(message);
    }

    /// Queues the new values of parameters that it has subscribed to.
    pub(super) fn update(&mut self, parameters: &[Parameter]) {
        let wanted = parameters
            .iter()
            .filter(|parameter| self.parameters.contains(&parameter.name));
        let wanted: Vec<Parameter> = wanted.cloned().collect();
        if !wanted.is_empty() {
            self.reply(Reply::Parameters(wanted, None));
        }
    }

    /// Queues a message if it has subscribed to its topic.
    pub(super) fn put(&mut self, message: &message_encoder::Message<'_>) {
        let Some(id) = self.subscriptions.get(&(message.topic as u64)) else {
            return;
        };
        if self.messages.len() == BACKLOG {
            self.messages.pop_front();
        }
        let data = MessageData::new(*id, message.log_time_ns, message.bytes);
        self.messages.push_back(Message::binary(data.to_bytes()));
    }

    /// Sends as much as the connection takes, replies first.
    pub(super) fn send(&mut self) -> Result<(), Gone> {
        let Self {
            socket,
            replies,
            messages,
            ..
        } = self;
        for queue in [replies, messages] {
            while let Some(message) = queue.pop_front() {
                match socket.write(message) {
                    Ok(()) => {}
                    Err(Error::WriteBufferFull(message)) => {
                        queue.push_front(*message);
                        break;
                    }
                    // It is in the connection's buffer.
                    Err(error) if is_busy(&error) => break,
                    Err(_) => return Err(Gone),
                }
            }
        }
        match socket.flush() {
            Err(error) if !is_busy(&error) => Err(Gone),
            Ok(()) | Err(_) => Ok(()),
        }
    }

    /// Tells it that the server ends, best effort.
    pub(super) fn close(&mut self) {
        let _ = self.socket.close(None);
        let _ = self.socket.flush();
    }
}

/// Whether the connection has nothing to read, or no room.
fn is_busy(error: &Error) -> bool {
    matches!(error, Error::Io(error) if error.kind() == std::io::ErrorKind::WouldBlock)
}
