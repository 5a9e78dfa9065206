//! Ticks of a log as rows: records, with the true states of a simulated arm.

use armbridge_client::simulation::TrueState;
use armbridge_shared::link::message::Record;

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

impl Iterator for Rows {
    type Item = Row;

    fn next(&mut self) -> Option<Row> {
        loop {
            match self.reader.next_item()? {
                // The state precedes the record of its tick.
                Item::State(tick, state) => self.state = Some((tick, state)),
                Item::Event(event) => {
                    if let Some(record) = event.record() {
                        let state = self.state.take().filter(|(tick, _)| *tick == record.tick);
                        return Some(Row {
                            record,
                            truth: state.map(|(_, state)| state),
                        });
                    }
                }
            }
        }
    }
}
