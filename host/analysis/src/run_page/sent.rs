//! A command of the list of events, and the replies to it.

use armbridge_link::message::Command;

/// Frames before the last point of a stream, to which replies may still come: half of all
/// sequence numbers.
const SPAN_MAX: u16 = 1 << 15;

/// A command, with its repetitions, or the points of a stream.
#[derive(Debug)]
pub(super) struct Sent {
    pub(super) command: Command,
    /// Sequence number of the last frame that carried it, or a point of its stream.
    sequence: u16,
    /// Frames since the first point of the stream, at most [`SPAN_MAX`]; 0 for other commands.
    span: u16,
    /// Place in the list; none if it is not there.
    pub(super) place: Option<usize>,
    /// Its text, without its reply.
    text: String,
    /// It may be sent again.
    pub(super) is_open: bool,
    /// A tick has accepted it, or a point of its stream.
    pub(super) is_accepted: bool,
    /// Points of a stream, and how many of them are refused.
    points: u32,
    refused: u32,
    /// Reason of the last refusal.
    reason: Option<String>,
}

impl Sent {
    pub(super) fn new(sequence: u16, command: Command, text: String, place: Option<usize>) -> Self {
        Self {
            command,
            sequence,
            span: 0,
            place,
            text,
            is_open: true,
            is_accepted: false,
            points: 1,
            refused: 0,
            reason: None,
        }
    }

    /// It, or a point of its stream, is refused.
    pub(super) fn refuse(&mut self, reason: String) {
        self.refused += 1;
        self.reason = Some(reason);
    }

    /// Whether a reply with this sequence number is to it. Replies may come late: that to a
    /// point of a stream after the next point has been sent.
    pub(super) fn is_answered_by(&self, sequence: u16) -> bool {
        self.sequence.wrapping_sub(sequence) <= self.span
    }

    /// It is sent again. Only the reply to the last frame counts, but for a stream.
    pub(super) fn repeat(&mut self, sequence: u16) {
        if matches!(self.command, Command::Stream { .. }) {
            let frames = sequence.wrapping_sub(self.sequence);
            self.span = self.span.saturating_add(frames).min(SPAN_MAX);
        }
        self.sequence = sequence;
    }

    /// Adds a point of a stream.
    pub(super) fn stream(&mut self, sequence: u16, command: Command) {
        self.repeat(sequence);
        self.command = command;
        self.is_open = true;
        self.points += 1;
        self.text = format!("follow {} streamed points", self.points);
    }

    /// Its text with its reply.
    pub(super) fn described(&self) -> String {
        match &self.reason {
            Some(reason) if self.points > 1 => {
                format!("{}, {} refused: {reason}", self.text, self.refused)
            }
            Some(reason) => format!("{}, refused: {reason}", self.text),
            None => self.text.clone(),
        }
    }
}
