//! Log for inspection: its ticks, commands, and other messages.
//!
//! The log is read event by event, and only ticks and commands stay in memory: 0.5 GB for
//! an hour at 1 kHz.

use std::collections::BTreeMap;
use std::io;
use std::path::{Path, PathBuf};

use armbridge_client::event::{Event, EventKind};
use armbridge_client::simulation::Push;
use armbridge_link::message::{Command, Moment, Record, Refusal, Settings, ToBoard, ToHost};
use mcap::records::op;

use super::settings;
use crate::export::About;
use crate::limits::{METADATA_BYTES, TOPICS};
use crate::mcap_records::{Next, Records, parse};
use crate::recording::{ReadError, Reader, Rows};
use crate::run_info::RunFacts;

/// Contents of a log for comparison and plots.
#[derive(Clone, Debug)]
pub struct Log {
    /// Metadata.
    pub head: Head,
    /// The ticks, in order of arrival.
    pub records: Vec<Record>,
    /// Commands of the host.
    pub commands: Vec<SentCommand>,
    /// Pushes on a simulated arm, in the order of their start, on the board's clock.
    pub pushes: Vec<Push>,
}

/// Metadata of a log.
#[derive(Clone, Debug)]
pub struct Head {
    /// Path of the log.
    pub path: PathBuf,
    /// Facts of the run, with the settings.
    pub facts: RunFacts,
    /// Settings in force when the motors were first driven, or at the end if they never were;
    /// none if the log has none.
    pub settings: Option<Settings>,
    /// Damage of the file, each in one sentence; empty for an intact one.
    pub damage: Vec<String>,
    /// Metadata by name and key.
    pub metadata: BTreeMap<String, BTreeMap<String, String>>,
    /// It has true states of a simulated arm.
    pub has_true_states: bool,
}

/// A command, with all its repetitions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SentCommand {
    /// Sequence number of the last frame that carried it.
    pub sequence: u16,
    /// The last tick that was received before its first frame; none before
    /// the first.
    pub tick: Option<u32>,
    /// The command.
    pub command: Command,
    /// Its reply, if it is known.
    pub result: Option<Result<(), Refusal>>,
    /// Moment at which the tick accepted it, if it did.
    pub moment: Option<Moment>,
}

/// Commands among which that of an acknowledgement is sought: more are never unanswered, and a
/// log may be made of acknowledgements that belong to none.
const UNANSWERED_MAX: usize = 256;

/// Collects commands from events.
#[derive(Clone, Debug, Default)]
pub(crate) struct CommandCollector {
    all: Vec<SentCommand>,
    tick: Option<u32>,
}

impl CommandCollector {
    /// Processes an event.
    pub(crate) fn take(&mut self, event: &Event) {
        match event.kind {
            EventKind::Sent(sequence, ToBoard::Command(command)) => self.add(sequence, command),
            EventKind::Received(_, ToHost::Record(record)) => self.tick = Some(record.tick),
            EventKind::Received(
                _,
                ToHost::Ack {
                    sequence,
                    result,
                    moment,
                },
            ) => {
                let mut commands = self.all.iter_mut().rev().take(UNANSWERED_MAX);
                if let Some(sent) = commands.find(|sent| sent.sequence == sequence) {
                    sent.result = Some(result);
                    sent.moment = moment;
                }
            }
            EventKind::Sent(..)
            | EventKind::Received(..)
            | EventKind::Lost(..)
            | EventKind::Damaged(..)
            | EventKind::Disconnected => {}
        }
    }

    /// Adds a command; its repetitions until the acknowledgement are one entry.
    fn add(&mut self, sequence: u16, command: Command) {
        match self.all.last_mut() {
            Some(last)
                if last.command == command
                    && matches!(
                        last.result,
                        None | Some(Err(Refusal::Busy | Refusal::EncoderUnknown { .. }))
                    ) =>
            {
                last.sequence = sequence;
            }
            _ => self.all.push(SentCommand {
                sequence,
                tick: self.tick,
                command,
                result: None,
                moment: None,
            }),
        }
    }

    /// All commands, in order.
    pub(crate) fn into_commands(self) -> Vec<SentCommand> {
        self.all
    }
}

impl Log {
    /// Reads a log up to its first damage.
    ///
    /// # Errors
    /// When nothing can be read.
    pub fn load(path: &Path) -> Result<Self, ReadError> {
        let (mut commands, mut records) = (CommandCollector::default(), Vec::new());
        let (head, pushes) = Head::read_with_pushes(path, |event| {
            commands.take(event);
            records.extend(event.record());
        })?;
        Ok(Self {
            head,
            records,
            commands: commands.into_commands(),
            pushes,
        })
    }
}

impl Head {
    /// Reads a log up to its first damage, and passes every event to `on_event`.
    ///
    /// # Errors
    /// When nothing can be read.
    pub fn read(path: &Path, on_event: impl FnMut(&Event)) -> Result<Self, ReadError> {
        Ok(Self::read_with_pushes(path, on_event)?.0)
    }

    fn read_with_pushes(
        path: &Path,
        mut on_event: impl FnMut(&Event),
    ) -> Result<(Self, Vec<Push>), ReadError> {
        let mut reader = Reader::open(path)?;
        reader.by_ref().for_each(|event| on_event(&event));
        let head = Self {
            path: path.to_path_buf(),
            facts: reader.facts().clone(),
            settings: reader.settings().copied(),
            damage: reader.damage().to_vec(),
            metadata: reader.metadata().clone(),
            has_true_states: reader.has_true_states(),
        };
        Ok((head, reader.pushes().to_vec()))
    }

    /// Description for an exported file.
    pub fn about(&self) -> About<'_> {
        About {
            facts: &self.facts,
            settings: self.settings.as_ref().map_or_else(Vec::new, settings::list),
            damage: &self.damage,
            has_true_states: self.has_true_states,
        }
    }
}

/// Iterator over the ticks of a log.
///
/// # Errors
/// When nothing can be read.
pub fn rows(path: &Path) -> Result<Rows, ReadError> {
    Ok(Reader::open(path)?.rows())
}

/// Topics of a log and their message counts, by the index at its end; empty
/// if it has none.
pub fn topics(path: &Path) -> BTreeMap<String, u64> {
    let index = Records::open(path).and_then(|records| records.map(index).transpose());
    index.ok().flatten().flatten().unwrap_or_default()
}

/// Reads the index; `None` if it is missing or not complete.
fn index(mut records: Records) -> io::Result<Option<BTreeMap<String, u64>>> {
    let (mut names, mut counts) = (BTreeMap::new(), BTreeMap::new());
    let (mut body, mut is_index) = (Vec::new(), false);
    while let Next::Record(opcode) = records.next()? {
        match opcode {
            op::DATA_END => is_index = true,
            op::FOOTER => {
                let count = |(id, name)| (name, counts.get(&id).copied().unwrap_or(0));
                return Ok(is_index.then(|| names.into_iter().map(count).collect()));
            }
            op::CHANNEL | op::STATISTICS if is_index => {
                if records.read(METADATA_BYTES, &mut body)?.is_err() {
                    continue;
                }
                match parse(opcode, &body) {
                    Some(mcap::records::Record::Channel(channel)) if names.len() < TOPICS => {
                        names.insert(channel.id, channel.topic);
                    }
                    Some(mcap::records::Record::Statistics(statistics)) => {
                        counts = statistics.channel_message_counts;
                    }
                    _ => {}
                }
            }
            _ => {}
        }
    }
    Ok(None)
}
