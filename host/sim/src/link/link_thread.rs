//! Link thread: drives a board's link while the program's other threads show and steer it.
//!
//! It also passes on hands on a simulated arm, its own or a served one: they lift the arm to
//! its start, hold it there until a motor drives it, and push it.
//!
//! At any end, by a key, an error or a panic, the board is disarmed and the thread is
//! joined.

use std::sync::mpsc::{Sender, channel};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use armbridge_client::LinkError;
use armbridge_client::error::SessionError;
use armbridge_client::session::{ChannelHost, PARK_TIMEOUT_US, Request, SessionHandle};
use armbridge_link::server::{LinkRole, Touch};

use super::{BoardUri, Options, drive};
use crate::cosim::Interaction;

/// Time in which the board must acknowledge that it is disarmed, once the arm has been parked.
const LEAVE: Duration = Duration::from_secs(3);
/// Period at which that is checked.
const LOOK: Duration = Duration::from_millis(10);

/// Way of a hand to the simulated arm.
#[derive(Debug)]
enum Hands {
    /// To the bench of this process.
    Bench(Sender<Interaction>),
    /// To a server of the link; a real board has none.
    Server(Sender<Touch>),
}

/// Why a link is no longer served.
#[derive(Debug, thiserror::Error)]
pub enum LinkThreadError {
    /// The system has no thread left.
    #[error("cannot begin a thread: {0}")]
    Thread(std::io::Error),
    /// The link or its session ended.
    #[error(transparent)]
    Link(#[from] LinkError<SessionError>),
    /// The board does not acknowledge that it has disarmed.
    #[error(
        "the link does not end; the board switches torque off when its host is silent: check \
         that the arm is limp"
    )]
    Stuck,
    /// The thread panicked.
    #[error("the link's thread panicked: an error of this program")]
    Panicked,
}

/// The thread, until its end has been noticed.
type Served = JoinHandle<Result<(), LinkThreadError>>;

/// A link and the thread that serves it.
#[derive(Debug)]
pub struct LinkThread {
    session: SessionHandle,
    hands: Hands,
    thread: Mutex<Option<Served>>,
}

impl LinkThread {
    /// Begins to serve the link, with these options and taps.
    ///
    /// # Errors
    /// If the system has no thread left.
    pub fn begin(
        uri: BoardUri,
        options: impl FnOnce() -> Options + Send + 'static,
    ) -> Result<Self, LinkThreadError> {
        let (host, session) = ChannelHost::new();
        let (bench, interactions) = channel();
        let (server, touches) = channel();
        let hands = if uri.is_simulated() {
            // A thread that does not begin needs no hand.
            let _ = bench.send(Touch::Lift.into());
            Hands::Bench(bench)
        } else {
            Hands::Server(server)
        };
        let served = std::thread::Builder::new()
            .name("link".into())
            .spawn(move || {
                let mut options = options();
                options.interactions = Some(interactions);
                options.link.touches = Some(touches);
                let (_, result) = drive(&uri, options, host);
                Ok(result?)
            })
            .map_err(LinkThreadError::Thread)?;
        Ok(Self {
            session,
            hands,
            thread: Mutex::new(Some(served)),
        })
    }

    /// Session with the board.
    pub fn session(&self) -> &SessionHandle {
        &self.session
    }

    /// Makes a request of the board.
    pub fn request(&self, request: Request) {
        // A link that has ended is noticed by `is_over`.
        let _ = self.session.request(request);
    }

    /// Touches the simulated arm; without effect on a real one.
    pub fn touch(&self, touch: Touch) {
        // A link that has ended is noticed by `is_over`.
        let _ = match &self.hands {
            Hands::Bench(bench) => bench.send(touch.into()).is_ok(),
            Hands::Server(server) => server.send(touch).is_ok(),
        };
    }

    /// The commanding program, on a link that is served to several.
    pub fn role(&self) -> Option<LinkRole> {
        self.session.status().role
    }

    /// Whether the link is no longer served.
    pub fn is_over(&self) -> bool {
        self.thread().as_ref().is_none_or(JoinHandle::is_finished)
    }

    /// Disarms the board and waits until it has acknowledged that. Without effect on a link that
    /// has ended.
    ///
    /// # Errors
    /// If the link could not be served, or ended by itself; at the first call.
    pub fn end(&self) -> Result<(), LinkThreadError> {
        self.request(Request::Leave);
        let has_pose = self.session.status().has_pose();
        let park = Duration::from_micros(if has_pose { PARK_TIMEOUT_US } else { 0 });
        let begun = Instant::now();
        while !self.is_over() {
            if begun.elapsed() > park + LEAVE {
                return Err(LinkThreadError::Stuck);
            }
            std::thread::sleep(LOOK);
        }
        let ended = self.thread().take();
        match ended.map(JoinHandle::join) {
            None => Ok(()),
            Some(Ok(result)) => result,
            Some(Err(_)) => Err(LinkThreadError::Panicked),
        }
    }

    fn thread(&self) -> MutexGuard<'_, Option<Served>> {
        self.thread.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Drop for LinkThread {
    fn drop(&mut self) {
        // An error cannot be returned here.
        let _ = self.end();
    }
}
