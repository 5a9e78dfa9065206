//! `armbridge run`: runs a scenario on any board.

mod builtins;
mod staging;

use std::process::ExitCode;

use armbridge::config::Config;
use armbridge_analysis::plan_runner::plan::Base;
use armbridge_analysis::run::{RunError, RunHost};
use armbridge_analysis::run_folder::RunFolder;
use armbridge_analysis::scenario::{KEYS, Overrides, Scenario, ScenarioText};
use armbridge_client::toml_file::keys;
use armbridge_client::transport::LinkUri;
use armbridge_client::{ctrl_c, stdio};
use armbridge_sim::link::{BoardUri, drive};
use clap::Args;
use serde_json::json;

use super::finish::{Description, finish};
use super::{Error, Outcome, transparent_port};
use crate::args::listen::{FORMS, listen_at};
use crate::args::suggestions::scenarios;
use crate::args::values::{seed, speed};
use crate::args::{
    ExposeArgs, LinkArgs, OutputArgs, PaceName, ScenarioArgs, ScenarioArmArgs, VirtualServoArgs,
};
pub(super) use staging::Staging;

pub(crate) const EXAMPLES: &str = "\
Examples:
  armbridge run --list                      the scenarios that ship
  armbridge run                             the demo, simulated, at full speed
  armbridge run demo --control compensated  the same, friction compensated
  armbridge run push --link emulate:        on the firmware image in QEMU
  armbridge run mine.toml --link serial:    a file of your own, on a board
  armbridge run mine.toml --check           check the file; nothing moves
  armbridge run demo.csv --speed 0.5        a motion, at half its speed
  armbridge run hour --duration 600 --json  ten minutes, with a summary as JSON

A scenario is a TOML file; armbridge run NAME --show prints one that ships, as a
starting point. Ctrl-C switches the motors off, then ends the run. The log and
the plots of the run are in a new folder in runs/.

Exit codes: 0 the run met the scenario's expectations, 1 it did not (a fault, a
missed expectation, records lost), 2 there was no run, 130 ended by ctrl-c.";

/// A scenario, and what overrides it.
#[expect(clippy::struct_excessive_bools, reason = "each is a switch of its own")]
#[derive(Args, Clone, Debug)]
pub(crate) struct RunArgs {
    /// Scenario: a file, the name of one that ships, or - for standard input; or a motion
    /// as CSV.
    #[arg(default_value = "demo", value_parser = scenarios(), hide_possible_values = true)]
    pub(crate) scenario: String,
    /// List the scenarios that ship.
    #[arg(long, conflicts_with = "scenario")]
    pub(crate) list: bool,
    /// Check the scenario without running it.
    #[arg(long)]
    pub(crate) check: bool,
    /// Print the file of a scenario that ships.
    #[arg(long, conflicts_with = "check")]
    pub(crate) show: bool,
    /// Print every key of a scenario file with its range and meaning.
    #[arg(long, conflicts_with = "scenario")]
    pub(crate) explain: bool,
    #[command(flatten)]
    pub(crate) link: LinkArgs,
    #[command(flatten)]
    pub(crate) overrides: ScenarioArgs,
    /// Speed of a motion, relative to that of its file: 0.5 for half as fast.
    #[arg(long, value_name = "FACTOR", value_parser = speed)]
    pub(crate) speed: Option<f64>,
    /// Perform a motion so many times.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1_000))]
    pub(crate) repeat: Option<u32>,
    /// Clear a fault that is latched on the board; remove its cause first.
    #[arg(long)]
    pub(crate) clear: bool,
    /// At the end, restore the mode and the return delay that stock servos were found
    /// with.
    #[arg(long)]
    pub(crate) release: bool,
    #[command(flatten)]
    pub(crate) simulated: SimulatedArgs,
    #[command(flatten)]
    pub(crate) output: OutputArgs,
}

/// The simulation, for `sim:` and `emulate:`.
#[derive(Args, Clone, Debug)]
#[command(next_help_heading = "Simulated board (sim: and emulate:)")]
pub(crate) struct SimulatedArgs {
    /// Seed of the encoder noise, instead of the scenario's own.
    #[arg(long, value_parser = seed)]
    pub(crate) seed: Option<u64>,
    #[command(flatten)]
    pub(crate) arm: ScenarioArmArgs,
    #[command(flatten)]
    pub(crate) servos: VirtualServoArgs,
    /// Serve the board's transparent port to another program, on a socket or by `pty:` on
    /// a new pseudo-terminal.
    #[arg(long, value_name = FORMS, value_parser = listen_at)]
    pub(crate) transparent: Option<LinkUri>,
    #[command(flatten)]
    pub(crate) expose: ExposeArgs,
    /// Pace of simulated time.
    #[arg(long, value_enum, default_value_t = PaceName::Free)]
    pub(crate) pace: PaceName,
}

impl RunArgs {
    fn overrides(&self, config: &Config) -> Result<Overrides, Error> {
        let simulated = &self.simulated;
        Ok(Overrides {
            seed: simulated.seed,
            firmware: simulated.servos.firmware()?,
            servo_baud: simulated.servos.baud(),
            speed: self.speed,
            repeats: self.repeat,
            ..self.overrides.overrides(&simulated.arm, config)?
        })
    }
}

pub(crate) fn run(args: &RunArgs) -> Outcome {
    let name = &args.scenario;
    if args.list {
        return builtins::list(args.output.json);
    }
    if args.show {
        return builtins::show(name);
    }
    if args.explain {
        stdio::print(keys::explain(&KEYS))?;
        return Ok(ExitCode::SUCCESS);
    }
    let config = Config::discover()?;
    let text = ScenarioText::read(name)?;
    let overrides = args.overrides(&config)?;
    let mut scenario = text.scenario(&overrides)?;
    if args.check {
        // As errors name standard input.
        let name = if name == "-" { &scenario.name } else { name };
        return checked(name, &scenario, args.output.json);
    }
    if !args.output.quiet {
        scenario.notes.iter().for_each(stdio::note);
    }
    scenario.plan.is_clearing = args.clear;
    scenario.plan.is_releasing = args.release;

    let link = config.link(args.link.link.as_ref())?;
    let staging = Staging {
        config: &config,
        link: &link,
        pace: args.simulated.pace.into(),
        is_quiet: args.output.quiet,
        is_silent: args.output.quiet || args.output.json,
    };
    let is_cut = overrides.duration_s.is_some();
    let about = about(&scenario, &link).filter(|_| !is_cut);
    let title = scenario.title.clone();
    let mut options = staging.options(&mut scenario);
    options.client = transparent_port::open(
        args.simulated.transparent.as_ref(),
        args.simulated.expose.into(),
    )?;
    let base = config.out(args.output.out.as_deref());
    let folder = RunFolder::create(Some(&base), &scenario.name)?;
    let baseline = match baseline(&text, overrides, &scenario, &link)? {
        Some((control, baseline)) => Some(staging.baseline(control, baseline, &folder)?),
        None => None,
    };
    if ctrl_c::is_raised() {
        // Best effort: a baseline alone is no run.
        let _ = std::fs::remove_dir_all(folder.path());
        return Err(RunError::Interrupted.into());
    }
    let mut player = RunHost::in_folder(staging.task(scenario)?, folder)?;
    if let Some(baseline) = baseline {
        player.compare_with(baseline);
    }
    options.link.taps.push(player.tap());
    options.interactions = Some(player.interactions());
    let (player, result) = drive(&link, options, player);
    let description = Description {
        title: &title,
        about: about.as_deref(),
        is_simulated: link.is_simulated(),
        is_demo: args.scenario == "demo",
    };
    finish(player, result, &args.output, &description)
}

/// Expected events of the scenario; none where its arm is not the one of this link. The initial
/// angles are known of a simulated arm only.
fn about(scenario: &Scenario, link: &BoardUri) -> Option<String> {
    let about = Some(scenario.about.trim()).filter(|about| !about.is_empty())?;
    if link.is_simulated() {
        let [first, second]: [f64; 2] = scenario.bench.plant.initial.q.into();
        return Some(format!(
            "Let go at {first:+.2} and {second:+.2} rad. {about}"
        ));
    }
    let is_untouched = scenario.plan.pushes.is_empty() && scenario.plan.leads.is_empty();
    is_untouched.then(|| about.to_owned())
}

/// Prints that a scenario is in order, with its remarks.
fn checked(name: &str, scenario: &Scenario, as_json: bool) -> Outcome {
    if as_json {
        stdio::print_line(json!({
            "scenario": name,
            "title": scenario.title,
            "duration_s": scenario.plan.stop.after_us as f64 * 1e-6,
            "notes": scenario.notes,
        }))?;
        return Ok(ExitCode::SUCCESS);
    }
    stdio::print_line(format_args!("{name} is in order: {}", scenario.title))?;
    for note in &scenario.notes {
        stdio::print_line(note)?;
    }
    Ok(ExitCode::SUCCESS)
}

/// The scenario with the control of its baseline; none where the arm is real, or where the
/// run has this control.
fn baseline(
    text: &ScenarioText,
    overrides: Overrides,
    scenario: &Scenario,
    link: &BoardUri,
) -> Result<Option<(Base, Scenario)>, Error> {
    let Some(control) = scenario.baseline.filter(|_| link.is_simulated()) else {
        return Ok(None);
    };
    let overrides = Overrides {
        control: Some(control),
        set: Vec::new(),
        ..overrides
    };
    let baseline = text.scenario(&overrides)?;
    let is_other = baseline.settings != scenario.settings;
    Ok(is_other.then_some((control, baseline)))
}
