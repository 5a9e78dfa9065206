//! Median and worst of the runs of each combination, as rows and as text.

use std::fmt::{Result, Write};

use armbridge_log::text_table::{self, WIDTH};
use serde::Serialize;

use super::{Combination, RunFigures, SweepRun};

/// Median and worst of a figure over the seeds. Infinite, null in JSON, for an arm that
/// never settled.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Spread {
    /// Median.
    pub median: f64,
    /// Largest.
    pub worst: f64,
}

/// Figures of one combination over its seeds; a figure that no run has is none.
#[derive(Clone, Debug, Serialize)]
pub struct Row {
    /// Values of the keys.
    pub values: Combination,
    /// Runs that ended.
    pub runs: usize,
    /// Longest settling time at a setpoint, in s.
    pub settling_time_s: Option<Spread>,
    /// Largest mean error at rest, in mrad.
    pub rest_error_mrad: Option<Spread>,
    /// Rms error while the reference moves, in mrad.
    pub tracking_rms_mrad: Option<Spread>,
    /// Largest torque, in N m.
    pub peak_torque_nm: Option<Spread>,
    /// Runs that did not do what the scenario describes.
    pub failed: usize,
    /// Name of the first fault.
    pub fault: Option<&'static str>,
}

/// A figure: its heading, unit, decimals, value in a run, and value in a row.
pub(super) struct Figure {
    pub(super) title: &'static str,
    pub(super) unit: &'static str,
    pub(super) decimals: usize,
    of_run: fn(&RunFigures) -> Option<f64>,
    of_row: fn(&Row) -> Option<Spread>,
}

pub(super) const FIGURES: [Figure; 4] = [
    Figure {
        title: "settled after",
        unit: "s",
        decimals: 3,
        of_run: RunFigures::settling_s,
        of_row: |row| row.settling_time_s,
    },
    Figure {
        title: "off at rest",
        unit: "mrad",
        decimals: 2,
        of_run: |run| run.rest_error_mrad,
        of_row: |row| row.rest_error_mrad,
    },
    Figure {
        title: "rms in motion",
        unit: "mrad",
        decimals: 2,
        of_run: |run| run.tracking_rms_mrad,
        of_row: |row| row.tracking_rms_mrad,
    },
    Figure {
        title: "peak torque",
        unit: "N m",
        decimals: 3,
        of_run: |run| Some(run.peak_torque_nm),
        of_row: |row| row.peak_torque_nm,
    },
];

impl Figure {
    /// Value in a run.
    pub(super) fn of_run(&self, run: &RunFigures) -> Option<f64> {
        (self.of_run)(run)
    }

    /// Value in a row.
    pub(super) fn of_row(&self, row: &Row) -> Option<Spread> {
        (self.of_row)(row)
    }
}

impl Row {
    pub(super) fn new<'a>(
        combination: &Combination,
        runs: impl Iterator<Item = &'a SweepRun>,
    ) -> Self {
        let runs: Vec<&RunFigures> = runs.map(|run| &run.figures).collect();
        let [settling, rest, tracking, torque] = FIGURES.map(|figure| {
            let values = runs.iter().filter_map(|run| figure.of_run(run));
            spread(values.collect())
        });
        Self {
            values: combination.clone(),
            runs: runs.len(),
            settling_time_s: settling,
            rest_error_mrad: rest,
            tracking_rms_mrad: tracking,
            peak_torque_nm: torque,
            failed: runs.iter().filter(|run| run.has_failed()).count(),
            fault: runs.iter().find_map(|run| run.fault),
        }
    }
}

fn spread(mut values: Vec<f64>) -> Option<Spread> {
    values.sort_by(f64::total_cmp);
    let worst = *values.last()?;
    let (low, high) = (values[(values.len() - 1) / 2], values[values.len() / 2]);
    Some(Spread {
        median: f64::midpoint(low, high),
        worst,
    })
}

/// Widths of a median and of a worst value.
const MEDIAN: usize = 6;
const WORST: usize = 7;
/// Width of a figure's columns.
const FIGURE: usize = MEDIAN + WORST;
/// Width of the count of failed runs.
const FAILED: usize = 8;

/// Table of rows, ending in a line feed; at most 80 columns, unless a row's values are
/// longer.
pub(super) fn table(keys: &[String], rows: &[Row], seeds: usize) -> String {
    let mut text = String::new();
    // Writing to a string cannot fail.
    let _ = write_table(&mut text, keys, rows, seeds > 1);
    text
}

fn write_table(out: &mut String, keys: &[String], rows: &[Row], is_spread: bool) -> Result {
    let (keys, labels) = labels(keys, rows);
    let all = labels.iter().chain([&keys]);
    let widest = all.map(|label| label.chars().count()).max().unwrap_or(0);
    // Figures that the scenario has; longer values have a line of their own.
    let has = |figure: &&Figure| rows.iter().any(|row| figure.of_row(row).is_some());
    let figures: Vec<&Figure> = FIGURES.iter().filter(has).collect();
    let column = widest.min(WIDTH - FAILED - figures.len() * (1 + FIGURE));
    let mut heads = [(); 3].map(|()| String::new());
    for figure in &figures {
        write!(heads[0], " {:>FIGURE$}", figure.title)?;
        write!(heads[1], " {:>FIGURE$}", figure.unit)?;
        write!(heads[2], " {:>MEDIAN$}{:>WORST$}", "median", "worst")?;
    }
    if !is_spread {
        heads[2].clear();
    }
    let [titles, units, spreads] = heads;
    writeln!(out, "{:column$}{titles}", "")?;
    if is_spread {
        writeln!(out, "{:column$}{units}", "")?;
        write_label(out, &keys, column)?;
        writeln!(out, "{spreads}  failed")?;
    } else {
        write_label(out, &keys, column)?;
        writeln!(out, "{units}  failed")?;
    }
    for (row, label) in rows.iter().zip(&labels) {
        write_label(out, label, column)?;
        for figure in &figures {
            let spread = figure.of_row(row);
            let median = number(spread.map(|spread| spread.median), figure.decimals);
            if is_spread {
                let worst = number(spread.map(|spread| spread.worst), figure.decimals);
                write!(out, " {median:>MEDIAN$}{worst:>WORST$}")?;
            } else {
                write!(out, " {median:>FIGURE$}")?;
            }
        }
        match (row.failed, row.runs) {
            (_, 0) => writeln!(out, " not run")?,
            (0, _) => writeln!(out, "       -")?,
            (failed, runs) => writeln!(out, " {:>7}", format!("{failed} of {runs}"))?,
        }
        if let Some(fault) = row.fault {
            writeln!(out, "{:column$}   fault: {fault}", "")?;
        }
    }
    Ok(())
}

/// Keys, and the values of each row below them.
fn labels(keys: &[String], rows: &[Row]) -> (String, Vec<String>) {
    let values =
        |row: &Row| -> Vec<String> { row.values.0.iter().map(|pair| pair.value.clone()).collect() };
    let lines: Vec<Vec<String>> = std::iter::once(keys.to_vec())
        .chain(rows.iter().map(values))
        .collect();
    let text = text_table::columns(&lines);
    let mut lines = text.lines().map(str::to_owned);
    (lines.next().unwrap_or_default(), lines.collect())
}

/// A label in its column, or on a line of its own if it is longer.
fn write_label(out: &mut String, label: &str, column: usize) -> Result {
    if label.chars().count() <= column {
        write!(out, "{label:column$}")
    } else {
        write!(out, "{label}\n{:column$}", "")
    }
}

fn number(number: Option<f64>, decimals: usize) -> String {
    match number {
        None => "-".into(),
        Some(number) if number.is_infinite() => "never".into(),
        Some(number) => format!("{number:.decimals$}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sweep::Assignment;

    fn run(settling_time_s: Option<f64>) -> SweepRun {
        let figures = RunFigures {
            settling_time_s,
            settled: Some(settling_time_s.is_some()),
            peak_torque_nm: 0.7,
            ..RunFigures::default()
        };
        SweepRun {
            combination: 0,
            seed: 1,
            figures,
        }
    }

    #[test]
    fn never_is_worse_than_any_time() {
        let value = "[10, 10, 1, 1, 100]".to_owned();
        let key = "controller.q".to_owned();
        let combination = Combination(vec![Assignment { key, value }]);
        let runs = [run(Some(0.5)), run(None), run(Some(0.7)), run(Some(0.6))];
        let row = Row::new(&combination, runs.iter());
        let spread = row.settling_time_s.unwrap();
        assert!((spread.median - 0.65).abs() < 1e-12 && spread.worst.is_infinite());
        let text = table(&["controller.q".into()], &[row], 4);
        assert!(text.contains(" 0.650  never"), "{text}");
        assert!(
            text.lines().all(|line| line.chars().count() <= 80),
            "{text}"
        );
    }
}
