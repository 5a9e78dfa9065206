//! Dialogue of a command that guides a person, at the terminal.

use std::io::{BufRead, IsTerminal};
use std::sync::mpsc::{Receiver, TryRecvError, channel};

use armbridge::board_tasks::TaskError;
use armbridge::board_tasks::calibrate::Guide;
use armbridge_client::stdio;

/// The person at the keyboard, or a script that is piped in.
pub(super) struct Terminal {
    answers: Receiver<String>,
    /// Counts can be written over each other.
    is_live: bool,
}

impl Terminal {
    pub(super) fn new() -> Self {
        let (sender, answers) = channel();
        // Reading waits, and a link must not. The thread ends with the input, or with
        // the program.
        std::thread::spawn(move || {
            for line in std::io::stdin().lock().lines().map_while(Result::ok) {
                if sender.send(line).is_err() {
                    return;
                }
            }
        });
        Self {
            answers,
            is_live: std::io::stderr().is_terminal(),
        }
    }
}

impl Guide for Terminal {
    fn say(&mut self, line: &str) {
        if self.is_live {
            stdio::note_over("");
        }
        stdio::note(line);
    }

    fn show(&mut self, line: &str) {
        if self.is_live {
            stdio::note_over(format_args!("{line} "));
        }
    }

    fn answer(&mut self) -> Result<Option<String>, TaskError> {
        match self.answers.try_recv() {
            Ok(line) => Ok(Some(line)),
            Err(TryRecvError::Empty) => Ok(None),
            Err(TryRecvError::Disconnected) => Err(TaskError::InputEnded),
        }
    }
}
