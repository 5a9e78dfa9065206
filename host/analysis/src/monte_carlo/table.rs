//! Text table of outcomes: one line per seed, then the worst and the mean.

use std::fmt::{Result, Write};

use super::{Joints, Outcome};

/// Column of the table: heading, decimals, and value of the worse joint. An arm that never
/// settles is worse than any that does.
type Column = (&'static str, usize, fn(&Outcome) -> Option<f64>);

const COLUMNS: [Column; 10] = [
    ("settled", 3, |o| {
        Some(o.settling_time_s.unwrap_or(f64::INFINITY))
    }),
    ("mean", 2, |o| Some(worse(o.mean_error_mrad))),
    ("rms", 2, |o| Some(worse(o.rms_error_mrad))),
    ("p-p", 2, |o| Some(worse(o.peak_to_peak_mrad))),
    ("moving", 2, |o| o.tracking_rms_mrad.map(worse)),
    ("torque", 4, |o| Some(worse(o.torque_rms_nm))),
    ("peak", 3, |o| Some(worse(o.torque_peak_nm))),
    ("speed", 4, |o| Some(worse(o.speed_error_rms_rad_s))),
    ("clamped", 2, |o| Some(1e2 * o.saturated_share)),
    ("missing", 0, |o| Some(o.missing_samples as f64)),
];
const UNITS: [&str; 10] = [
    "s", "mrad", "mrad", "mrad", "mrad", "N m", "N m", "rad/s", "%", "samples",
];
const WIDTH: usize = 8;

/// Table of outcomes, ending in a line feed, with the values of the worse joint.
pub fn table(outcomes: &[Outcome]) -> String {
    let mut text = String::new();
    // Writing to a string cannot fail.
    let _ = write_table(&mut text, outcomes);
    text
}

fn write_table(out: &mut String, outcomes: &[Outcome]) -> Result {
    let pushed = outcomes.iter().any(|o| o.recovery_time_s.is_some());
    write_words(out, "seed", COLUMNS.map(|(name, ..)| name))?;
    writeln!(out, "{}", if pushed { "    back" } else { "" })?;
    write_words(out, "", UNITS)?;
    writeln!(out, "{}", if pushed { "       s" } else { "" })?;
    for outcome in outcomes {
        write!(out, "{:<6}", outcome.seed)?;
        for (_, digits, value) in COLUMNS {
            write_number(out, value(outcome), digits)?;
        }
        if pushed {
            write_number(out, outcome.recovery_time_s.or(Some(f64::INFINITY)), 3)?;
        }
        if let Some(fault) = outcome.fault {
            write!(out, "  fault: {fault}")?;
        }
        writeln!(out)?;
    }
    write_all(out, "worst", outcomes, pushed, |values| {
        values.iter().copied().fold(0.0, f64::max)
    })?;
    write_all(out, "mean", outcomes, pushed, |values| {
        values.iter().sum::<f64>() / values.len() as f64
    })
}

fn write_words(out: &mut String, first: &str, words: [&str; 10]) -> Result {
    write!(out, "{first:<6}")?;
    words
        .iter()
        .try_for_each(|word| write!(out, "{word:>WIDTH$}"))
}

/// Writes one line that aggregates all outcomes.
fn write_all(
    out: &mut String,
    name: &str,
    outcomes: &[Outcome],
    pushed: bool,
    sum: impl Fn(&[f64]) -> f64,
) -> Result {
    write!(out, "{name:<6}")?;
    let back: Column = ("back", 3, |o| {
        Some(o.recovery_time_s.unwrap_or(f64::INFINITY))
    });
    for (_, digits, value) in COLUMNS.into_iter().chain(pushed.then_some(back)) {
        let values: Vec<f64> = outcomes.iter().filter_map(value).collect();
        write_number(out, (!values.is_empty()).then(|| sum(&values)), digits)?;
    }
    writeln!(out)
}

fn write_number(out: &mut String, number: Option<f64>, digits: usize) -> Result {
    match number {
        None => write!(out, "{:>WIDTH$}", "-"),
        Some(number) if number.is_infinite() => write!(out, "{:>WIDTH$}", "never"),
        Some(number) => write!(out, "{number:>WIDTH$.digits$}"),
    }
}

fn worse([a, b]: Joints) -> f64 {
    a.abs().max(b.abs())
}
