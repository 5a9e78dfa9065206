//! A log that is compared, and its ticks since an event.

use std::path::Path;

use armbridge_link::message::{Record, Settings};

use super::super::log::{CommandCollector, Head, SentCommand};
use super::DiffError;
use crate::recording::{ReadError, Reader};
use crate::time_origin::{Align, RunTimes};

/// A log, apart from its ticks.
pub(super) struct Source {
    pub(super) head: Head,
    pub(super) commands: Vec<SentCommand>,
    /// Time of the event in s after the first tick.
    event_s: f64,
}

impl Source {
    pub(super) fn read(path: &Path, event: Align) -> Result<Self, DiffError> {
        let (mut commands, mut times) = (CommandCollector::default(), RunTimes::default());
        let head = Head::read(path, |event| {
            commands.take(event);
            if let Some(record) = event.record() {
                times.add(&record);
            }
        })?;
        let no_event = || DiffError::NoEvent {
            path: path.to_path_buf(),
            event,
        };
        Ok(Self {
            event_s: times.event_s(event).ok_or_else(no_event)?,
            commands: commands.into_commands(),
            head,
        })
    }

    pub(super) fn settings(&self) -> Option<&Settings> {
        self.head.settings.as_ref()
    }

    pub(super) fn period_us(&self) -> u32 {
        let settings = self.settings();
        settings.map_or(self.head.facts.period_us, |s| s.setup.period_us)
    }

    /// Its ticks from the event on.
    pub(super) fn ticks(&self) -> Result<impl Iterator<Item = (f64, Record)> + use<>, ReadError> {
        ticks(&self.head.path, self.event_s, 0.0)
    }
}

/// Ticks of a log with their times in s after `zero_s`, which is in s after its first tick: from
/// `from_s` on, and up to a reset of the board.
///
/// # Errors
/// When nothing can be read.
pub fn ticks(
    path: &Path,
    zero_s: f64,
    from_s: f64,
) -> Result<impl Iterator<Item = (f64, Record)> + use<>, ReadError> {
    let (mut times, mut last) = (RunTimes::default(), None);
    let records = Reader::open(path)?.filter_map(|event| event.record());
    let ticks = records.map(move |record| (times.add(&record) - zero_s, record));
    let since = ticks.skip_while(move |(time_s, _)| *time_s < from_s);
    Ok(since.take_while(move |(_, record)| {
        let last = last.replace(record.tick);
        last.is_none_or(|last| record.tick > last)
    }))
}
