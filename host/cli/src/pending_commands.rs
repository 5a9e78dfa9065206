//! Commands seen on the link until the board acknowledges them, for observers of its events.
//!
//! The link's own end is the client's `CommandLink`; an observer sees each repetition of a
//! command under a sequence number of its own, and the acknowledgement of one of them.

use std::collections::VecDeque;

/// Commands that are kept; the oldest go first.
const COUNT_MAX: usize = 64;

/// Commands without an acknowledgement, each with what the observer keeps of it.
#[derive(Clone, Debug)]
pub(crate) struct PendingCommands<T>(VecDeque<(u16, T)>);

impl<T> Default for PendingCommands<T> {
    fn default() -> Self {
        Self(VecDeque::new())
    }
}

impl<T> PendingCommands<T> {
    /// A command was sent in the frame `sequence`.
    pub(crate) fn sent(&mut self, sequence: u16, entry: T) {
        if self.0.len() == COUNT_MAX {
            self.0.pop_front();
        }
        self.0.push_back((sequence, entry));
    }

    /// The entry of the command in the frame `sequence`; those sent before it go with it.
    pub(crate) fn acknowledged(&mut self, sequence: u16) -> Option<T> {
        let at = self.0.iter().position(|(sent, _)| *sent == sequence)?;
        let (_, entry) = self.0.drain(..=at).next_back()?;
        Some(entry)
    }

    /// The connection broke: no acknowledgement comes any more.
    pub(crate) fn clear(&mut self) {
        self.0.clear();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_acknowledgement_settles_the_commands_before_it() {
        let mut open = PendingCommands::default();
        for (sequence, name) in [(65_535, "arm"), (0, "arm"), (1, "regulate")] {
            open.sent(sequence, name);
        }
        assert_eq!(open.acknowledged(7), None);
        assert_eq!(open.acknowledged(0), Some("arm"));
        assert_eq!(open.acknowledged(65_535), None);
        assert_eq!(open.acknowledged(1), Some("regulate"));
    }
}
