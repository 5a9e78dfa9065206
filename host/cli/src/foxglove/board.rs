//! The board as viewers' requests need it: its status, and its latest refusal.

use armbridge_client::event::{Event, EventKind};
use armbridge_client::status::BoardStatus;
use armbridge_link::message::{Command, Refusal, ToBoard, ToHost};

use crate::pending_commands::PendingCommands;

/// Built from the link's events.
#[derive(Clone, Debug, Default)]
pub struct Board {
    /// Latest of each of its messages.
    pub status: BoardStatus,
    /// The latest refusal.
    pub refused: Option<(CommandKind, Refusal)>,
    /// Refusals so far.
    pub refusals: u64,
    open: PendingCommands<CommandKind>,
}

/// Kind of command, as far as a viewer's request waits for its result.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CommandKind {
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

impl CommandKind {
    fn of(command: &Command) -> Self {
        match command {
            Command::Configure(_) | Command::Limit(_) => Self::Change,
            Command::Arm { .. } => Self::Drive,
            command if command.is_drive() => Self::Drive,
            Command::Idle | Command::Park => Self::Disarm,
            Command::ClearFault => Self::Clear,
            _ => Self::Other,
        }
    }
}

impl Board {
    /// Applies an event.
    pub fn take(&mut self, event: &Event) {
        match event.kind {
            EventKind::Sent(sequence, ToBoard::Command(command)) => {
                self.open.sent(sequence, CommandKind::of(&command));
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
        // Busy is no answer: the link repeats the command.
        if let (Some(kind), Err(refusal)) = (self.open.acknowledged(sequence), result)
            && refusal != Refusal::Busy
        {
            self.refused = Some((kind, refusal));
            self.refusals += 1;
        }
    }
}
