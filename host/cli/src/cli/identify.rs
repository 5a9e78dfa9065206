//! The command line of `identify`.

use std::path::PathBuf;

use clap::{Args, Subcommand};

use super::run::PaceName;
use super::{LinkArgs, OutputArgs};

pub(crate) const EXAMPLES: &str = "\
Examples:
  armbridge identify run --link serial:
  armbridge run multisine && armbridge identify fit
  armbridge identify fit runs/*-multisine runs/*-staircase runs/*-stiction
  armbridge identify fit run.mcap --out arm.toml && armbridge set --from arm.toml --save
  armbridge identify paper";

pub(crate) const RUN_EXAMPLES: &str = "\
Examples:
  armbridge identify run --dry-run                     what would move where, as a picture
  armbridge identify run                               a simulated arm
  armbridge identify run --plant host/plants/heavy.toml   another one, unknown to the board
  armbridge identify run --link serial: --apply        the arm on a board, which is told
  armbridge identify run --plan mine.toml --link tcp://127.0.0.1:7001 --yes --json

Before anything moves, every step is checked against the board's settings, and a picture
shows the angles that will be swept; a real arm moves only after `yes`. In the end the run
folder has the log, arm.toml for `armbridge set --from`, and the plots. What is known too
vaguely for control is not applied, --yes or not.

Exit codes: 0 the numbers are found, and applied if asked for; 1 the run or the fit went
wrong, or the board was not changed; 2 nothing has moved; 130 ended by ctrl-c, motors off.";

pub(crate) const FIT_EXAMPLES: &str = "\
Examples:
  armbridge identify fit
  armbridge identify fit runs/*-multisine runs/*-staircase --out arm.toml
  armbridge identify fit runs/*-multisine --held-out runs/*-sweep --report page
  armbridge identify fit run.mcap --weighed 0.05 --json

Only ticks in which the motors are driven count; only while a joint slides does it tell
anything. Motion tells all torques as multiples of one another: that one is the arm's
weight, by arm.m1_kg, arm.m2_kg and the lengths that the log has. Exit code 1 with what is
wrong and no numbers if the logs cannot tell them: empty, too short, samples lost, clipped,
wrong joint, wrong way, held by hand.";

pub(crate) const PAPER_EXAMPLES: &str = "\
Examples:
  armbridge identify paper                    the paper's two experiments, simulated
  armbridge run paper-free-fall && armbridge run paper-constant-input
  armbridge identify paper runs/*-paper-free-fall runs/*-paper-constant-input
  armbridge identify paper runs/*-paper-free-fall --as-paper --json

The paper fits viscous friction to a free fall, b1 = 0.421, and friction and torque to a
constant input, b1 = 0.239. Both are fitted as it did, and then with dry friction. Inertia
and weight are those that the log's board believes in. Writes a figure into a run folder.";

/// What an arm is, from its logs.
#[derive(Args, Debug)]
pub(crate) struct IdentifyArgs {
    #[command(subcommand)]
    pub(crate) what: Identify,
}

#[derive(Subcommand, Debug)]
pub(crate) enum Identify {
    /// Have the arm move as a plan says, and find the numbers that explain how it did.
    #[command(after_help = RUN_EXAMPLES)]
    Run(IdentifyRunArgs),
    /// Find the numbers that explain these logs.
    #[command(after_help = FIT_EXAMPLES)]
    Fit(FitArgs),
    /// Do as the paper did, and see why its two friction values differ.
    #[command(after_help = PAPER_EXAMPLES)]
    Paper(PaperArgs),
}

/// A plan, performed and fitted.
#[derive(Args, Debug)]
pub(crate) struct IdentifyRunArgs {
    /// A scenario with experiments: a file, or the name of one that ships.
    #[arg(long, value_name = "NAME|FILE", default_value = "identify")]
    pub(crate) plan: String,
    #[command(flatten)]
    pub(crate) link: LinkArgs,
    /// Show what would move where, with a picture, and end. Needs no board.
    #[arg(long, conflicts_with = "apply")]
    pub(crate) dry_run: bool,
    /// Move, and with --apply change the board, without asking.
    #[arg(long)]
    pub(crate) yes: bool,
    /// How well masses and lengths are known, as a share of the weight.
    #[arg(long, value_name = "SHARE", default_value_t = 0.01, value_parser = share)]
    pub(crate) weighed: f64,
    /// Send the arm that was found to the board, with gains for it, and save it there.
    #[arg(long)]
    pub(crate) apply: bool,
    /// The virtual arm of sim: and emulate:, as host/plants/default.toml describes it.
    #[arg(long, value_name = "FILE")]
    pub(crate) plant: Option<PathBuf>,
    /// Seed of its encoders' noise, instead of the plan's own.
    #[arg(long)]
    pub(crate) seed: Option<u64>,
    /// How fast time goes on sim: and emulate:.
    #[arg(long, value_enum, default_value_t = PaceName::Free)]
    pub(crate) pace: PaceName,
    #[command(flatten)]
    pub(crate) output: OutputArgs,
}

#[derive(Args, Debug)]
pub(crate) struct FitArgs {
    /// Logs, or run folders with a run.mcap; by default the newest run.
    #[arg(value_name = "LOG")]
    pub(crate) logs: Vec<PathBuf>,
    /// How well masses and lengths are known, as a share of the weight.
    #[arg(long, value_name = "SHARE", default_value_t = 0.01, value_parser = share)]
    pub(crate) weighed: f64,
    /// Tell how well the numbers forecast this log, which they are not found in; may be
    /// given several times. Without it, the last fifth of the windows is held out of a
    /// second fit, if that takes no more than 2 s.
    #[arg(long, value_name = "LOG")]
    pub(crate) held_out: Vec<PathBuf>,
    /// Write the parameters to this file, for `armbridge set --from`.
    #[arg(long, value_name = "TOML")]
    pub(crate) out: Option<PathBuf>,
    /// Send the arm that was found to the board, with gains for it, and save it there.
    #[arg(long)]
    pub(crate) apply: bool,
    #[command(flatten)]
    pub(crate) link: LinkArgs,
    /// With --apply, change the board without asking.
    #[arg(long, requires = "apply")]
    pub(crate) yes: bool,
    /// Write a page with pictures, report.html, into this folder.
    #[arg(long, value_name = "DIR")]
    pub(crate) report: Option<PathBuf>,
    /// Print one JSON object instead of the table.
    #[arg(long)]
    pub(crate) json: bool,
}

/// The paper's own procedure.
#[derive(Args, Debug)]
pub(crate) struct PaperArgs {
    /// Logs of a free fall, of a constant input, or of both, or their run folders; without
    /// any, both are simulated.
    #[arg(value_name = "LOG")]
    pub(crate) logs: Vec<PathBuf>,
    /// Use a sample every 45 ms, as the paper had, instead of all.
    #[arg(long, requires = "logs")]
    pub(crate) as_paper: bool,
    /// Seed of the simulated encoder's noise.
    #[arg(long, default_value_t = 1, conflicts_with = "logs")]
    pub(crate) seed: u64,
    /// Folder in which the run folder with the figure is made.
    #[arg(long, value_name = "DIR")]
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
