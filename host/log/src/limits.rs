//! Limits on what a log may hold, so that a damaged or hostile file cannot fill the memory.
//!
//! A length in a file is only a claim. It is compared with these limits, and with the bytes
//! that are there, before memory is reserved for it. Beyond them, memory grows with the ticks
//! and commands that a file truly has, where a reader keeps those.
//!
//! | limit              | longest of the recorder's own                         |
//! |--------------------|-------------------------------------------------------|
//! | [`RECORD_BYTES`]   | an attachment of 32 MiB, all of a full queue; chunks are closed at 1 MiB |
//! | [`SNAPSHOT_BYTES`] | a state of 2 kB                                       |
//! | [`MESSAGE_BYTES`]  | the settings: 4 kB                                    |
//! | [`METADATA_BYTES`] | the settings: 3 kB                                     |
//! | [`METADATA_NAMES`] | 6                                                     |
//! | [`TOPICS`]         | 11                                                    |

/// Longest chunk or attachment that is read: 64 MiB.
pub(super) const RECORD_BYTES: u64 = 64 << 20;

/// Longest snapshot of a replay that is read: commands without an answer are part of it.
pub(super) const SNAPSHOT_BYTES: u64 = 1 << 20;

/// Longest message that is decoded. Two bytes of a list in a message take a hundred in memory.
pub(super) const MESSAGE_BYTES: usize = 256 << 10;

/// Longest record of metadata or of the index that is kept.
pub(super) const METADATA_BYTES: u64 = 64 << 10;

/// Number of names of metadata that are kept.
pub(super) const METADATA_NAMES: usize = 32;

/// Number of topics that are kept.
pub(super) const TOPICS: usize = 256;

/// Number of pushes on a simulated arm that are kept.
pub(super) const PUSHES: usize = 1 << 16;

/// Number of sentences about damage; further ones are counted.
pub(super) const DAMAGE_SENTENCES: usize = 100;

/// Longest text of a file, in characters, that is repeated in a message.
const QUOTE: usize = 40;

/// The beginning of a text in the file, without control characters.
pub(super) fn quote(text: &str) -> String {
    text.chars()
        .take(QUOTE)
        .flat_map(char::escape_debug)
        .collect()
}
