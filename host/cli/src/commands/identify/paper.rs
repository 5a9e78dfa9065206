//! `armbridge identify paper`: the paper's own procedure.

use std::path::PathBuf;
use std::process::ExitCode;

use armbridge::config::Config;
use armbridge_analysis::run_folder::RunFolder;
use armbridge_client::stdio;
use armbridge_control::arm::Parameters;
use armbridge_log::recording::Recording;
use armbridge_log::text_table;
use armbridge_paper::identification::{self, PaperComparison, SampledExperiment};
use clap::Args;
use serde::Serialize;

use super::super::{Error, Outcome, log};
use crate::args::values::seed;

pub(crate) const EXAMPLES: &str = "\
Examples:
  armbridge identify paper            the paper's two experiments, simulated
  armbridge run paper-free-fall && armbridge run paper-constant-input
  armbridge identify paper runs/*-paper-free-fall runs/*-paper-constant-input
  armbridge identify paper runs/*-paper-free-fall --as-paper --json

The paper fits viscous friction to a free fall, b1 = 0.421, and friction and
torque to a constant input, b1 = 0.239. Both are fitted as in the paper, then
with dry friction. Inertia and weight are those of the log's board. A figure is
written to a run folder.";

/// The paper's own procedure.
#[derive(Args, Debug)]
pub(crate) struct PaperArgs {
    /// Logs of a free fall, of a constant input, or of both, or their run folders; without
    /// any, both are simulated.
    #[arg(value_name = "LOG")]
    pub(crate) logs: Vec<PathBuf>,
    /// Use one sample every 45 ms, as the paper did, instead of all.
    #[arg(long, requires = "logs")]
    pub(crate) as_paper: bool,
    /// Seed of the simulated encoder noise.
    #[arg(long, default_value_t = 1, conflicts_with = "logs", value_parser = seed)]
    pub(crate) seed: u64,
    /// Folder in which the run folder with the figure is created.
    #[arg(long, value_name = "DIR")]
    pub(crate) out: Option<PathBuf>,
    /// Print one JSON object instead of the table.
    #[arg(long)]
    pub(crate) json: bool,
}

/// Output of `--json`.
#[derive(Serialize)]
struct Printed<'a> {
    #[serde(flatten)]
    comparison: &'a PaperComparison,
    sentences: Vec<String>,
    files: &'a [PathBuf],
}

pub(super) fn run(args: &PaperArgs) -> Outcome {
    let comparison = if args.logs.is_empty() {
        PaperComparison::simulated(args.seed)?
    } else {
        from_logs(args)?
    };
    let base = Config::discover()?.out(args.out.as_deref());
    let folder = RunFolder::create(Some(&base), "identify-paper")?;
    let files = comparison.draw(folder.path())?;
    let text = if args.json {
        let printed = Printed {
            sentences: comparison.sentences(),
            files: &files,
            comparison: &comparison,
        };
        serde_json::to_string(&printed)? + "\n"
    } else {
        let files: Vec<String> = files.iter().map(|f| f.display().to_string()).collect();
        format!(
            "{}samples every {:.0} ms\n\n{}\n{}\n",
            text_table::fold(&comparison.source, "  "),
            1e3 * comparison.period_s,
            comparison.text(),
            files.join("\n")
        )
    };
    stdio::print(text)?;
    Ok(ExitCode::SUCCESS)
}

fn from_logs(args: &PaperArgs) -> Result<PaperComparison, Error> {
    let mut first: Option<(PathBuf, Parameters<f32>)> = None;
    let mut experiments: Vec<SampledExperiment> = Vec::new();
    let mut names: Vec<String> = Vec::new();
    let mut worlds: Vec<String> = Vec::new();
    for log in &args.logs {
        let path = log::find(Some(log))?;
        let recording = Recording::load(&path)?;
        for damage in &recording.damage {
            stdio::note(format_args!("{}: {damage}", path.display()));
        }
        let facts = &recording.facts;
        let (named, arm) = first.get_or_insert_with(|| (path.clone(), facts.setup.arm));
        if *arm != facts.setup.arm {
            let (a, b) = (named.display(), path.display());
            return Err(format!("{a} and {b} are from boards with different arm models").into());
        }
        let found = identification::experiments(&recording.records(), facts)
            .map_err(|error| format!("{}: {error}", path.display()))?;
        experiments.extend(found);
        names.push(facts.name.clone());
        if !worlds.contains(&facts.world) {
            worlds.push(facts.world.clone());
        }
    }
    let Some((_, arm)) = first else {
        return Err("name a log".into());
    };
    if args.as_paper {
        for experiment in &mut experiments {
            *experiment = experiment.at_paper_period();
        }
    }
    let source = format!("{} · {}", names.join(", "), worlds.join(", "));
    Ok(PaperComparison::from_experiments(
        source,
        experiments,
        &arm.map(f64::from),
    )?)
}
