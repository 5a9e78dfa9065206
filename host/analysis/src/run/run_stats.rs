//! What is kept of a run while it goes on: counts, a verdict to be, and for the plots as
//! many ticks as fit, however long it takes.

use std::path::Path;

use armbridge_client::experiment_text;
use armbridge_log::summary::Tally;
use armbridge_log::{CsvWriter, LogError};
use armbridge_shared::link::experiment::Conclusion;
use armbridge_shared::link::message::Record;

use crate::plan_runner::RecordSink;
use crate::scenario::Judge;

/// Ticks for the plots: two minutes at 1 kHz, one tick in two of four, and so on.
const PLOTTED_MAX: usize = 120_000;

/// Everything that a run leaves but its log.
pub(super) struct RunStats {
    pub(super) tally: Tally,
    pub(super) judge: Option<Judge>,
    pub(super) plotted: Thinned,
    /// How experiments ended, in words.
    pub(super) conclusions: Vec<String>,
    csv: Option<CsvWriter>,
    csv_error: Option<LogError>,
}

/// Every so manyth tick.
#[derive(Debug)]
pub(super) struct Thinned {
    pub(super) records: Vec<Record>,
    /// One tick in how many.
    pub(super) every: u64,
    seen: u64,
}

impl Default for Thinned {
    fn default() -> Self {
        Self {
            records: Vec::new(),
            every: 1,
            seen: 0,
        }
    }
}

impl Thinned {
    fn see(&mut self, record: &Record) {
        if self.records.len() >= PLOTTED_MAX {
            let mut is_kept = false;
            self.records.retain(|_| {
                is_kept = !is_kept;
                is_kept
            });
            self.every *= 2;
        }
        if self.seen.is_multiple_of(self.every) {
            self.records.push(*record);
        }
        self.seen += 1;
    }
}

impl RunStats {
    /// An empty one, with a CSV file if that is wanted.
    pub(super) fn new(judge: Option<Judge>, csv: Option<&Path>) -> Result<Self, LogError> {
        Ok(Self {
            tally: Tally::default(),
            judge,
            plotted: Thinned::default(),
            conclusions: Vec::new(),
            csv: csv.map(CsvWriter::create).transpose()?,
            csv_error: None,
        })
    }

    /// Closes the CSV file; what went wrong with it.
    pub(super) fn close(&mut self) -> Option<LogError> {
        let closed = self.csv.take().map_or(Ok(()), CsvWriter::finish);
        self.csv_error.take().or(closed.err())
    }
}

impl RecordSink for RunStats {
    fn record(&mut self, record: &Record) {
        self.tally.see(record);
        self.plotted.see(record);
        if let Some(judge) = &mut self.judge {
            judge.see(record);
        }
        if let Some(csv) = &mut self.csv
            && let Err(error) = csv.record(record)
        {
            // The run goes on, and the arm with it.
            self.csv_error = Some(error);
            self.csv = None;
        }
    }

    fn concluded(&mut self, conclusion: &Conclusion) {
        self.conclusions
            .push(experiment_text::conclusion(conclusion));
        if let Some(judge) = &mut self.judge {
            judge.see_end(conclusion);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plan_runner::{AllRecords, PlanRunner, Script};
    use armbridge_shared::link::message::Setup;

    #[test]
    fn a_long_run_is_thinned_evenly() {
        let mut records = one_record();
        let mut thinned = Thinned::default();
        for tick in 0..(5 * PLOTTED_MAX as u32) {
            records.tick = tick;
            thinned.see(&records);
        }
        assert_eq!(thinned.every, 8);
        assert!(thinned.records.len() <= PLOTTED_MAX);
        let even = thinned
            .records
            .windows(2)
            .all(|two| two[1].tick - two[0].tick == 8);
        assert!(even && thinned.records[0].tick == 0);
    }

    /// The bench's first record.
    fn one_record() -> Record {
        use armbridge_sim::link::{BoardUri, Options, drive};
        use armbridge_sim::plant::{Plant, PlantConfig};
        let bench = armbridge_sim::Bench::new(Plant::new(PlantConfig::default(), 1));
        let script = Script::upright(Setup::default(), 10_000);
        let runner = PlanRunner::keeping(script, AllRecords::default());
        let (runner, result) = drive(&BoardUri::Sim, Options::new(bench), runner);
        result.unwrap();
        runner.records()[0]
    }
}
