//! State and statistics of the link.

use armbridge_client::event::Direction;
use armbridge_client::{enum_names, refusal_text};
use armbridge_link::frame::FrameError;
use armbridge_link::message::{Command, Refusal, ToBoard};

use super::rate::Rate;
use crate::pending_commands::PendingCommands;

/// Time without a frame after which the link is quiet: at the longest period a board
/// sends ten records a second.
const QUIET_NS: u64 = 500_000_000;

/// State of the connection.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Line {
    /// Nothing has come yet.
    Opening,
    /// Frames come.
    Up,
    /// It is open, but silent for this time in ns.
    Quiet(u64),
    /// It broke this time ago, in ns.
    Parted(u64),
}

/// Counts and times of the link, since the beginning.
#[derive(Clone, Debug, Default)]
pub struct Link {
    /// Frames from the board.
    frames: Rate,
    received_ns: Option<u64>,
    parted_ns: Option<u64>,
    /// Each command, and when it was sent in ns.
    open: PendingCommands<(Command, u64)>,
    /// Frames that went missing on their way.
    pub lost: u64,
    /// Frames that came damaged.
    pub damaged: u64,
    /// Frames that this build does not understand.
    pub foreign: u64,
    /// Records that the board dropped because the host did not fetch them.
    pub dropped: u64,
    /// Number of broken connections.
    pub breaks: u64,
    /// From a command's last frame to its acknowledgement, the latest, in ns.
    pub round_trip_ns: Option<u64>,
    /// Result of the latest command.
    pub answer: Option<String>,
    /// Why the board is not armed, if it was asked to be. What is asked of the arm after that
    /// is refused for this reason first.
    pub arm_refusal: Option<Refusal>,
}

impl Link {
    /// A frame came from the board.
    pub fn received(&mut self, now_ns: u64) {
        self.frames.note(now_ns);
        self.received_ns = Some(now_ns);
        self.parted_ns = None;
    }

    /// The connection broke.
    pub fn disconnected(&mut self, now_ns: u64) {
        self.breaks += 1;
        self.parted_ns = Some(now_ns);
        self.open.clear();
    }

    /// The host sent a frame.
    pub fn sent(&mut self, now_ns: u64, sequence: u16, message: &ToBoard) {
        if let ToBoard::Command(command) = message {
            self.open.sent(sequence, (*command, now_ns));
        }
    }

    /// The board answered it.
    pub fn acknowledged(&mut self, now_ns: u64, sequence: u16, result: Result<(), Refusal>) {
        let Some((command, sent_ns)) = self.open.acknowledged(sequence) else {
            return;
        };
        self.round_trip_ns = Some(now_ns.saturating_sub(sent_ns));
        let title = title(&command);
        let is_arm = matches!(command, Command::Arm { .. });
        match result {
            // The client repeats the command.
            Err(Refusal::Busy) => {}
            Err(_) if self.arm_refusal.is_some() && command.is_drive() => {}
            Err(refusal) => {
                self.arm_refusal = is_arm.then_some(refusal);
                let words = refusal_text::in_words(refusal);
                self.answer = Some(format!("{title}: refused: {words}"));
            }
            Ok(()) => {
                self.arm_refusal = None;
                self.answer = Some(format!("{title}: done"));
            }
        }
    }

    /// Frames went missing.
    pub fn lost(&mut self, frames: u16) {
        self.lost += u64::from(frames);
    }

    /// A frame could not be read.
    pub fn garbled(&mut self, direction: Direction, error: FrameError) {
        match (direction, error) {
            (_, FrameError::Damaged) => self.damaged += 1,
            (_, FrameError::Version(_) | FrameError::Direction | FrameError::Schema) => {
                self.foreign += 1;
            }
        }
    }

    /// Frames from the board in a second.
    pub fn frames_per_s(&self, now_ns: u64) -> f64 {
        self.frames.per_s(now_ns)
    }

    /// State of the connection.
    pub fn line(&self, now_ns: u64) -> Line {
        if let Some(parted_ns) = self.parted_ns {
            return Line::Parted(now_ns.saturating_sub(parted_ns));
        }
        match self.received_ns {
            None => Line::Opening,
            Some(received_ns) => match now_ns.saturating_sub(received_ns) {
                quiet_ns if quiet_ns > QUIET_NS => Line::Quiet(quiet_ns),
                _ => Line::Up,
            },
        }
    }
}

/// A command's name, with blanks.
fn title(command: &Command) -> &'static str {
    match command {
        Command::Idle => "disarm",
        Command::ClearFault => "clear fault",
        Command::Arm { .. }
        | Command::Torque(_)
        | Command::Regulate(_)
        | Command::Follow(_)
        | Command::Stream { .. }
        | Command::Experiment(_)
        | Command::Float
        | Command::Park
        | Command::Prepare
        | Command::Release
        | Command::Configure(_)
        | Command::Limit(_)
        | Command::Save => enum_names::command(command),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_follows_a_refusal_to_arm_does_not_hide_its_cause() {
        let mut link = Link::default();
        let mut ask = |sequence, command, result| {
            link.sent(0, sequence, &ToBoard::Command(command));
            link.acknowledged(1, sequence, result);
            link.answer.clone().unwrap()
        };
        let arm = Command::Arm { session: 1 };
        let regulate = Command::Regulate([2.0, 0.0]);
        let cause = "arm: refused: joint 2 stands beyond its angle limit";
        let beyond = Err(Refusal::BeyondLimit { joint: 1 });
        assert!(ask(1, arm, beyond).starts_with(cause));
        assert!(ask(2, regulate, Err(Refusal::Disarmed)).starts_with(cause));
        assert!(ask(3, regulate, Err(Refusal::OutOfRange)).starts_with(cause));
        // Once it is armed, a refusal has a cause of its own.
        assert_eq!(ask(4, arm, Ok(())), "arm: done");
        let refused = ask(5, regulate, Err(Refusal::OutOfRange));
        assert!(refused.starts_with("regulate: refused"), "{refused}");
    }
}
