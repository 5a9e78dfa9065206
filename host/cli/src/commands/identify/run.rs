//! `armbridge identify run`: a plan shown, confirmed, run, fitted, and applied.

use std::path::PathBuf;
use std::process::ExitCode;

use armbridge::config::Config;
use armbridge_analysis::run::{Finished, RunHost, Verdict};
use armbridge_analysis::run_folder::RunFolder;
use armbridge_analysis::scenario::{Overrides, Preview, Scenario};
use armbridge_client::params::settings_exchange::Exchange;
use armbridge_client::transport::Intent;
use armbridge_client::{ctrl_c, params, stdio};
use armbridge_link::message::Settings;
use armbridge_log::output_file::Existing;
use armbridge_sim::link::{BoardUri, drive};
use armbridge_sim::plant::PlantFile;
use clap::Args;
use serde_json::{Value, json};

use super::super::run::Staging;
use super::super::{Error, Outcome, ask, link};
use super::apply::{Applied, Apply, not_applied};
use super::output::{self, OutputOptions};
use super::{fit_logs, paths, preview, share, write_to};
use crate::args::suggestions::plants;
use crate::args::values::seed;
use crate::args::{LinkArgs, OutputArgs, PaceName};

pub(crate) const EXAMPLES: &str = "\
Examples:
  armbridge identify run --dry-run               show the planned motion
  armbridge identify run                         a simulated arm
  armbridge identify run --plant heavy           one unknown to the board
  armbridge identify run --link serial: --apply  a real one; the board adopts it
  armbridge identify run --plan mine.toml --link serial: --yes --json

Before anything moves, every step is checked against the board's settings, and a
figure shows the range of angles; a real arm moves only after yes. The run
folder then has the log, the plots, and arm.toml for armbridge params --from.
Parameters too uncertain for control are never applied, not even with --yes.

Exit codes: 0 the arm is identified, and applied if requested; 1 the run or the
fit failed, or the board was not changed; 2 nothing has moved; 130 ended by
ctrl-c, motors off.";

/// A plan, performed and fitted.
#[derive(Args, Debug)]
pub(crate) struct IdentifyRunArgs {
    /// Scenario with experiments: a file, or the name of one that ships.
    #[arg(long, value_name = "NAME|FILE", default_value = "identify")]
    pub(crate) plan: String,
    #[command(flatten)]
    pub(crate) link: LinkArgs,
    /// Show the planned motion as a table and a figure, and end. Needs no board.
    #[arg(long, conflicts_with = "apply")]
    pub(crate) dry_run: bool,
    /// Move, and with --apply change the board, without asking.
    #[arg(long)]
    pub(crate) yes: bool,
    /// Relative standard error of the known weight.
    #[arg(long, value_name = "SHARE", default_value_t = 0.01, value_parser = share)]
    pub(crate) weighed: f64,
    /// Send the identified arm to the board, with gains for it, and save it there.
    #[arg(long)]
    pub(crate) apply: bool,
    /// Virtual arm of a simulated board: the name of one that ships (`armbridge plants`), or
    /// a file.
    #[arg(long, value_name = "NAME|FILE", value_parser = plants(), hide_possible_values = true)]
    pub(crate) plant: Option<String>,
    /// Seed of the encoder noise, instead of the plan's own.
    #[arg(long, value_parser = seed)]
    pub(crate) seed: Option<u64>,
    /// Pace of time on sim: and emulate:.
    #[arg(long, value_enum, default_value_t = PaceName::Free)]
    pub(crate) pace: PaceName,
    #[command(flatten)]
    pub(crate) output: OutputArgs,
}

/// File in the run folder that the parameters are written to.
const ARM_NAME: &str = "arm.toml";

pub(super) fn run(args: &IdentifyRunArgs) -> Outcome {
    let config = Config::discover()?;
    let plant = args.plant.as_deref().map(PlantFile::load).transpose()?;
    let load = |board| {
        let overrides = Overrides {
            plant,
            board,
            seed: args.seed,
            ..Overrides::default()
        };
        Scenario::load(&args.plan, &overrides)
    };
    let base = config.out(args.output.out.as_deref());
    if args.dry_run && args.link.link.is_none() {
        let scenario = load(None)?;
        return show(
            args,
            &scenario,
            &RunFolder::create(Some(&base), "preview")?,
            None,
        );
    }
    let uri = config.link(args.link.link.as_ref())?;
    // A simulated board is a new one, as the scenario sets it up.
    let scenario = if uri.is_simulated() {
        load(None)?
    } else {
        match settings_of_board(args, &config) {
            Ok(settings) => load(Some(settings))?,
            Err(why) => {
                // An error in the plan itself is reported first.
                load(None)?;
                return Err(why);
            }
        }
    };
    scenario.notes.iter().for_each(stdio::note);
    if args.dry_run {
        let folder = RunFolder::create(Some(&base), "preview")?;
        return show(args, &scenario, &folder, Some(&uri));
    }
    let folder = RunFolder::create(Some(&base), &scenario.name)?;
    let preview = scenario.preview();
    let files = preview::draw(folder.path(), &preview, Some(&uri.to_string()))?;
    let is_confirmed = args.yes || uri.is_simulated();
    // The question is about this motion.
    if !args.output.quiet || !is_confirmed {
        print_text(args, &shown(&preview, &files))?;
    }
    let question = format!(
        "The arm at {uri} will move. See that nothing is in its way, and hold it near where it \
         begins until its motors do."
    );
    if !is_confirmed && !ask::is_agreed(&question) {
        if ctrl_c::is_raised() {
            return Ok(ExitCode::from(Verdict::Interrupted.exit_code()));
        }
        return Err("the answer was not yes: nothing has moved".into());
    }
    perform(args, &config, &uri, scenario, folder)
}

/// The board's settings.
fn settings_of_board(args: &IdentifyRunArgs, config: &Config) -> Result<Settings, Error> {
    let host = link::run_host(
        &args.link,
        config,
        Intent::CommandOrObserve,
        Exchange::new(|_| Vec::new()),
    )?;
    host.exchanged
        .before
        .ok_or_else(|| "the board did not report its settings; nothing has moved".into())
}

/// Shows the plan, and does nothing.
fn show(
    args: &IdentifyRunArgs,
    scenario: &Scenario,
    folder: &RunFolder,
    uri: Option<&BoardUri>,
) -> Outcome {
    let preview = scenario.preview();
    let board = uri.map(ToString::to_string);
    let files = preview::draw(folder.path(), &preview, board.as_deref())?;
    let text = if args.output.json {
        json!({ "outlook": preview, "preview": files }).to_string() + "\n"
    } else {
        shown(&preview, &files)
    };
    stdio::print(text)?;
    Ok(ExitCode::SUCCESS)
}

fn shown(preview: &Preview, files: &[PathBuf]) -> String {
    let files = files.iter().map(|file| format!("{}\n", file.display()));
    format!(
        "{}\n{}",
        preview::as_text(preview),
        files.collect::<String>()
    )
}

/// Prints text; on standard error beside a JSON object.
fn print_text(args: &IdentifyRunArgs, text: &str) -> Result<(), Error> {
    if args.output.json {
        stdio::note_text(text);
    } else {
        stdio::print(text)?;
    }
    Ok(())
}

fn perform(
    args: &IdentifyRunArgs,
    config: &Config,
    uri: &BoardUri,
    mut scenario: Scenario,
    folder: RunFolder,
) -> Outcome {
    let staging = Staging {
        config,
        link: uri,
        pace: args.pace.into(),
        is_quiet: args.output.quiet,
        is_silent: args.output.quiet || args.output.json,
    };
    let mut options = staging.options(&mut scenario);
    let player = RunHost::in_folder(staging.task(scenario)?, folder)?;
    options.link.taps.push(player.tap());
    let (player, result) = drive(uri, options, player);
    let Finished {
        summary,
        folder,
        verdict,
        ..
    } = player.finish(result)?;
    let path = folder.display().to_string();
    let mut report = json!({ "run": summary, "folder": path });
    let code = match verdict {
        Verdict::Done => fit_and_apply(args, uri, &folder, &mut report)?,
        Verdict::Failed | Verdict::Interrupted => {
            if !args.output.quiet {
                print_text(args, &summary.table())?;
            }
            let why = match (&summary.ended, &summary.missed_expectations[..]) {
                (Some(ended), _) => format!("the run ended early: {ended}"),
                (None, []) => "the run did not meet the plan's expectations".into(),
                (None, missed) => missed.join("; "),
            };
            stdio::note(format_args!(
                "armbridge: {why}; `armbridge identify fit {path}` fits the log that there is"
            ));
            ExitCode::from(verdict.exit_code())
        }
    };
    if args.output.json {
        stdio::print_line(report)?;
    } else if !args.output.quiet {
        stdio::print_line(path)?;
    }
    Ok(code)
}

/// Fits the log of a run, and applies the parameters if that is wanted.
fn fit_and_apply(
    args: &IdentifyRunArgs,
    uri: &BoardUri,
    folder: &std::path::Path,
    report: &mut Value,
) -> Result<ExitCode, Error> {
    let fitted = paths(&[folder.to_owned()]).and_then(|log| fit_logs(&log, args.weighed));
    let options = OutputOptions {
        held_out: &[],
        folder: Some(folder),
        existing: Existing::Refuse,
    };
    let written = fitted.and_then(|fit| {
        write_to(&fit, &folder.join(ARM_NAME), Existing::Refuse)?;
        let description = output::describe(&fit, &options)?;
        Ok((fit, description))
    });
    let (fit, description) = match written {
        Ok(written) => written,
        Err(why) => {
            stdio::note(format_args!(
                "armbridge: the arm is not identified: {why}; the log is in {}",
                folder.display()
            ));
            return Ok(ExitCode::from(1));
        }
    };
    report["fit"] = description.json;
    report["arm"] = serde_json::to_value(params::to_table(fit.parameters()?))?;
    if !args.output.quiet && !args.output.json {
        print_text(args, &description.text)?;
    }
    if !args.apply {
        return Ok(ExitCode::SUCCESS);
    }
    let apply = Apply {
        link: &args.link,
        is_confirmed: args.yes || uri.is_simulated(),
        is_silent: args.output.json,
    };
    // The run and the fit stand even if applying the result fails.
    let applied = apply
        .to_board(&fit)
        .unwrap_or_else(|why| not_applied(&why.to_string()));
    report["applied"] = json!(applied == Applied::Saved);
    Ok(applied.exit_code())
}
