//! Replay beside a recorder: its state each second, from which a later replay may begin.

use armbridge_client::event::Event;

use super::{Changes, Replayer};

/// Board time between two snapshots, in µs.
const SNAPSHOT_US: u64 = 1_000_000;

/// Replay of the events as they are recorded.
#[derive(Default)]
pub(crate) struct LiveReplay {
    replayer: Option<Replayer>,
    /// Second of the board's clock of the latest snapshot.
    second: u64,
}

impl LiveReplay {
    /// Repeats an event. Returns the state behind it, once in each second of ticks as long as it is
    /// known: the start of its last tick in µs, little endian, and the state.
    pub(crate) fn take(&mut self, event: &Event) -> Option<Vec<u8>> {
        if self.replayer.is_none() {
            self.replayer = Replayer::new(Changes::default()).ok();
        }
        let replayer = self.replayer.as_mut()?;
        // Without changed settings no event is an error.
        replayer.take(event).ok()?;
        let start_us = replayer.known_until_us()?;
        let second = start_us / SNAPSHOT_US;
        if second == self.second {
            return None;
        }
        self.second = second;
        let mut bytes = start_us.to_le_bytes().to_vec();
        bytes.extend(replayer.state()?);
        Some(bytes)
    }
}
