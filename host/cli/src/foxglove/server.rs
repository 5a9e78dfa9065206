//! The server that viewers connect to, over the protocol `foxglove.sdk.v1`.
//!
//! It runs on the thread that calls [`Server::poll`], and never waits. A connection has 2 s
//! to become a viewer; there are at most 16 handshakes and 16 viewers at a time. For a further viewer
//! the oldest one without the token gives way, so that who stops or commands finds a place.

use std::cell::Cell;
use std::io::Write;
use std::net::{SocketAddr, TcpListener, TcpStream};
use std::rc::Rc;
use std::time::{Duration, Instant, SystemTime};

use armbridge_client::endpoint::{Endpoint, Exposure, OpenError};
use armbridge_client::tcp_pump::is_timeout;
use armbridge_log::message_encoder;
use armbridge_log::topics::Topic;
use foxglove::AppUrl;
use foxglove::websocket::Parameter;
use foxglove::ws_protocol::JsonMessage;
use foxglove::ws_protocol::schema::{EncodeError, Schema};
use foxglove::ws_protocol::server::server_info::Capability;
use foxglove::ws_protocol::server::{
    Advertise, AdvertiseServices, Channel, ServerInfo, advertise_services,
};
use tungstenite::Message;
use tungstenite::error::Error;
use tungstenite::handshake::server::{Callback, ErrorResponse, Request, Response, ServerHandshake};
use tungstenite::handshake::{HandshakeError, MidHandshake};
use tungstenite::http::HeaderValue;

use super::access::{Access, PROTOCOL, Right};
use super::pending_requests::{Reply, Service, ViewerRequest};
use super::viewer::{self, Viewer, ViewerId};

/// Longest time for a handshake.
const HANDSHAKE: Duration = Duration::from_secs(2);
const TIMEOUT: &str = "408 Request Timeout";
/// Handshakes at a time; a further one takes the place of the oldest.
const HANDSHAKES_MAX: usize = 16;
/// Viewers at a time; more with the token are closed.
const VIEWERS_MAX: usize = 16;

/// Why there is no server.
#[derive(Debug, thiserror::Error)]
pub enum ServerError {
    /// The port cannot be had.
    #[error("{0}; --port chooses another one, 0 any free one")]
    Listen(#[from] OpenError),
    /// The listener cannot be polled.
    #[error("cannot serve viewers: {0}")]
    Poll(#[from] std::io::Error),
    /// The topics cannot be announced.
    #[error("cannot announce the topics: {0}")]
    Schema(#[from] EncodeError),
}

/// Checks a request, and answers it.
#[derive(Debug)]
struct Gate {
    access: Rc<Access>,
    right: Rc<Cell<Right>>,
}

impl Callback for Gate {
    fn on_request(
        self,
        request: &Request,
        mut response: Response,
    ) -> Result<Response, ErrorResponse> {
        let checked = self.access.check(request);
        self.right.set(checked.map_err(|denial| denial.response())?);
        let protocol = HeaderValue::from_static(PROTOCOL);
        response
            .headers_mut()
            .insert("sec-websocket-protocol", protocol);
        Ok(response)
    }
}

/// A connection that is no viewer yet.
struct Handshake {
    since: Instant,
    /// For an answer where the handshake itself gives none.
    stream: TcpStream,
    right: Rc<Cell<Right>>,
    under_way: MidHandshake<ServerHandshake<TcpStream, Gate>>,
}

/// The server.
pub struct Server {
    listener: TcpListener,
    at: SocketAddr,
    access: Rc<Access>,
    /// Messages that a new viewer gets first.
    greeting: Vec<Message>,
    handshakes: Vec<Handshake>,
    viewers: Vec<Viewer>,
    /// Viewers so far.
    count: u64,
}

impl Server {
    /// Listens, on port 0 for any that is free. Services that let motors come on are
    /// offered only if they are allowed.
    ///
    /// # Errors
    /// If the port cannot be listened on, or is exposed to the network unasked.
    pub fn start(
        at: SocketAddr,
        exposure: Exposure,
        allow_arm: bool,
        access: Access,
    ) -> Result<Self, ServerError> {
        let (listener, _) = Endpoint::from(at).listen(exposure)?;
        listener.set_nonblocking(true)?;
        Ok(Self {
            at: listener.local_addr()?,
            listener,
            access: Rc::new(access),
            greeting: greeting(allow_arm)?,
            handshakes: Vec::new(),
            viewers: Vec::new(),
            count: 0,
        })
    }

    /// Address for a viewer that may command.
    pub fn url(&self) -> String {
        format!("ws://{}/?token={}", self.at, self.access.token())
    }

    /// Address to open in a browser, for the same.
    pub fn app_url(&self) -> String {
        AppUrl::new().with_websocket(self.url()).to_string()
    }

    /// Whether this viewer is still there.
    pub fn has(&self, id: ViewerId) -> bool {
        self.viewers.iter().any(|viewer| viewer.id == id)
    }

    /// Takes connections and what viewers have sent, and sends what waits for them.
    ///
    /// # Errors
    /// If the listener fails.
    pub fn poll(
        &mut self,
        requests: &mut Vec<(ViewerId, ViewerRequest)>,
    ) -> Result<(), ServerError> {
        for _ in 0..HANDSHAKES_MAX {
            match self.listener.accept() {
                Ok((stream, _)) => {
                    if self.handshakes.len() == HANDSHAKES_MAX {
                        refuse(&self.handshakes.remove(0).stream, TIMEOUT);
                    }
                    self.begin(stream);
                }
                Err(error) if is_timeout(&error) => break,
                // The peer has gone before it was accepted.
                Err(error) if error.kind() == std::io::ErrorKind::ConnectionAborted => {}
                Err(error) => return Err(error.into()),
            }
        }
        for handshake in std::mem::take(&mut self.handshakes) {
            if handshake.since.elapsed() > HANDSHAKE {
                refuse(&handshake.stream, TIMEOUT);
            } else {
                let Handshake { under_way, .. } = handshake;
                let result = under_way.handshake();
                self.go_on(handshake.since, handshake.stream, handshake.right, result);
            }
        }
        self.viewers
            .retain_mut(|viewer| viewer.read(requests).is_ok() && viewer.send().is_ok());
        Ok(())
    }

    fn begin(&mut self, stream: TcpStream) {
        // A connection that cannot be set up so has ended.
        let ready = stream
            .set_nonblocking(true)
            .and_then(|()| stream.set_nodelay(true))
            .and_then(|()| stream.try_clone());
        let Ok(answer) = ready else {
            return;
        };
        let right = Rc::new(Cell::new(Right::Watch));
        let gate = Gate {
            access: Rc::clone(&self.access),
            right: Rc::clone(&right),
        };
        let begun = ServerHandshake::start(stream, gate, Some(viewer::limits()));
        self.go_on(Instant::now(), answer, right, begun.handshake());
    }

    fn go_on(
        &mut self,
        since: Instant,
        stream: TcpStream,
        right: Rc<Cell<Right>>,
        result: Result<
            tungstenite::WebSocket<TcpStream>,
            HandshakeError<ServerHandshake<TcpStream, Gate>>,
        >,
    ) {
        match result {
            Ok(mut socket) if !self.make_room() => {
                // Best effort: the close alone suffices.
                let _ = socket.close(None);
            }
            Ok(socket) => {
                self.count += 1;
                let id = ViewerId(self.count);
                let viewer = Viewer::new(id, right.get(), socket, &self.greeting);
                self.viewers.push(viewer);
            }
            Err(HandshakeError::Interrupted(under_way)) => self.handshakes.push(Handshake {
                since,
                stream,
                right,
                under_way,
            }),
            // Answered.
            Err(HandshakeError::Failure(Error::Http(_))) => {}
            Err(HandshakeError::Failure(Error::AttackAttempt | Error::Capacity(_))) => {
                refuse(&stream, "431 Request Header Fields Too Large");
            }
            Err(HandshakeError::Failure(_)) => refuse(&stream, "400 Bad Request"),
        }
    }

    /// Whether there is a place for another viewer, if need be that of the oldest without the
    /// token: those with it may have armed the arm.
    fn make_room(&mut self) -> bool {
        if self.viewers.len() < VIEWERS_MAX {
            return true;
        }
        let mut viewers = self.viewers.iter();
        let oldest = viewers.position(|viewer| viewer.right == Right::Watch);
        oldest.is_some_and(|oldest| {
            self.viewers.remove(oldest).close();
            true
        })
    }

    /// Queues a reply to a viewer, if it is still there.
    pub fn reply(&mut self, to: ViewerId, reply: Reply) {
        if let Some(viewer) = self.viewers.iter_mut().find(|viewer| viewer.id == to) {
            viewer.reply(reply);
        }
    }

    /// Queues a message for its subscribers.
    pub fn put(&mut self, message: &message_encoder::Message<'_>) {
        for viewer in &mut self.viewers {
            viewer.put(message);
        }
    }

    /// Queues these parameters' values for their subscribers.
    pub fn publish(&mut self, parameters: &[Parameter]) {
        for viewer in &mut self.viewers {
            viewer.update(parameters);
        }
    }
}

impl Drop for Server {
    fn drop(&mut self) {
        for viewer in &mut self.viewers {
            viewer.close();
        }
    }
}

/// Answers a request that failed, best effort.
fn refuse(mut stream: &TcpStream, status: &str) {
    let _ = write!(
        stream,
        "HTTP/1.1 {status}\r\nConnection: close\r\nContent-Length: 0\r\n\r\n"
    );
}

/// Server, topics and services; a topic or service has its index as id.
fn greeting(allow_arm: bool) -> Result<Vec<Message>, EncodeError> {
    let since_1970 = SystemTime::now().duration_since(SystemTime::UNIX_EPOCH);
    let info = ServerInfo::new("armbridge")
        .with_capabilities([
            Capability::Parameters,
            Capability::ParametersSubscribe,
            Capability::Services,
        ])
        .with_supported_encodings(["json"])
        .with_session_id(since_1970.unwrap_or_default().as_millis().to_string());
    let mut greeting = vec![Message::text(info.to_string())];
    // A simulation passes its truth to logs only.
    for topic in Topic::ALL
        .into_iter()
        .filter(|topic| !topic.is_simulation())
    {
        let schema = Schema::new(topic.schema_name(), "protobuf", topic.schema());
        let channel = Channel::builder(topic as u64, topic.name(), "protobuf")
            .with_schema(schema)
            .build()?;
        greeting.push(Message::text(Advertise::new([channel]).to_string()));
    }
    let services = Service::ALL
        .into_iter()
        .zip(0..)
        .filter(|(service, _)| allow_arm || !service.energises())
        .map(|(service, id)| announce(service, id))
        .collect::<Result<Vec<_>, _>>()?;
    greeting.push(Message::text(AdvertiseServices::new(services).to_string()));
    Ok(greeting)
}

/// A service without arguments; its answer is that of ROS's `Trigger`.
fn announce(
    service: Service,
    id: u32,
) -> Result<advertise_services::Service<'static>, EncodeError> {
    let schema = |name: &'static str, properties: &str| {
        let text = format!(r#"{{"type":"object","properties":{{{properties}}}}}"#);
        Schema::new(name, "jsonschema", text.into_bytes())
    };
    let answer = r#""success":{"type":"boolean"},"message":{"type":"string"}"#;
    advertise_services::Service::new(id, service.name(), "std_srvs/srv/Trigger")
        .with_request("json", schema("Request", ""))?
        .with_response("json", schema("Response", answer))
}
