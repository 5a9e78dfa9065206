//! Receivers of the records, commands and conclusions of a run.

use armbridge_link::experiment::Conclusion;
use armbridge_link::message::{Command, Record};

/// Receiver of a run's data as it arrives.
pub trait RecordSink {
    /// Receives the record of a tick.
    fn record(&mut self, record: &Record);

    /// Receives a command and its time in µs.
    fn command(&mut self, _at_us: u64, _command: &Command) {}

    /// Receives the conclusion of an experiment.
    fn concluded(&mut self, _conclusion: &Conclusion) {}
}

/// Sink that keeps everything in memory, for short trials and tests.
#[derive(Clone, Debug, Default)]
pub struct AllRecords {
    /// The ticks.
    pub records: Vec<Record>,
    /// The commands and their times in µs.
    pub commands: Vec<(u64, Command)>,
    /// Conclusions of experiments.
    pub conclusions: Vec<Conclusion>,
}

impl RecordSink for AllRecords {
    fn record(&mut self, record: &Record) {
        self.records.push(*record);
    }

    fn command(&mut self, at_us: u64, command: &Command) {
        self.commands.push((at_us, *command));
    }

    fn concluded(&mut self, conclusion: &Conclusion) {
        self.conclusions.push(*conclusion);
    }
}
