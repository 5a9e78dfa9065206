//! A hand on the simulated arm behind a served link: one request on a connection of its own.
//!
//! It joins as an observer and says no hello, so that it never commands.

use std::time::{Duration, Instant};

use armbridge_link::frame::Encoder;
use armbridge_link::server::{FromServer, ToServer, Touch, TouchRefusal};

use super::link_filter::LinkFilter;
use super::{LinkUri, program};
use crate::endpoint::OpenError;
use crate::servo_bus::Line;
use crate::servo_bus::line::TcpLine;

/// Longest wait for the answer.
const TIMEOUT: Duration = Duration::from_secs(2);
/// Factor by which simulated time may be slower than the wall clock on a busy machine.
const SLOWNESS_MAX: u32 = 20;

/// Reason for which an arm is not touched.
#[derive(Debug, thiserror::Error)]
pub enum TouchError {
    /// A link that is not served.
    #[error("only a simulated arm can be touched: {0} is a board of its own")]
    Real(LinkUri),
    /// A pseudo-terminal.
    #[error(
        "{0} has one program at a time: serve the board on tcp://HOST:PORT to touch its arm \
         from another one"
    )]
    Terminal(LinkUri),
    /// The socket does not connect.
    #[error(transparent)]
    Connect(#[from] OpenError),
    /// The peer does not answer as a server does.
    #[error(
        "only a simulated arm can be touched: what listens at {0} is no `armbridge serve board` \
         of this version"
    )]
    NotServed(LinkUri),
    /// The server's reason.
    #[error("{}", in_words(*.0))]
    Refused(TouchRefusal),
}

fn in_words(refusal: TouchRefusal) -> &'static str {
    match refusal {
        TouchRefusal::Armed => "the motors hold the arm: `armbridge disarm` first, or push it",
        TouchRefusal::Value => "the server refuses this torque, angle or time",
        TouchRefusal::NoArm => "the server has no simulated arm of its own",
    }
}

/// Touches the simulated arm behind this link; returns when a hand has moved it.
///
/// # Errors
/// If there is none, or its server refuses.
pub fn touch(link: &LinkUri, touch: Touch) -> Result<(), TouchError> {
    let endpoint = match link {
        LinkUri::Tcp(endpoint) => endpoint,
        LinkUri::Pty(_) => return Err(TouchError::Terminal(link.clone())),
        LinkUri::Usb(_) | LinkUri::Serial(_) => return Err(TouchError::Real(link.clone())),
    };
    let not_served = |_| TouchError::NotServed(link.clone());
    let mut line = TcpLine::new(endpoint.connect()?);
    let join = ToServer::Join {
        is_observer: true,
        program: program::this(),
    };
    let mut encoder = Encoder::default();
    let mut frames = encoder.encode(&join).1.to_vec();
    frames.extend_from_slice(encoder.encode(&ToServer::Touch(touch)).1);
    line.send(&frames).map_err(not_served)?;
    let motion = Duration::from_micros(touch.motion_us().into());
    let begun = Instant::now();
    // First for any message of a server, which identifies it; then for the answer.
    let mut until = begun + TIMEOUT;
    let mut filter = LinkFilter::default();
    let mut answer = None;
    while answer.is_none() {
        let bytes = line.receive(until).map_err(not_served)?;
        filter.pass(&bytes, |message| {
            until = begun + TIMEOUT + motion * SLOWNESS_MAX;
            if let FromServer::Touched(result) = message {
                answer = Some(result);
            }
        });
        if Instant::now() >= until {
            break;
        }
    }
    let answer = answer.ok_or_else(|| TouchError::NotServed(link.clone()))?;
    answer.map_err(TouchError::Refused)
}
