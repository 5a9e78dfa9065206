//! Statistics of a run in progress: counts and expectations.

use std::path::Path;

use armbridge_client::experiment_text;
use armbridge_link::experiment::Conclusion;
use armbridge_link::message::Record;
use armbridge_log::recording::Row;
use armbridge_log::simulation::{SimulationEvent, StateQueue};
use armbridge_log::summary::Tally;
use armbridge_log::{CsvWriter, LogError};

use crate::plan_runner::RecordSink;
use crate::scenario::ExpectationMonitor;

/// Results of a run except its log.
pub(super) struct RunStats {
    pub(super) tally: Tally,
    pub(super) judge: Option<ExpectationMonitor>,
    /// Texts on the ends of experiments.
    pub(super) conclusions: Vec<String>,
    csv: Option<CsvWriter>,
    /// States of the simulated arm that wait for their record.
    states: StateQueue,
    csv_error: Option<LogError>,
}

impl RunStats {
    /// Empty statistics, with a CSV file if `csv` is given.
    pub(super) fn new(
        judge: Option<ExpectationMonitor>,
        csv: Option<&Path>,
    ) -> Result<Self, LogError> {
        Ok(Self {
            tally: Tally::default(),
            judge,
            conclusions: Vec::new(),
            csv: csv.map(|path| CsvWriter::create(path, true)).transpose()?,
            states: StateQueue::default(),
            csv_error: None,
        })
    }

    /// Whether the states of a simulated arm are wanted.
    pub(super) fn takes_true_states(&self) -> bool {
        self.csv.is_some()
    }

    /// Takes an event of the simulation behind the link.
    pub(super) fn simulated(&mut self, event: &SimulationEvent) {
        match event {
            SimulationEvent::State(state) if self.csv.is_some() => self.states.push(*state),
            SimulationEvent::State(_) => {}
            SimulationEvent::Push(push) => self.tally.push(push),
        }
    }

    /// Closes the CSV file; returns its first error.
    pub(super) fn close(&mut self) -> Option<LogError> {
        let closed = self
            .csv
            .take()
            .map_or(Ok(()), |csv| csv.finish().map(|_| ()));
        self.csv_error.take().or(closed.err())
    }
}

impl RecordSink for RunStats {
    fn record(&mut self, record: &Record) {
        self.tally.add(record);
        if let Some(judge) = &mut self.judge {
            judge.on_record(record);
        }
        if let Some(csv) = &mut self.csv {
            let truth = self.states.take(record.input.start_us);
            let row = Row {
                record: *record,
                truth,
            };
            if let Err(error) = csv.row(&row) {
                // The run continues without the file.
                self.csv_error = Some(error);
                self.csv = None;
            }
        }
    }

    fn concluded(&mut self, conclusion: &Conclusion) {
        self.conclusions
            .push(experiment_text::conclusion(conclusion));
        if let Some(judge) = &mut self.judge {
            judge.on_experiment_end(conclusion);
        }
    }
}
