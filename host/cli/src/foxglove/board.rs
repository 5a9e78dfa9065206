//! What is known of the board, for whoever has to answer a viewer.

use armbridge_client::event::{Event, EventKind};
use armbridge_client::status::BoardStatus;
use armbridge_shared::link::message::{Command, Refusal, ToBoard, ToHost};

use crate::open_commands::OpenCommands;

/// Made of what was said on the link.
#[derive(Clone, Debug, Default)]
pub struct Board {
    /// What it has told.
    pub status: BoardStatus,
    /// What was refused last, and how many refusals there were before.
    pub refused: Option<(Asked, Refusal)>,
    /// How many there were.
    pub refusals: u64,
    open: OpenCommands<Asked>,
}

/// A command, as far as somebody waits for what becomes of it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Asked {
    /// Settings.
    Change,
    /// To arm, or to drive.
    Drive,
    /// To disarm.
    Disarm,
    /// To clear a fault.
    Clear,
    /// Anything else.
    Other,
}

impl Asked {
    fn of(command: &Command) -> Self {
        match command {
            Command::Configure(_) | Command::Limit(_) => Self::Change,
            Command::Arm { .. }
            | Command::Torque(_)
            | Command::Regulate(_)
            | Command::Follow(_)
            | Command::Stream { .. }
            | Command::Experiment(_) => Self::Drive,
            Command::Idle => Self::Disarm,
            Command::ClearFault => Self::Clear,
            Command::Prepare | Command::Release | Command::Save => Self::Other,
        }
    }
}

impl Board {
    /// Takes what happened.
    pub fn take(&mut self, event: &Event) {
        match event.kind {
            EventKind::Sent(sequence, ToBoard::Command(command)) => {
                self.open.sent(sequence, Asked::of(&command));
            }
            EventKind::Received(
                _,
                ToHost::Ack {
                    sequence, result, ..
                },
            ) => {
                self.answered(sequence, result);
            }
            EventKind::Received(_, message) => self.status.take(&message),
            // The next may be another board.
            EventKind::Disconnected => *self = Self::default(),
            EventKind::Sent(..) | EventKind::Lost(..) | EventKind::Damaged(..) => {}
        }
    }

    fn answered(&mut self, sequence: u16, result: Result<(), Refusal>) {
        // Busy is asked again.
        if let (Some(asked), Err(refusal)) = (self.open.acknowledged(sequence), result)
            && refusal != Refusal::Busy
        {
            self.refused = Some((asked, refusal));
            self.refusals += 1;
        }
    }
}
