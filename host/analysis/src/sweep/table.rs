//! Median and worst of the runs of each combination, as rows and as text.

use std::fmt::{Result, Write};

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

/// Width of a number.
const NUMBER: usize = 7;
/// Width of the values of the keys; longer ones have a line of their own.
const VALUES: usize = 16;

/// Table of rows, ending in a line feed; at most 80 columns, unless a row's values are
/// longer.
pub(super) fn table(keys: &[String], rows: &[Row], seeds: usize) -> String {
    let mut text = String::new();
    // Writing to a string cannot fail.
    let _ = write_table(&mut text, keys, rows, seeds > 1);
    text
}

fn write_table(out: &mut String, keys: &[String], rows: &[Row], is_spread: bool) -> Result {
    let width = if is_spread { 2 * NUMBER } else { NUMBER + 7 };
    let label = |row: &Row| {
        let values = row.values.0.iter().map(|pair| pair.value.as_str());
        values.collect::<Vec<_>>().join("  ")
    };
    let keys = keys.join("  ");
    let labels = rows.iter().map(label).chain([keys.clone()]);
    let widest = labels.map(|label| label.chars().count()).max().unwrap_or(0);
    let column = widest.min(VALUES);
    let mut heads = [String::new(), String::new()];
    for figure in &FIGURES {
        write!(heads[0], " {:>width$}", figure.title)?;
        let unit = figure.unit;
        if is_spread {
            write!(heads[1], " {:>NUMBER$}{:>NUMBER$}", "median", "worst")?;
        } else {
            write!(heads[1], " {unit:>width$}")?;
        }
    }
    writeln!(out, "{:column$}{}", "", heads[0])?;
    if is_spread {
        let units = FIGURES
            .iter()
            .map(|figure| format!(" {:>width$}", figure.unit));
        writeln!(out, "{:column$}{}", "", units.collect::<String>())?;
    }
    write_label(out, &keys, column)?;
    writeln!(out, "{}  failed", heads[1])?;
    for row in rows {
        write_label(out, &label(row), column)?;
        for figure in &FIGURES {
            let spread = figure.of_row(row);
            let median = number(spread.map(|spread| spread.median), figure.decimals);
            if is_spread {
                let worst = number(spread.map(|spread| spread.worst), figure.decimals);
                write!(out, " {median:>NUMBER$}{worst:>NUMBER$}")?;
            } else {
                write!(out, " {median:>width$}")?;
            }
        }
        match (row.failed, row.runs) {
            (_, 0) => writeln!(out, "  not run")?,
            (0, _) => writeln!(out, "       -")?,
            (failed, runs) => writeln!(out, "  {failed} of {runs}")?,
        }
        if let Some(fault) = row.fault {
            writeln!(out, "{:column$}   fault: {fault}", "")?;
        }
    }
    Ok(())
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
        assert!(text.contains("0.650  never"), "{text}");
        assert!(
            text.lines().all(|line| line.chars().count() <= 80),
            "{text}"
        );
    }
}
