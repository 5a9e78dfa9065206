//! `armbridge replay`: a log's inputs, run through the board's code again.

use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::Instant;

use armbridge_client::{params, stdio, toml_file};
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
  armbridge replay --from 12.5
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
    /// Begin at this time on the board's clock, in s: `time_s` of a log. A replay begins at the
    /// snapshot before it, of which a log has one each second.
    #[arg(long, value_name = "S")]
    pub(crate) from: Option<f64>,
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
    if let Some(build) = reader.other_build() {
        let path = path.display();
        return Err(format!(
            "{path} was written by version {build}; its ticks can be replayed with that version \
             only"
        )
        .into());
    }
    let begun = Instant::now();
    let mut player = match args.from {
        Some(from_s) => player_from(&mut reader, from_s, changes)?,
        None => Replayer::new(changes)?,
    };
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

/// A player of the ticks from this time on.
fn player_from(
    reader: &mut Reader,
    from_s: f64,
    changes: Changes,
) -> Result<Replayer, Box<dyn std::error::Error>> {
    let path = reader.path().display().to_string();
    if !(from_s >= 0.0 && from_s.is_finite()) {
        return Err(format!("--from {from_s}: it is a time in s, 0 or later").into());
    }
    let state = reader.go_to_snapshot((from_s * 1e6) as u64)?;
    let state = state.ok_or_else(|| {
        format!("{path} has no snapshot before {from_s} s; replay it from the beginning")
    })?;
    Replayer::resume(&state, changes)?.ok_or_else(|| {
        let why = "another build wrote its snapshots; replay it from the beginning";
        format!("{path}: {why}").into()
    })
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
