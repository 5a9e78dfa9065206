//! Contents of a log, as text for a terminal.

use std::collections::BTreeMap;
use std::fmt::{Result, Write};

use super::{FaultInfo, Gap, Info};
use crate::text_table::{self, WIDTH};

/// Width of the left column.
const NAME: usize = 11;

/// Longest text of the metadata that is shown.
const VALUE_MAX: usize = 88;

/// Begin of a line of the right column that continues the one before.
const INDENT: &str = "  ";

/// Width of the tick after which a command came.
const AFTER: usize = 14;

/// Width of the right column, at which lists are broken.
const TEXT: usize = WIDTH - NAME - 1;

impl Info {
    /// As text, ending in a line feed.
    pub fn table(&self) -> String {
        let mut text = String::new();
        // Writing to a string cannot fail.
        let _ = self.write(&mut text);
        text
    }

    fn write(&self, out: &mut String) -> Result {
        let rule = "─".repeat(WIDTH);
        let megabytes = self.size_bytes as f64 / 1e6;
        writeln!(out, "{} · {megabytes:.1} MB\n{rule}", self.path)?;
        let complete = ["nothing: the log is whole".to_owned()];
        let damage = if self.damage.is_empty() {
            &complete
        } else {
            self.damage.as_slice()
        };
        rows(out, "missing", damage.iter().cloned())?;
        self.write_run(out)?;
        writeln!(out, "{rule}")?;
        self.write_ticks(out)?;
        writeln!(out, "{rule}")?;
        self.write_commands(out)?;
        self.write_settings(out)?;
        writeln!(out, "{rule}")?;
        self.write_link(out)
    }

    fn write_run(&self, out: &mut String) -> Result {
        let run = format!("{} · {}", self.run.name, self.run.describe());
        row(out, "run", &run)?;
        row(out, "program", &format!("armbridge {}", self.run.version))?;
        for (group, entries) in &self.metadata {
            // The facts are shown above, the settings below, by name.
            let entries = entries
                .iter()
                .filter(|(_, value)| value.chars().count() <= VALUE_MAX);
            let texts = entries.map(|(key, value)| format!("{key} {value}"));
            if !matches!(group.as_str(), "run" | "parameters" | "clock" | "end") {
                list(out, group, texts)?;
            }
        }
        Ok(())
    }

    fn write_ticks(&self, out: &mut String) -> Result {
        let ticks = match self.first_and_last_tick {
            Some([first, last]) => {
                format!(
                    "{} in {:.3} s, {first} to {last}",
                    self.ticks, self.duration_s
                )
            }
            None => "none".to_owned(),
        };
        row(out, "ticks", &ticks)?;
        if self.missing_ticks == 0 {
            row(out, "gaps", "none")?;
        } else {
            let places = self.gap_count;
            let total = format!(
                "{} ticks have no record, in {places} places",
                self.missing_ticks
            );
            let more = places - self.gaps.len();
            let more = (more > 0).then(|| format!("and {more} more"));
            let gaps = self.gaps.iter().map(gap);
            rows(out, "gaps", std::iter::once(total).chain(gaps).chain(more))?;
        }
        if self.skipped_ticks > 0 {
            let skipped = format!("{} ticks by the board, being late", self.skipped_ticks);
            row(out, "skipped", &skipped)?;
        }
        let modes = self.modes_s.iter();
        list(
            out,
            "modes",
            modes.map(|(mode, s)| format!("{mode} {s:.3} s")),
        )?;
        if !self.missing_samples.is_empty() {
            list(out, "no sample", counts(&self.missing_samples))?;
        }
        if self.faults.is_empty() {
            row(out, "faults", "none")?;
        } else {
            rows(out, "faults", self.faults.iter().map(fault))?;
        }
        let resets = self
            .resets_s
            .iter()
            .map(|s| format!("at {s:.3} s, the board was reset"));
        rows(out, "resets", resets)
    }

    fn write_commands(&self, out: &mut String) -> Result {
        if self.commands.is_empty() {
            return row(out, "commands", "none");
        }
        let by_name = self
            .commands
            .iter()
            .map(|(name, [given, refused])| match refused {
                0 => format!("{name} {given}"),
                _ => format!("{name} {given} ({refused} refused)"),
            });
        list(out, "commands", by_name)?;
        let given: u64 = self.commands.values().map(|[given, _]| given).sum();
        let more = given - self.first_commands.len() as u64;
        let more = (more > 0).then(|| format!("and {more} more"));
        let texts = self.first_commands.iter().map(|command| {
            let after = command.after_tick;
            let after = after.map_or("before any".to_owned(), |tick| format!("after {tick}"));
            let refused = command.refused.as_ref();
            let refused = refused.map_or_else(String::new, |why| format!(": refused, {why}"));
            format!("{after:<AFTER$}{}{refused}", command.command)
        });
        let indent = " ".repeat(AFTER);
        texts
            .chain(more)
            .try_for_each(|text| hanging(out, "", &text, &indent))
    }

    fn write_settings(&self, out: &mut String) -> Result {
        let Some(settings) = &self.settings else {
            return row(out, "settings", "not in the log");
        };
        if settings.is_empty() {
            return row(out, "settings", "the defaults");
        }
        let texts = settings.iter().flat_map(|differing| {
            let [default, value] = [0, 1].map(|at| differing.show(at));
            let value = format!("{} = {value}", differing.key);
            let default = format!("default {default}");
            text_table::wrap([value, default], ", ", TEXT, INDENT)
        });
        rows(out, "settings", texts)
    }

    fn write_link(&self, out: &mut String) -> Result {
        if let Some(clocks) = &self.clocks {
            let text = format!(
                "host {:+.6} s ahead of the board, drifting {:+.2} ppm; the fastest record of \
                 a second comes {:.1} us late at the median, {:.1} us at worst",
                clocks.offset_s, clocks.drift_ppm, clocks.residual_us, clocks.residual_most_us
            );
            hanging(out, "clocks", &text, "")?;
        }
        let link = format!(
            "broke {} times, {} frames lost, {} garbled",
            self.partings, self.lost_frames, self.garbled_frames
        );
        row(out, "link", &link)?;
        list(out, "messages", counts(&self.messages))?;
        let topics = self.topics.iter();
        rows(
            out,
            "topics",
            topics.map(|(topic, count)| format!("{count:>9} {topic}")),
        )
    }
}

fn gap(gap: &Gap) -> String {
    let Gap {
        after_tick,
        after_s,
        ticks,
        dropped,
    } = gap;
    let lost = ticks - dropped;
    let why = match (dropped, lost) {
        (0, _) => "lost on the link or in the log".to_owned(),
        (_, 0) => "dropped by the board, because the host did not fetch them in time".to_owned(),
        _ => format!("{dropped} dropped by the board, {lost} lost on the link or in the log"),
    };
    format!("{ticks} after tick {after_tick}, at {after_s:.3} s: {why}")
}

fn fault(fault: &FaultInfo) -> String {
    let FaultInfo {
        at_s,
        tick,
        fault,
        in_words,
        ..
    } = fault;
    let cause = in_words.as_ref();
    let cause = cause.map_or_else(String::new, |words| format!(": {words}"));
    format!("{fault} at {at_s:.3} s, tick {tick}{cause}")
}

fn counts<'a>(counts: &'a BTreeMap<&'static str, u64>) -> impl Iterator<Item = String> + 'a {
    counts.iter().map(|(name, count)| format!("{name} {count}"))
}

fn row(out: &mut String, name: &str, text: &str) -> Result {
    hanging(out, name, text, INDENT)
}

/// A row whose lines after the first begin with `indent`.
fn hanging(out: &mut String, name: &str, text: &str, indent: &str) -> Result {
    let mut name = name;
    // A line feed in a text of the file begins no line of its own.
    let words = text.split([' ', '\n']);
    for line in text_table::wrap(words, " ", TEXT, indent) {
        writeln!(out, "{name:<NAME$} {line}")?;
        name = "";
    }
    Ok(())
}

/// Items one below the other, the name beside the first.
fn rows(out: &mut String, name: &str, texts: impl IntoIterator<Item = String>) -> Result {
    let mut name = name;
    for text in texts {
        row(out, name, &text)?;
        name = "";
    }
    Ok(())
}

/// Items on a line, broken between them.
fn list(out: &mut String, name: &str, items: impl Iterator<Item = String>) -> Result {
    rows(out, name, text_table::wrap(items, ", ", TEXT, ""))
}
