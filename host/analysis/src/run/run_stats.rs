//! Statistics of a run in progress: counts, expectations, and a bounded number of ticks for
//! the plots.

use std::path::Path;

use armbridge_client::experiment_text;
use armbridge_log::recording::Row;
use armbridge_log::simulation::{SimulationEvent, StateQueue};
use armbridge_log::summary::Tally;
use armbridge_log::{CsvWriter, LogError};
use armbridge_shared::link::experiment::Conclusion;
use armbridge_shared::link::message::Record;

use crate::plan_runner::RecordSink;
use crate::scenario::ExpectationMonitor;

/// Largest number of ticks for the plots: all of two minutes at 1 kHz, every second of four
/// minutes, and so on.
const PLOTTED_MAX: usize = 120_000;

/// Results of a run except its log.
pub(super) struct RunStats {
    pub(super) tally: Tally,
    pub(super) judge: Option<ExpectationMonitor>,
    pub(super) plotted: DecimatedRecords,
    /// Texts on the ends of experiments.
    pub(super) conclusions: Vec<String>,
    csv: Option<CsvWriter>,
    /// States of the simulated arm that wait for their record.
    states: StateQueue,
    csv_error: Option<LogError>,
}

/// Records of every `every`th tick.
#[derive(Debug)]
pub(super) struct DecimatedRecords {
    pub(super) records: Vec<Record>,
    /// Decimation factor.
    pub(super) every: u64,
    count: u64,
}

impl Default for DecimatedRecords {
    fn default() -> Self {
        Self {
            records: Vec::new(),
            every: 1,
            count: 0,
        }
    }
}

impl DecimatedRecords {
    fn add(&mut self, record: &Record) {
        if self.records.len() >= PLOTTED_MAX {
            let mut is_kept = false;
            self.records.retain(|_| {
                is_kept = !is_kept;
                is_kept
            });
            self.every *= 2;
        }
        if self.count.is_multiple_of(self.every) {
            self.records.push(*record);
        }
        self.count += 1;
    }
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
            plotted: DecimatedRecords::default(),
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
        self.plotted.add(record);
        if let Some(judge) = &mut self.judge {
            judge.on_record(record);
        }
        if let Some(csv) = &mut self.csv {
            let truth = self.states.take(record.start_us);
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plan_runner::{AllRecords, PlanRunner, Script};
    use armbridge_shared::link::message::Setup;

    #[test]
    fn a_long_run_is_decimated_evenly() {
        let mut records = one_record();
        let mut decimated = DecimatedRecords::default();
        for tick in 0..(5 * PLOTTED_MAX as u32) {
            records.tick = tick;
            decimated.add(&records);
        }
        assert_eq!(decimated.every, 8);
        assert!(decimated.records.len() <= PLOTTED_MAX);
        let even = decimated
            .records
            .windows(2)
            .all(|two| two[1].tick - two[0].tick == 8);
        assert!(even && decimated.records[0].tick == 0);
    }

    /// First record of a simulated run.
    fn one_record() -> Record {
        use armbridge_sim::link::{BoardUri, Options, drive};
        use armbridge_sim::plant::{Plant, PlantConfig};
        let bench = armbridge_sim::Bench::new(Plant::new(PlantConfig::default(), 1));
        let script = Script::upright(Setup::default(), 10_000);
        let runner = PlanRunner::with_sink(script, AllRecords::default());
        let (runner, result) = drive(&BoardUri::Sim, Options::new(bench), runner);
        result.unwrap();
        runner.records()[0]
    }
}
