//! Sweeps: one scenario with every combination of several values, for many seeds.
//!
//! Each run is the one that `armbridge run` makes of the same scenario, settings and seed, to
//! the bit, without its log. Figures are of the board's estimate, as in the summary of a
//! run; [`monte_carlo`] has those of the true arm.
//!
//! | file     | contents                                             |
//! |----------|------------------------------------------------------|
//! | `axis`   | keys and their values, and the grid of combinations  |
//! | `single` | one run and its figures                              |
//! | `table`  | median and worst over the seeds, as text             |
//! | `csv`    | all runs, one line each                              |
//! | `figure` | figures over the first key                           |

mod axis;
mod csv;
mod figure;
mod single;
mod table;

pub use axis::{Assignment, Axis, AxisError, Combination, RUNS_MAX, ValueError, combinations};
pub use csv::CsvError;
pub use single::{RunFigures, SweepRun, run as run_once};
pub use table::{Row, Spread};

use std::path::Path;

use armbridge_client::ctrl_c;
use armbridge_log::LogError;
use serde::Serialize;

use crate::monte_carlo;
use crate::plot::{self, PlotError};
use crate::scenario::Scenario;

/// A sweep's runs.
#[derive(Clone, Debug, Serialize)]
pub struct Sweep {
    /// Name of the scenario.
    pub scenario: String,
    /// Keys other than the seed, in the order of the command line.
    pub keys: Vec<String>,
    /// Combinations of their values, the last key changing fastest.
    pub combinations: Vec<Combination>,
    /// Seeds of each combination.
    pub seeds: Vec<u64>,
    /// Runs that ended, in the order of combinations and seeds.
    pub runs: Vec<SweepRun>,
}

impl Sweep {
    /// Runs a checked scenario of each combination for every seed, on all processors, with
    /// the logs of the runs in a folder if one is given. Ctrl-C ends it, and so does a log
    /// that cannot be written, whose error is returned beside it: the runs that have ended
    /// stay.
    pub fn run(
        keys: Vec<String>,
        grid: Vec<(Combination, Scenario)>,
        seeds: Vec<u64>,
        logs: Option<&Path>,
        done: impl FnMut(usize),
    ) -> (Self, Result<(), LogError>) {
        let numbers = 0..grid.len();
        let jobs: Vec<(usize, u64)> = numbers
            .flat_map(|combination| seeds.iter().map(move |seed| (combination, *seed)))
            .collect();
        let one = |&(combination, seed): &(usize, u64)| {
            if ctrl_c::is_raised() {
                return Ok(None);
            }
            let mut scenario = grid[combination].1.clone();
            scenario.bench.seed = seed;
            let name = format!("{:03}-{seed}.mcap", combination + 1);
            let log = logs.map(|folder| folder.join(name));
            let figures = run_once(&scenario, log.as_deref(), ctrl_c::is_raised)?;
            Ok(figures.map(|figures| SweepRun {
                combination,
                seed,
                figures,
            }))
        };
        let batch = monte_carlo::for_each(&jobs, one, done);
        let scenario = grid.first();
        let sweep = Self {
            scenario: scenario.map_or_else(String::new, |(_, scenario)| scenario.name.clone()),
            keys,
            combinations: grid
                .into_iter()
                .map(|(combination, _)| combination)
                .collect(),
            seeds,
            runs: batch.finished.into_iter().flatten().collect(),
        };
        (sweep, batch.error.map_or(Ok(()), Err))
    }

    /// Whether all runs ended.
    pub fn is_complete(&self) -> bool {
        self.runs.len() == self.combinations.len() * self.seeds.len()
    }

    /// Rows of the table: one for each combination, over its seeds.
    pub fn rows(&self) -> Vec<Row> {
        let combinations = self.combinations.iter().enumerate();
        let row = |(number, combination): (usize, &Combination)| {
            let runs = self.runs.iter().filter(|run| run.combination == number);
            Row::new(combination, runs)
        };
        combinations.map(row).collect()
    }

    /// Text table of the rows.
    pub fn table(&self) -> String {
        table::table(&self.keys, &self.rows(), self.seeds.len())
    }

    /// Writes all runs as CSV.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn write_csv(&self, path: &Path) -> Result<(), CsvError> {
        csv::write(self, path)
    }

    /// Draws `sweep.svg` and `sweep.png` into a folder.
    ///
    /// # Errors
    /// If a file cannot be written.
    pub fn draw(&self, folder: &Path) -> Result<(), PlotError> {
        plot::write_all(folder, [("sweep", figure::draw(self))]).map(drop)
    }
}
