//! Logs of runs: the messages of a link, recorded, read back, exported, summarised and
//! replayed.
//!
//! ```text
//! link --bytes--> Tap --> queue --> LinkDecoder --events--> Encoder --messages--> run.mcap
//!                                                                                    |
//!                               plot, export, replay <--events-- recording <---------'
//! ```
//!
//! | module             | contents                                                 |
//! |--------------------|----------------------------------------------------------|
//! | [`recorder`]       | writes a log during the run                              |
//! | [`recording`]      | reads a log back, up to its first damage                 |
//! | [`topics`]         | names and schemas of messages                            |
//! | [`message_encoder`] | events as messages for log and viewers                  |
//! | [`proto`]          | those messages; `host/log/proto/armbridge.proto` describes them |
//! | [`clock_sync`]     | mapping of the board's clock to the host's               |
//! | [`raw_link_bytes`] | the link's raw bytes, kept beside the messages           |
//! | [`metadata`]       | run, build, board, parameters and clocks                 |
//! | [`run_info`]       | facts of a run that are needed to interpret its records  |
//! | [`record_values`]  | values of a record, as far as they exist                 |
//! | [`simulation`]     | true states of a simulated arm, and pushes               |
//! | [`csv`]            | ticks as a table                                         |
//! | [`export`]         | ticks in other programs' formats                         |
//! | [`summary`]        | statistics of a run                                      |
//! | [`inspect`]        | contents of a log, and differences of two                |
//! | [`replay`]         | a log's inputs through the board's code                  |
//! | [`event_text`]     | events as text                                           |
//! | [`output_file`]    | files written whole, and never over others               |
//! | [`log_path`]       | the log of a name, or the newest run's                   |
//! | [`text_table`]     | plain tables for a terminal                              |
#![forbid(unsafe_code)]

pub mod clock_sync;
pub mod csv;
mod enum_codes;
mod error;
mod event_messages;
pub mod event_text;
pub mod export;
mod fsync_thread;
pub mod inspect;
mod limits;
pub mod log_path;
mod mcap_file;
mod mcap_records;
pub mod message_encoder;
pub mod metadata;
pub mod output_file;
mod parameters;
mod payload_codec;
pub mod proto;
mod queue;
pub mod raw_link_bytes;
mod reader;
pub mod record_values;
mod recorded_metadata;
pub mod recorder;
pub mod recording;
pub mod replay;
pub mod run_info;
pub mod simulation;
mod snapshots;
mod statistics;
pub mod summary;
mod telemetry;
pub mod text_table;
pub mod time_origin;
pub mod topics;
mod visualization;
mod writer_thread;

pub use csv::CsvWriter;
pub use error::LogError;
