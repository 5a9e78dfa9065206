//! Hosts that do one thing and end: what one-line commands put on a link.
//!
//! An [`Errand`] hears the link for its [`Task`] and shows it what is known of the
//! board by now; the task asks for what it wants by the [`Desk`], as a person would by
//! the dashboard. A task that gives up says why; the link then says goodbye for it.
//!
//! | module        | what                                                        |
//! |---------------|-------------------------------------------------------------|
//! | [`status`]    | what the board says of itself, and how the link does        |
//! | [`arm`]       | armed, until somebody presses ctrl-c or something happens   |
//! | [`off`]       | disarmed, stopped, or a fault cleared                       |
//! | [`calibrate`] | where each joint's zero is, and which way it counts         |

pub mod arm;
pub mod calibrate;
pub mod off;
pub mod status;

use armbridge_shared::link::message::{Hello, ToHost};

use crate::watch::model::Model;
use armbridge_client::Host;
use armbridge_client::event::{Direction, Ear, What};
use armbridge_client::station::desk::Desk;

/// Longest that a task waits for its time, in µs.
const LOOK_US: u64 = 10_000;

/// How long servos may take to be found: bring-up takes 30 ms, at several rates longer.
const SERVO_TIMEOUT_US: u64 = 3_000_000;

/// How long a command may take to be answered.
const ANSWER_TIMEOUT_US: u64 = 2_000_000;

/// Why a task came to nothing: one sentence that says what to do.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub struct GaveUp(pub String);

/// What a task looks at, and where it asks.
#[derive(Debug)]
pub struct View<'a> {
    /// The host's time in µs.
    pub now_us: u64,
    /// What is known of the board.
    pub model: &'a Model,
    /// Where to ask for things; [`Request::Leave`](armbridge_client::station::Request::Leave)
    /// ends the errand.
    pub desk: &'a mut Desk,
}

/// One thing to do.
pub trait Task {
    /// Something was heard, or time has passed.
    ///
    /// # Errors
    /// If it comes to nothing.
    fn look(&mut self, view: View<'_>) -> Result<(), GaveUp>;

    /// The connection broke; it may come back, disarmed.
    fn parted(&mut self, _now_us: u64) {}
}

/// A host with one task.
pub struct Errand<T> {
    /// What is done.
    pub task: T,
    /// What is known of the board.
    pub model: Model,
    /// The board's own.
    pub hello: Option<Hello>,
    desk: Desk,
    ear: Ear,
    words: Vec<u8>,
    look_us: u64,
}

impl<T: Task> Errand<T> {
    /// Not begun yet.
    pub fn new(task: T) -> Self {
        Self {
            task,
            model: Model::default(),
            hello: None,
            desk: Desk::default(),
            ear: Ear::default(),
            words: Vec::new(),
            look_us: 0,
        }
    }

    fn listen(&mut self, direction: Direction, now_us: u64, bytes: &[u8]) {
        let Self {
            ear, model, hello, ..
        } = self;
        let now_ns = now_us * 1_000;
        model.advance(now_ns);
        ear.take(direction, now_ns, bytes, |event| {
            if let What::Told(_, ToHost::Hello(said)) = event.what {
                *hello = Some(said);
            }
            model.take(&event);
        });
    }

    fn look(&mut self, now_us: u64) -> Result<(), GaveUp> {
        self.look_us = now_us + LOOK_US;
        self.task.look(View {
            now_us,
            model: &self.model,
            desk: &mut self.desk,
        })
    }
}

impl<T: Task> Host for Errand<T> {
    type Error = GaveUp;

    fn transmit(&mut self, now_us: u64) -> Result<&[u8], GaveUp> {
        self.model.advance(now_us * 1_000);
        self.look(now_us)?;
        let words = self.desk.transmit(now_us).map_err(in_words)?;
        self.words.clear();
        self.words.extend_from_slice(words);
        let words = std::mem::take(&mut self.words);
        self.listen(Direction::ToBoard, now_us, &words);
        self.words = words;
        Ok(&self.words)
    }

    fn receive(&mut self, now_us: u64, bytes: &[u8]) -> Result<(), GaveUp> {
        self.listen(Direction::ToHost, now_us, bytes);
        self.desk.receive(now_us, bytes, |_| {}).map_err(in_words)?;
        self.look(now_us)
    }

    fn wake_at_us(&self) -> u64 {
        self.look_us.min(self.desk.wake_at_us())
    }

    fn is_done(&self) -> bool {
        self.desk.is_done()
    }

    fn parted(&mut self, now_us: u64) {
        self.ear = Ear::default();
        // What was known is not so any more.
        self.model.link.parted(now_us * 1_000);
        self.model.report = None;
        self.model.record = None;
        self.model.trip = None;
        self.desk.parted(now_us);
        self.task.parted(now_us);
    }
}

#[expect(clippy::needless_pass_by_value, reason = "for map_err")]
fn in_words(error: armbridge_client::error::OperatorError) -> GaveUp {
    GaveUp(error.to_string())
}
