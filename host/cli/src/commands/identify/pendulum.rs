//! `armbridge identify pendulum`: one real servo on a pendulum, from public recordings.

use std::path::PathBuf;
use std::process::ExitCode;

use armbridge_analysis::pendulum::{self, Recording};
use armbridge_analysis::progress::Progress;
use armbridge_client::stdio;
use clap::Args;

use super::super::Outcome;

pub(crate) const EXAMPLES: &str = "\
Examples:
  armbridge identify pendulum raw/*.json
  armbridge identify pendulum raw/*.json --json

The files are recordings of an XL330 in the format of the project BAM (Better
Actuator Models, github.com/Rhoban/bam), one JSON file a run. Each is simulated
from its goals alone, with the servo's position controller in the loop. Three
forms of dry friction are fitted to all files, and with gains and trajectories
held out; intervals are from leaving out each file in turn. Sixteen files of 6 s
take some minutes.";

/// One servo on a pendulum.
#[derive(Args, Debug)]
pub(crate) struct PendulumArgs {
    /// Recordings, at least four.
    #[arg(value_name = "FILE", required = true)]
    pub(crate) files: Vec<PathBuf>,
    /// Print one JSON object instead of the tables.
    #[arg(long)]
    pub(crate) json: bool,
}

pub(super) fn run(args: &PendulumArgs) -> Outcome {
    let recordings = args.files.iter().map(|path| Recording::load(path));
    let recordings: Vec<Recording> = recordings.collect::<Result<_, _>>()?;
    let bar = Progress::new(1.0, args.json);
    let report = pendulum::identify(&recordings, |share| bar.set_position(share));
    bar.finish();
    let report = report?;
    let text = if args.json {
        serde_json::to_string(&report)? + "\n"
    } else {
        report.text()
    };
    stdio::print(text)?;
    Ok(ExitCode::SUCCESS)
}
