//! Ticks of a log as rows: records, with the true states of a simulated arm.

use armbridge_client::event::Event;
use armbridge_client::simulation::{Push, TrueState};
use armbridge_link::message::Record;

use super::{Item, Reader};

/// A tick.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Row {
    /// Its record.
    pub record: Record,
    /// True state of the simulated arm at its start, if the log has it.
    pub truth: Option<TrueState>,
}

impl From<Record> for Row {
    /// A tick of an arm whose true state is not known.
    fn from(record: Record) -> Self {
        Self {
            record,
            truth: None,
        }
    }
}

/// Iterator over the ticks of a log.
#[derive(Debug)]
pub struct Rows {
    reader: Reader,
    state: Option<(u32, TrueState)>,
}

impl Reader {
    /// The ticks that have not been read.
    pub fn rows(mut self) -> Rows {
        self.reads_states = true;
        Rows {
            reader: self,
            state: None,
        }
    }
}

impl Rows {
    /// The log, as far as it has been read.
    pub fn reader(&self) -> &Reader {
        &self.reader
    }

    /// [`Reader::pushes_begun`] of the log.
    pub fn pushes_begun(&mut self, record: &Record) -> &[Push] {
        self.reader.pushes_begun(record)
    }

    /// The next event; of a record with its true state.
    pub fn next_event(&mut self) -> Option<(Event, Option<TrueState>)> {
        loop {
            match self.reader.next_item()? {
                // The state precedes the record of its tick.
                Item::State(tick, state) => self.state = Some((tick, state)),
                Item::Event(event) => {
                    let truth = event.record().and_then(|record| {
                        let (tick, state) = self.state.take()?;
                        (tick == record.tick).then_some(state)
                    });
                    return Some((event, truth));
                }
            }
        }
    }
}

impl Iterator for Rows {
    type Item = Row;

    fn next(&mut self) -> Option<Row> {
        loop {
            let (event, truth) = self.next_event()?;
            if let Some(record) = event.record() {
                return Some(Row { record, truth });
            }
        }
    }
}
