//! Report of a replay.

use std::fmt::{self, Write as _};

use serde::Serialize;

use super::compare::Difference;
use super::loss::Loss;
use super::what_if::WhatIf;
use crate::text_table;

/// Result of a replay.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Verdict {
    /// Every compared output is equal to the last bit.
    Equal,
    /// At least one differs.
    Differs,
    /// Nothing could be compared.
    Nothing,
}

/// Ticks that were not compared, for one reason.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Skipped {
    /// The reason, as text.
    pub reason: &'static str,
    /// Ticks that were recorded and not compared.
    pub ticks: u64,
    /// Ticks without a record.
    pub missing: u64,
    /// Number of the first.
    pub first_tick: u32,
}

/// Report of a replay.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Report {
    /// Result.
    pub verdict: Verdict,
    /// Records in the log.
    pub records: u64,
    /// Ticks that were compared.
    pub compared: u64,
    /// Those that differ.
    pub differing: u64,
    /// Replies to commands that were compared.
    pub answers: u64,
    /// Those that differ.
    pub answers_differing: u64,
    /// The first difference.
    pub first: Option<Difference>,
    /// Ticks that were not compared.
    pub skipped: Vec<Skipped>,
    /// Commands that the board never answered.
    pub unanswered: u64,
    /// Time span of the records, in s.
    pub span_s: f64,
    /// Other settings, and their effect.
    pub what_if: Option<WhatIf>,
}

/// Counts for the report.
#[derive(Debug, Default)]
pub(super) struct Tally {
    pub(super) records: u64,
    pub(super) compared: u64,
    pub(super) differing: u64,
    pub(super) answers: u64,
    pub(super) answers_differing: u64,
    pub(super) first: Option<Difference>,
    skipped: Vec<Skipped>,
    pub(super) span_us: u64,
}

impl Tally {
    /// Marks missing inputs from this tick on, after ticks without a record.
    pub(super) fn lose(&mut self, reason: Loss, tick: u32, missing: u64) {
        self.skipped_for(reason, tick).missing += missing;
    }

    /// A tick is not compared.
    pub(super) fn skip(&mut self, reason: Loss, tick: u32) {
        self.skipped_for(reason, tick).ticks += 1;
    }

    fn skipped_for(&mut self, reason: Loss, tick: u32) -> &mut Skipped {
        let reason = reason.text();
        let at = self
            .skipped
            .iter()
            .position(|skipped| skipped.reason == reason);
        let at = at.unwrap_or_else(|| {
            self.skipped.push(Skipped {
                reason,
                ticks: 0,
                missing: 0,
                first_tick: tick,
            });
            self.skipped.len() - 1
        });
        &mut self.skipped[at]
    }

    pub(super) fn differ(&mut self, difference: impl FnOnce() -> Option<Difference>) {
        if self.first.is_none() {
            self.first = difference();
        }
    }

    pub(super) fn report(self, unanswered: u64, what_if: Option<WhatIf>) -> Report {
        let verdict = if self.compared == 0 {
            Verdict::Nothing
        } else if self.differing + self.answers_differing == 0 {
            Verdict::Equal
        } else {
            Verdict::Differs
        };
        Report {
            verdict,
            records: self.records,
            compared: self.compared,
            differing: self.differing,
            answers: self.answers,
            answers_differing: self.answers_differing,
            first: self.first,
            skipped: self.skipped,
            unanswered,
            span_s: self.span_us as f64 * 1e-6,
            what_if,
        }
    }
}

impl Report {
    /// As text for a terminal.
    pub fn text(&self) -> String {
        let mut text = String::new();
        // Writing to a string cannot fail.
        let _ = self.write(&mut text);
        text_table::fold(&text, "  ")
    }

    fn write(&self, out: &mut String) -> fmt::Result {
        match &self.what_if {
            Some(what_if) => writeln!(out, "{what_if}")?,
            None => self.write_verdict(out)?,
        }
        for skipped in &self.skipped {
            let Skipped {
                reason,
                ticks,
                missing,
                first_tick,
                ..
            } = skipped;
            write!(out, "not compared: {ticks} ticks from tick {first_tick} on")?;
            if *missing > 0 {
                write!(out, ", {missing} without a record")?;
            }
            writeln!(out, ": {reason}")?;
        }
        if self.unanswered > 0 {
            let count = self.unanswered;
            writeln!(out, "never answered: {count} commands")?;
        }
        Ok(())
    }

    fn write_verdict(&self, out: &mut String) -> fmt::Result {
        let Self {
            compared, answers, ..
        } = self;
        match (self.verdict, &self.first) {
            (Verdict::Nothing, _) => writeln!(out, "nothing to compare"),
            (Verdict::Equal, _) | (Verdict::Differs, None) => writeln!(
                out,
                "equal: {compared} ticks and {answers} answers to commands, bit for bit"
            ),
            (Verdict::Differs, Some(first)) => {
                let (ticks, answers_differing) = (self.differing, self.answers_differing);
                writeln!(
                    out,
                    "differs: {ticks} of {compared} ticks, {answers_differing} of {answers} answers to commands"
                )?;
                writeln!(out, "first: {first}")
            }
        }
    }
}
