//! Who is handed what a run brings, as it comes: nothing is stored on the way.

use armbridge_shared::link::experiment::Conclusion;
use armbridge_shared::link::message::{Command, Record};

/// Keeps of a run what it wants to.
pub trait RecordSink {
    /// A tick, as the board recorded it.
    fn record(&mut self, record: &Record);

    /// A command, given at this time in µs.
    fn command(&mut self, _at_us: u64, _command: &Command) {}

    /// An experiment ended.
    fn concluded(&mut self, _conclusion: &Conclusion) {}
}

/// Everything, in memory: for trials and tests, which are short.
#[derive(Clone, Debug, Default)]
pub struct AllRecords {
    /// The ticks.
    pub records: Vec<Record>,
    /// The commands and when they were given, in µs.
    pub commands: Vec<(u64, Command)>,
    /// How experiments ended.
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
