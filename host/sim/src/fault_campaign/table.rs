//! Report of a campaign as text for a terminal.

use std::fmt::{Result, Write};

use super::report::{Failure, Report, Row};

/// Failing cases that are listed; the rest is counted.
const LISTED_MAX: usize = 20;

/// The report as text, ending in a line feed.
pub fn table(report: &Report) -> String {
    let mut text = String::new();
    // Writing to a string cannot fail.
    let _ = write_table(&mut text, report);
    text
}

fn write_table(out: &mut String, report: &Report) -> Result {
    writeln!(
        out,
        "{:<18}{:>6}{:>10}{:>10}{:>10}{:>8}  faults",
        "fault", "cases", "expected", "detected", "at worst", "off"
    )?;
    writeln!(
        out,
        "{:<18}{:>6}{:>10}{:>10}{:>10}{:>8}",
        "", "", "%", "ms", "ms", "ms"
    )?;
    let rows = report.singles.iter();
    for row in rows.chain([&report.all_singles, &report.all_pairs]) {
        write_row(out, row)?;
    }
    writeln!(out, "{} faults cleared", report.cleared)?;
    write_failures(out, "failed", &report.failures)?;
    write_failures(out, "unexpected", &report.unexpected)
}

fn write_row(out: &mut String, row: &Row) -> Result {
    let share = 1e2 * row.as_expected as f64 / row.cases.max(1) as f64;
    write!(out, "{:<18}{:>6}{share:>10.1}", row.name, row.cases)?;
    for ms in [row.median_detected_ms, row.worst_detected_ms] {
        match ms {
            Some(ms) => write!(out, "{ms:>10.1}")?,
            None => write!(out, "{:>10}", "-")?,
        }
    }
    write!(out, "{:>8.1} ", row.worst_stop_ms)?;
    for (name, count) in &row.faults {
        write!(out, " {name} {count}")?;
    }
    writeln!(out)
}

fn write_failures(out: &mut String, label: &str, failures: &[Failure]) -> Result {
    for Failure { seed, kinds, why } in failures.iter().take(LISTED_MAX) {
        let kinds: Vec<&str> = kinds.iter().map(|kind| kind.name()).collect();
        writeln!(
            out,
            "{label}: seed {seed}, {}: {}",
            kinds.join(" and "),
            why.join("; ")
        )?;
    }
    if failures.len() > LISTED_MAX {
        writeln!(out, "{label}: {} more", failures.len() - LISTED_MAX)?;
    }
    Ok(())
}
