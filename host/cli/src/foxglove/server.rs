//! The server that viewers connect to.
//!
//! Messages go to viewers over the protocol `foxglove.sdk.v1`; their requests come back
//! over a channel, so that nothing waits on the server's own threads.

use std::net::IpAddr;
use std::sync::mpsc::{Receiver, Sender, channel};
use std::sync::{Arc, Mutex, PoisonError};

use armbridge_log::topics::{Message, Topic};
use foxglove::websocket::service::{
    Handler, Request as Call, Responder, Service as FoxgloveService, ServiceSchema,
};
use foxglove::websocket::{
    AnyClient, GetParametersResponder, Parameter, ParameterHandler, SetParametersResponder, Status,
};
use foxglove::{
    ChannelBuilder, Context, FoxgloveError, PartialMetadata, RawChannel, Schema, WebSocketServer,
    WebSocketServerHandle,
};

use super::pending_requests::{Service, ViewerRequest};

/// Messages that wait for a viewer; more than 4 s of all topics. Then its oldest go.
const BACKLOG: usize = 8192;

/// Why there is no server.
#[derive(Debug, thiserror::Error)]
pub enum ServerError {
    /// The port cannot be had.
    #[error(
        "cannot serve on {host}:{port}: {source}; choose another with --port, 0 for any free one"
    )]
    Bind {
        /// Address.
        host: IpAddr,
        /// Port.
        port: u16,
        /// The system's reason.
        source: std::io::Error,
    },
    /// Anything else.
    #[error("cannot serve viewers: {0}")]
    Other(#[from] FoxgloveError),
}

/// The server.
#[derive(Debug)]
pub struct Server {
    handle: WebSocketServerHandle,
    /// Channels are open as long as this is there.
    _context: Arc<Context>,
    /// In the order of [`Topic::ALL`].
    channels: Vec<Arc<RawChannel>>,
    requests: Receiver<ViewerRequest>,
}

impl Server {
    /// Listens, on port 0 for any that is free. Services that let motors come on are
    /// offered only if they are allowed.
    ///
    /// # Errors
    /// If the port cannot be listened on.
    pub fn start(host: IpAddr, port: u16, allow_arm: bool) -> Result<Self, ServerError> {
        let context = Context::new();
        let channels = Topic::ALL
            .into_iter()
            .map(|topic| {
                let schema = Schema::new(topic.schema_name(), "protobuf", topic.schema());
                ChannelBuilder::new(topic.name())
                    .context(&context)
                    .message_encoding("protobuf")
                    .schema(schema)
                    .build_raw()
            })
            .collect::<Result<_, _>>()?;
        let (sender, requests) = channel();
        let sender = Arc::new(RequestSender(Mutex::new(sender)));
        let offered = Service::ALL
            .into_iter()
            .filter(|service| allow_arm || !service.energises())
            .map(|service| offer(service, &sender));
        let handle = WebSocketServer::new()
            .name("armbridge")
            .bind(host.to_string(), port)
            .context(&context)
            .message_backlog_size(BACKLOG)
            .supported_encodings(["json"])
            .services(offered)
            .parameter_handler(Arc::clone(&sender) as Arc<dyn ParameterHandler>)
            .start_blocking()
            .map_err(|error| match error {
                FoxgloveError::Bind(source) => ServerError::Bind { host, port, source },
                error => ServerError::Other(error),
            })?;
        Ok(Self {
            handle,
            _context: context,
            channels,
            requests,
        })
    }

    /// The port that it listens on.
    pub fn port(&self) -> u16 {
        self.handle.port()
    }

    /// Address to open in a browser.
    pub fn app_url(&self) -> String {
        self.handle.app_url().to_string()
    }

    /// Viewers that are there.
    pub fn viewers(&self) -> usize {
        self.handle.client_count()
    }

    /// Viewers' requests.
    pub fn requests(&self) -> &Receiver<ViewerRequest> {
        &self.requests
    }

    /// Publishes a message to its subscribers.
    pub fn put(&self, message: Message<'_>) {
        if let Some(channel) = self.channels.get(message.topic as usize) {
            let meta = PartialMetadata::with_log_time(message.log_time_ns);
            channel.log_with_meta(message.bytes, meta);
        }
    }

    /// Publishes these parameters' values to their subscribers.
    pub fn publish(&self, parameters: Vec<Parameter>) {
        self.handle.publish_parameter_values(parameters);
    }

    /// Shows an error to all viewers.
    pub fn publish_error(&self, error: &str) {
        self.handle.publish_status(Status::error(error));
    }

    /// Disconnects all viewers.
    pub fn stop(self) {
        self.handle.stop().wait_blocking();
    }
}

/// Passes requests on to the thread that serves them.
struct RequestSender(Mutex<Sender<ViewerRequest>>);

impl RequestSender {
    fn send(&self, request: ViewerRequest) {
        let sender = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        // The receiver is gone: the server is about to end.
        let _ = sender.send(request);
    }
}

impl ParameterHandler for RequestSender {
    fn get(
        &self,
        _: AnyClient,
        names: Vec<String>,
        _: Option<String>,
        responder: GetParametersResponder,
    ) {
        self.send(ViewerRequest::Get(names, responder));
    }

    fn set(
        &self,
        _: AnyClient,
        parameters: Vec<Parameter>,
        _: Option<String>,
        responder: SetParametersResponder,
    ) {
        self.send(ViewerRequest::Set(parameters, responder));
    }
}

/// Passes calls of a service on.
struct ServiceHandler(Service, Arc<RequestSender>);

impl Handler for ServiceHandler {
    fn call(&self, _: Call, responder: Responder) {
        self.1.send(ViewerRequest::Call(self.0, responder));
    }
}

/// A service without arguments; its answer is that of ROS's `Trigger`.
fn offer(service: Service, sender: &Arc<RequestSender>) -> FoxgloveService {
    let object = |properties: &str| {
        let text = format!(r#"{{"type":"object","properties":{{{properties}}}}}"#);
        text.into_bytes()
    };
    let answer = r#""success":{"type":"boolean"},"message":{"type":"string"}"#;
    let schema = ServiceSchema::new("std_srvs/srv/Trigger")
        .with_request("json", Schema::new("Request", "jsonschema", object("")))
        .with_response(
            "json",
            Schema::new("Response", "jsonschema", object(answer)),
        );
    FoxgloveService::builder(service.name(), schema)
        .handler(ServiceHandler(service, Arc::clone(sender)))
}
