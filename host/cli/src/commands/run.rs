//! `armbridge run`: runs a scenario on any board.

use std::process::ExitCode;

use armbridge::config::Config;
use armbridge_analysis::plan_runner::plan::Base;
use armbridge_analysis::run::{BASELINE_LOG, Baseline, Files, RUN_LOG, RunHost, RunSpec};
use armbridge_analysis::run_folder::RunFolder;
use armbridge_analysis::scenario::{
    BUILTINS, Builtin, ExpectationMonitor, KEYS, Overrides, Scenario, ScenarioText,
};
use armbridge_client::stdio;
use armbridge_client::toml_file::keys;
use armbridge_client::transport::LinkUri;
use armbridge_log::run_info::RunFacts;
use armbridge_log::text_table;
use armbridge_shared::JOINTS;
use armbridge_sim::link::{BoardUri, Options, Pace, drive};
use armbridge_sim::plant::PlantFile;
use clap::{Args, ValueEnum};
use serde::Serialize;
use toml::Value;

use super::finish::{Description, finish};
use super::{Error, Outcome, transparent_port};
use crate::args::suggestions::{parameters, plants, scenarios};
use crate::args::values::{angles, duration, seed};
use crate::args::{ExposeArgs, LinkArgs, OutputArgs, PaceName, VirtualServoArgs};

pub(crate) const EXAMPLES: &str = "\
Examples:
  armbridge run --list                      the scenarios that ship
  armbridge run                             the demo, simulated, as fast as possible
  armbridge run demo --control compensated  the same, friction compensated
  armbridge run push --link emulate:        on the firmware image in QEMU
  armbridge run mine.toml --link serial:    a file of your own, on a board
  armbridge run mine.toml --check           check the file; nothing moves
  armbridge run hour --duration 600 --json  ten minutes, with a summary as JSON

A scenario is a TOML file; `armbridge run NAME --show` prints one that ships, as a
starting point. Ctrl-C switches the motors off, then ends the run. The log and the plots
of the run are in a new folder in runs/.

Exit codes: 0 the run met the scenario's expectations, 1 it did not (a fault, a missed
expectation, records lost), 2 there was no run, 130 ended by ctrl-c.";

/// A scenario, and what overrides it.
#[expect(clippy::struct_excessive_bools, reason = "each is a switch of its own")]
#[derive(Args, Clone, Debug)]
pub(crate) struct RunArgs {
    /// Scenario: a file, the name of one that ships, or - for standard input; or a motion
    /// as CSV.
    #[arg(default_value = "demo", value_parser = scenarios(), hide_possible_values = true)]
    pub(crate) scenario: String,
    /// List the scenarios that ship.
    #[arg(long)]
    pub(crate) list: bool,
    /// Check the scenario without running it.
    #[arg(long)]
    pub(crate) check: bool,
    /// Print the file of a scenario that ships.
    #[arg(long, conflicts_with = "check")]
    pub(crate) show: bool,
    /// Print every key of a scenario file with its range and meaning.
    #[arg(long)]
    pub(crate) explain: bool,
    #[command(flatten)]
    pub(crate) link: LinkArgs,
    /// Controller and estimator, instead of the scenario's own.
    #[arg(long, value_enum)]
    pub(crate) control: Option<ControlName>,
    /// Change a parameter of the board for this run; may be repeated.
    #[arg(long, value_name = "KEY=VALUE", value_parser = parameters(), hide_possible_values = true)]
    pub(crate) set: Vec<(String, Value)>,
    /// Length of the run in s, instead of the scenario's own; repeated motions go on
    /// until then.
    #[arg(long, value_name = "S", value_parser = duration)]
    pub(crate) duration: Option<f64>,
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
    /// Joint angles in rad at which the arm is held until torque comes on, instead of the
    /// scenario's own.
    #[arg(long, value_name = "RAD,RAD", value_parser = angles, allow_hyphen_values = true)]
    pub(crate) initial: Option<[f64; JOINTS]>,
    /// Virtual arm instead of the scenario's own: the name of one that ships (`armbridge
    /// plants`), or a file.
    #[arg(long, value_name = "NAME|FILE", value_parser = plants(), hide_possible_values = true)]
    pub(crate) plant: Option<String>,
    /// Simulate the arm without dry friction.
    #[arg(long)]
    pub(crate) no_friction: bool,
    #[command(flatten)]
    pub(crate) servos: VirtualServoArgs,
    /// Serve the board's transparent port to another program, on a socket or by `pty:` on
    /// a new pseudo-terminal.
    #[arg(long, value_name = "tcp://HOST:PORT|pty:")]
    pub(crate) transparent: Option<LinkUri>,
    #[command(flatten)]
    pub(crate) expose: ExposeArgs,
    /// Pace of simulated time.
    #[arg(long, value_enum, default_value_t = PaceName::Free)]
    pub(crate) pace: PaceName,
}

/// Controls.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum ControlName {
    /// The board's own settings.
    Board,
    /// The paper's weights and a Luenberger observer.
    Paper,
    /// Kalman filter, stiffer gains, friction fed forward.
    Compensated,
}

impl From<ControlName> for Base {
    fn from(name: ControlName) -> Self {
        match name {
            ControlName::Board => Self::Board,
            ControlName::Paper => Self::Paper,
            ControlName::Compensated => Self::Compensated,
        }
    }
}

impl RunArgs {
    fn overrides(&self, config: &Config) -> Result<Overrides, Error> {
        let simulated = &self.simulated;
        Ok(Overrides {
            control: self.control.map(Base::from),
            set: self.set.clone(),
            configured: config.control(),
            duration_s: self.duration,
            seed: simulated.seed,
            initial_rad: simulated.initial,
            plant: simulated
                .plant
                .as_deref()
                .map(PlantFile::load)
                .transpose()?,
            friction: simulated.no_friction.then_some(false),
            servos: simulated.servos.requested()?,
            board: None,
        })
    }
}

pub(crate) fn run(args: &RunArgs) -> Outcome {
    let name = &args.scenario;
    if args.list {
        return list(args.output.json);
    }
    if args.show {
        return show(name);
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
        stdio::print_line(format_args!("{name} is in order: {}", scenario.title))?;
        for note in &scenario.notes {
            stdio::print_line(note)?;
        }
        return Ok(ExitCode::SUCCESS);
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
    let about = match scenario.about.trim() {
        "" => scenario.title.clone(),
        about => about.to_owned(),
    };
    let mut player = RunHost::in_folder(staging.task(scenario)?, folder)?;
    if let Some(baseline) = baseline {
        player.compare_with(baseline);
    }
    options.link.taps.push(player.tap());
    options.interactions = Some(player.interactions());
    let (player, result) = drive(&link, options, player);
    let description = Description {
        about: &about,
        is_simulated: link.is_simulated(),
        is_demo: args.scenario == "demo",
    };
    finish(player, result, &args.output, &description)
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

/// Link and options that a scenario runs with.
pub(super) struct Staging<'a> {
    pub(super) config: &'a Config,
    pub(super) link: &'a BoardUri,
    pub(super) pace: Pace,
    /// A link that breaks is not reported.
    pub(super) is_quiet: bool,
    /// There is no progress bar.
    pub(super) is_silent: bool,
}

impl Staging<'_> {
    /// Options of the link. Pushes are left out where the arm is real.
    pub(super) fn options(&self, scenario: &mut Scenario) -> Options {
        if !self.link.is_simulated() && !scenario.plan.pushes.is_empty() {
            stdio::note(format_args!(
                "note: at {} the scenario's {} pushes are left out; only a simulated arm is pushed",
                self.link,
                scenario.plan.pushes.len()
            ));
            scenario.plan.pushes.clear();
            scenario.expect.recovers_within_s = None;
        }
        let mut options = Options::new(scenario.bench.build());
        options.pace = self.pace;
        options.link.patience = self.config.patience();
        options.link.is_quiet = self.is_quiet;
        if !self.is_silent {
            options.board_log = |line| stdio::note(format_args!("board: {line}"));
        }
        options
    }

    /// Runs a baseline, which leaves its log in the folder and nothing else.
    fn baseline(
        &self,
        control: Base,
        scenario: Scenario,
        folder: &RunFolder,
    ) -> Result<Baseline, Error> {
        let staging = Staging {
            link: &BoardUri::Sim,
            pace: Pace::Free,
            is_silent: true,
            ..*self
        };
        let bench = scenario.bench.clone();
        let spec = RunSpec {
            judge: None,
            files: Files {
                log: BASELINE_LOG,
                csv: false,
                plots: false,
            },
            ..staging.task(scenario)?
        };
        Ok(Baseline::run(control, spec, &bench, folder.clone())?)
    }

    /// The run's specification.
    pub(super) fn task(&self, scenario: Scenario) -> Result<RunSpec, Error> {
        let Scenario {
            name,
            plan,
            settings,
            bench,
            success,
            expect,
            ..
        } = scenario;
        let is_simulated = self.link.is_simulated();
        let facts = if is_simulated {
            RunFacts::from_settings(&name, &self.link.world(), &settings)
                .simulated(bench.seed, bench.plant.static_friction_nm())
        } else {
            RunFacts::from_settings(&name, &self.link.to_string(), &settings)
        };
        armbridge_client::ctrl_c::listen()?;
        Ok(RunSpec {
            judge: Some(ExpectationMonitor::new(expect, &plan.pushes)),
            plan,
            facts,
            success,
            made_by: command_line(),
            files: Files {
                log: RUN_LOG,
                csv: self.config.writes_csv() && is_simulated,
                plots: self.config.draws_plots(),
            },
            is_patient: is_simulated && self.pace == Pace::Free,
            is_quiet: self.is_silent,
        })
    }
}

/// A scenario that ships, as it is listed.
#[derive(Serialize)]
struct Listed {
    name: &'static str,
    title: String,
    duration_s: f64,
}

fn list(as_json: bool) -> Outcome {
    let listed = BUILTINS.iter().map(|builtin| {
        let scenario = Scenario::load(builtin.name, &Overrides::default())?;
        Ok(Listed {
            name: builtin.name,
            title: scenario.title,
            duration_s: scenario.plan.stop.after_us as f64 * 1e-6,
        })
    });
    let listed: Vec<Listed> = listed.collect::<Result<_, Error>>()?;
    if as_json {
        stdio::print_line(serde_json::to_string(&listed)?)?;
        return Ok(ExitCode::SUCCESS);
    }
    let rows: Vec<Vec<String>> = listed
        .into_iter()
        .map(|row| {
            let duration = format!("{} s", row.duration_s);
            vec![row.name.into(), duration, row.title]
        })
        .collect();
    stdio::print(text_table::columns(&rows))?;
    Ok(ExitCode::SUCCESS)
}

fn show(name: &str) -> Outcome {
    let builtin = Builtin::find(name)
        .ok_or_else(|| format!("no scenario `{name}` ships: `armbridge run --list` shows them"))?;
    stdio::print(builtin.text)?;
    Ok(ExitCode::SUCCESS)
}

/// This program's command line, as it can be typed again; of the demo, if nothing was typed.
fn command_line() -> String {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let words = match &words[..] {
        [] => "run demo".to_owned(),
        words => words
            .iter()
            .map(|word| quoted(word))
            .collect::<Vec<_>>()
            .join(" "),
    };
    format!("armbridge {words}")
}

/// A word as a shell reads it.
fn quoted(word: &str) -> String {
    let is_plain = |letter: char| letter.is_alphanumeric() || "-_./:=,+@%".contains(letter);
    if !word.is_empty() && word.chars().all(is_plain) {
        word.to_owned()
    } else {
        format!("'{}'", word.replace('\'', "'\\''"))
    }
}
