//! The command line of `identify`.

use std::path::PathBuf;

use clap::{Args, Subcommand};

pub(crate) const EXAMPLES: &str = "\
Examples:
  armbridge run multisine && armbridge identify fit
  armbridge identify fit runs/*-multisine runs/*-staircase runs/*-stiction
  armbridge identify fit run.mcap --out arm.toml && armbridge set --from arm.toml --save";

pub(crate) const FIT_EXAMPLES: &str = "\
Examples:
  armbridge identify fit
  armbridge identify fit runs/*-multisine runs/*-staircase --out arm.toml
  armbridge identify fit run.mcap --weighed 0.05 --json

Only ticks in which the motors are driven count; only while a joint slides does it tell
anything. Motion tells all torques as multiples of one another: that one is the arm's
weight, by arm.m1_kg, arm.m2_kg and the lengths that the log has. Exit code 2 if the logs
do not tell enough.";

/// What an arm is, from its logs.
#[derive(Args, Debug)]
pub(crate) struct IdentifyArgs {
    #[command(subcommand)]
    pub(crate) what: Identify,
}

#[derive(Subcommand, Debug)]
pub(crate) enum Identify {
    /// Find the numbers that explain these logs.
    #[command(after_help = FIT_EXAMPLES)]
    Fit(FitArgs),
}

#[derive(Args, Debug)]
pub(crate) struct FitArgs {
    /// Logs, or run folders with a run.mcap; by default the newest run.
    #[arg(value_name = "LOG")]
    pub(crate) logs: Vec<PathBuf>,
    /// How well masses and lengths are known, as a share of the weight.
    #[arg(long, value_name = "SHARE", default_value_t = 0.01, value_parser = share)]
    pub(crate) weighed: f64,
    /// Write the parameters to this file, for `armbridge set --from`.
    #[arg(long, value_name = "TOML")]
    pub(crate) out: Option<PathBuf>,
    /// Print one JSON object instead of the table.
    #[arg(long)]
    pub(crate) json: bool,
}

fn share(text: &str) -> Result<f64, String> {
    match text.parse() {
        Ok(share) if (1e-4..=1.0).contains(&share) => Ok(share),
        Ok(_) | Err(_) => Err("expected a share from 0.0001 to 1, as 0.01 for 1 %".into()),
    }
}
