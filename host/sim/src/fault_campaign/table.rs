//! Report of a campaign as text for a terminal, at most 120 columns wide.

use std::fmt::{Result, Write};

use super::report::{Failure, Report, Row};

/// Failing cases that are listed; the rest is counted.
const LISTED_MAX: usize = 20;
/// Width of the terminal, and of the columns before the names of the faults.
const WIDTH: usize = 120;
const COLUMNS: usize = 79;

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
        "{} cases: {} failed, and {} failed that have a kind that boards do not detect yet\n",
        report.all_singles.cases + report.all_pairs.cases,
        report.failures.len(),
        report.unguarded_failed
    )?;
    let kinds = report.singles.iter().chain([
        &report.guarded_singles,
        &report.all_singles,
        &report.all_pairs,
    ]);
    write_rows(out, "fault", kinds, true)?;
    writeln!(out)?;
    write_rows(out, "activity", report.activities.iter(), false)?;
    writeln!(out)?;
    write_rows(out, "set-up", report.set_ups.iter(), false)?;
    writeln!(out)?;
    writeln!(out, "{} faults cleared", report.cleared)?;
    let wrong = report.all_singles.cases - report.all_singles.as_expected;
    writeln!(
        out,
        "{wrong} wrong names, {} of them of kinds that boards detect",
        report.guarded_singles.cases - report.guarded_singles.as_expected
    )?;
    write_failures(out, "failed", &report.failures)?;
    write_failures(out, "unexpected", &report.unexpected)?;
    write_failures(out, "not detected yet", &report.unguarded)
}

fn write_rows<'a>(
    out: &mut String,
    title: &str,
    rows: impl Iterator<Item = &'a Row>,
    has_faults: bool,
) -> Result {
    let names = if has_faults { "  faults" } else { "" };
    writeln!(
        out,
        "{title:<18}{:>6}{:>7}{:>7}{:>9}{:>9}{:>7}{:>8}{:>7}{names}",
        "cases", "named", "failed", "detected", "at worst", "off", "contact", "far"
    )?;
    writeln!(
        out,
        "{:<18}{:>6}{:>7}{:>7}{:>9}{:>9}{:>7}{:>8}{:>7}",
        "", "", "%", "", "ms", "ms", "ms", "rad/s", "ms"
    )?;
    for row in rows {
        write_row(out, row, has_faults)?;
    }
    Ok(())
}

fn write_row(out: &mut String, row: &Row, has_faults: bool) -> Result {
    let share = 1e2 * row.as_expected as f64 / row.cases.max(1) as f64;
    write!(
        out,
        "{:<18}{:>6}{share:>7.1}{:>7}",
        row.name, row.cases, row.failed
    )?;
    for ms in [row.median_detected_ms, row.worst_detected_ms] {
        match ms {
            Some(ms) => write!(out, "{ms:>9.1}")?,
            None => write!(out, "{:>9}", "-")?,
        }
    }
    write!(
        out,
        "{:>7.1}{:>8.1}{:>7.0} ",
        row.worst_stop_ms, row.worst_contact_rad_s, row.worst_far_ms
    )?;
    if has_faults {
        write_faults(out, row)?;
    }
    writeln!(out)
}

/// The faults, most frequent first, in lines of the terminal's width.
fn write_faults(out: &mut String, row: &Row) -> Result {
    let mut faults: Vec<_> = row.faults.iter().collect();
    faults.sort_by_key(|(_, count)| std::cmp::Reverse(**count));
    let mut column = COLUMNS;
    for (name, count) in faults {
        let text = format!(" {name} {count}");
        if column + text.len() > WIDTH && column > COLUMNS {
            write!(out, "\n{:COLUMNS$}", "")?;
            column = COLUMNS;
        }
        column += text.len();
        out.write_str(&text)?;
    }
    Ok(())
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
