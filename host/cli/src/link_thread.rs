//! Link thread: drives a board's link while the program's other threads show and steer it.
//!
//! On a simulated arm it also passes on what hands do: lift the arm to its start, hold it
//! until a motor drives it, and push it.
//!
//! At any end, by a key, an error or a panic, the board is disarmed and the thread is
//! joined.

use std::sync::mpsc::{Sender, channel};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use armbridge_client::LinkError;
use armbridge_client::error::SessionError;
use armbridge_client::session::{ChannelHost, Request, SessionHandle};
use armbridge_sim::cosim::Interaction;
use armbridge_sim::link::{BoardUri, Options, drive};
use armbridge_sim::plant::Push;

/// How long the board may take to acknowledge that it is disarmed.
const LEAVE: Duration = Duration::from_secs(3);
/// Period at which that is checked.
const LOOK: Duration = Duration::from_millis(10);

/// A push by a key, which a standing arm takes without falling.
const PUSH_NM: f64 = 0.3;
const PUSH_NS: u64 = 200_000_000;

/// A hand on a simulated arm.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Hand {
    /// Brings it back to where it began, and holds it until a motor drives it.
    Lift,
    /// Pushes this joint, 0.3 N m for 0.2 s.
    Push(usize),
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

/// A link and the thread that serves it.
#[derive(Debug)]
pub struct LinkThread {
    session: SessionHandle,
    hands: Sender<Interaction>,
    thread: Option<JoinHandle<Result<(), LinkThreadError>>>,
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
        let (hands, interactions) = channel();
        let mut thread = Self {
            session,
            hands,
            thread: None,
        };
        thread.apply_hand(Hand::Lift);
        let served = std::thread::Builder::new()
            .name("link".into())
            .spawn(move || {
                let mut options = options();
                options.interactions = Some(interactions);
                let (_, result) = drive(&uri, options, host);
                Ok(result?)
            })
            .map_err(LinkThreadError::Thread)?;
        thread.thread = Some(served);
        Ok(thread)
    }

    /// Makes a request of the board.
    pub fn request(&self, request: Request) {
        // A link that has ended is noticed by `is_over`.
        let _ = self.session.request(request);
    }

    /// Applies a hand to the simulated arm; without effect on a real one.
    pub fn apply_hand(&self, hand: Hand) {
        let interaction = match hand {
            Hand::Lift => Interaction::Lift,
            Hand::Push(joint) => Interaction::Push(Push {
                joint,
                torque_nm: PUSH_NM,
                // At once.
                start_ns: 0,
                duration_ns: PUSH_NS,
            }),
        };
        let _ = self.hands.send(interaction);
    }

    /// Whether the link is no longer served.
    pub fn is_over(&self) -> bool {
        self.thread.as_ref().is_none_or(JoinHandle::is_finished)
    }

    /// Disarms the board and waits until it has acknowledged that.
    ///
    /// # Errors
    /// If the link could not be served, or ended by itself.
    pub fn end(mut self) -> Result<(), LinkThreadError> {
        self.leave()
    }

    fn leave(&mut self) -> Result<(), LinkThreadError> {
        self.request(Request::Leave);
        let begun = Instant::now();
        while !self.is_over() {
            if begun.elapsed() > LEAVE {
                return Err(LinkThreadError::Stuck);
            }
            std::thread::sleep(LOOK);
        }
        match self.thread.take().map(JoinHandle::join) {
            None => Ok(()),
            Some(Ok(result)) => result,
            Some(Err(_)) => Err(LinkThreadError::Panicked),
        }
    }
}

impl Drop for LinkThread {
    fn drop(&mut self) {
        // An error cannot be returned here.
        let _ = self.leave();
    }
}
