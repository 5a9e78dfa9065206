//! `armbridge replay`: a log's inputs, run through the board's code again.

use std::path::Path;
use std::path::PathBuf;
use std::process::ExitCode;
use std::time::Instant;

use armbridge_client::params;
use armbridge_client::stdio;
use armbridge_client::toml_file;
use armbridge_log::recording::Reader;
use armbridge_log::replay::{Changes, Replayer, Report, Verdict};
use clap::Args;
use serde::Serialize;
use toml::Value;

use super::{Outcome, log};

pub(crate) const EXAMPLES: &str = "\
Examples:
  armbridge replay
  armbridge replay runs/2026-01-31T12-00-00Z-demo
  armbridge replay board.mcap --json
  armbridge replay --with gains.toml
  armbridge replay --set controller.q=40,40,1,1 --set limits.torque_nm=1,1

Raw counts, commands, parameters and timing of the log go through the code that
ran on the board; every output of every tick must be equal, to the bit. Exit
codes: 0 equal, 1 different, 2 not comparable. With other settings the replay
shows the torques that the board would have commanded, open-loop: the arm's
motion stays as recorded.";

/// The board's code on a log's inputs.
#[derive(Args, Debug)]
pub(crate) struct ReplayArgs {
    /// Log, or run folder with a run.mcap; by default the newest run.
    pub(crate) log: Option<PathBuf>,
    /// Settings to replay with instead of the recorded ones: a TOML file with any of
    /// the parameters that `armbridge config --explain` lists.
    #[arg(long, value_name = "TOML")]
    pub(crate) with: Option<PathBuf>,
    /// Set one parameter for the replay; may be repeated.
    #[arg(long, value_name = "KEY=VALUE", value_parser = params::pair)]
    pub(crate) set: Vec<(String, Value)>,
    /// Print one JSON object instead of the text.
    #[arg(long)]
    pub(crate) json: bool,
}

/// Output of `--json`.
#[derive(Serialize)]
struct Printed<'a> {
    log: &'a Path,
    #[serde(flatten)]
    report: &'a Report,
    /// The file's damage, each in one sentence.
    damage: &'a [String],
    /// Simulated seconds per second of the wall clock.
    times_real_time: f64,
}

pub(crate) fn run(args: &ReplayArgs) -> Outcome {
    let path = log::find(args.log.as_deref())?;
    let changes = Changes::new(table(args.with.as_deref())?, args.set.clone());
    let mut reader = Reader::open(&path)?;
    let begun = Instant::now();
    let mut player = Replayer::new(changes)?;
    for event in &mut reader {
        player.take(&event)?;
    }
    let report = player.finish()?;
    let wall_s = begun.elapsed().as_secs_f64();
    let times_real_time = report.span_s / wall_s.max(1e-9);
    let text = if args.json {
        let printed = Printed {
            log: &path,
            report: &report,
            damage: reader.damage(),
            times_real_time,
        };
        serde_json::to_string(&printed)? + "\n"
    } else {
        let mut damage = reader.damage().join("\ndamaged: ");
        if !damage.is_empty() {
            damage = format!("damaged: {damage}\n");
        }
        format!(
            "{}: {} ticks, {:.1} s\n{damage}{}replayed in {wall_s:.2} s, {times_real_time:.0} times real time\n",
            path.display(),
            report.records,
            report.span_s,
            report.text()
        )
    };
    stdio::print(text)?;
    match report.verdict {
        _ if report.what_if.is_some() && report.compared > 0 => Ok(ExitCode::SUCCESS),
        Verdict::Equal => Ok(ExitCode::SUCCESS),
        Verdict::Differs => Ok(ExitCode::FAILURE),
        Verdict::Nothing => Err(nothing(&path, &report).into()),
    }
}

/// Why nothing was compared.
fn nothing(path: &Path, report: &Report) -> String {
    let path = path.display();
    let why = report.skipped.first().map_or_else(
        || "it has no ticks".to_owned(),
        |skipped| skipped.reason.to_owned(),
    );
    format!(
        "{path} cannot be compared with anything: {why}; record from the hello on, as \
         `armbridge run` and `armbridge watch` do"
    )
}

/// The file with other settings; empty if there is none.
fn table(path: Option<&Path>) -> Result<toml::Table, String> {
    let Some(path) = path else {
        return Ok(toml::Table::new());
    };
    let text = toml_file::read_file(path, toml_file::TEXT_MAX)
        .map_err(|error| format!("{error}; name a TOML file"))?;
    let parsed = text.parse();
    parsed.map_err(|error| toml_file::not_toml(path, &text, &error).to_string())
}
