//! `armbridge run`: a scenario, on whatever link.

use std::process::ExitCode;

use armbridge::config::Config;
use armbridge_analysis::run::{Files, Player, Task};
use armbridge_analysis::scenario::{Judge, Overrides, SHIPPED, Scenario, Shipped};
use armbridge_log::run_info::RunFacts;
use armbridge_log::table;
use armbridge_sim::link::{BoardUri, Options, Pace, drive};
use armbridge_sim::plant::PlantFile;
use serde::Serialize;

use super::{Error, Outcome, job};
use crate::cli::RunArgs;

pub(crate) fn run(args: &RunArgs) -> Outcome {
    let Some(name) = args.scenario.as_deref() else {
        return list(args.output.json);
    };
    if args.show {
        return show(name);
    }
    let overrides = Overrides {
        duration_s: args.duration,
        seed: args.seed,
        initial_rad: None,
        plant: args.plant.as_deref().map(PlantFile::read).transpose()?,
        board: None,
    };
    let mut scenario = Scenario::load(name, &overrides)?;
    if args.check {
        println!("{name} is in order: {}", scenario.title);
        return Ok(ExitCode::SUCCESS);
    }
    scenario.plan.is_clearing = args.clear;
    scenario.plan.is_releasing = args.release;

    let config = Config::discover()?;
    let link = config.link(args.link.link.as_ref())?;
    let staging = Staging {
        config: &config,
        link: &link,
        pace: args.pace.into(),
        is_quiet: args.output.quiet,
        is_silent: args.output.quiet || args.output.json,
    };
    let mut options = staging.options(&mut scenario);
    let base = config.out(args.output.out.as_deref());
    let mut player = Player::new(staging.task(scenario)?, Some(&base))?;
    options.link.taps.push(player.tap());
    options.interactions = Some(player.interactions());
    let (player, result) = drive(&link, options, player);
    job::finish(player, result, &args.output)
}

/// What a scenario is played on, and how.
pub(super) struct Staging<'a> {
    pub(super) config: &'a Config,
    pub(super) link: &'a BoardUri,
    pub(super) pace: Pace,
    /// Nothing is said of a link that breaks.
    pub(super) is_quiet: bool,
    /// There is no progress bar.
    pub(super) is_silent: bool,
}

impl Staging<'_> {
    /// What the link is opened with. A real arm is pushed by nobody.
    pub(super) fn options(&self, scenario: &mut Scenario) -> Options {
        if !self.link.is_simulated() && !scenario.plan.pushes.is_empty() {
            eprintln!(
                "note: nobody pushes the arm at {}; its {} pushes are for sim: and emulate:",
                self.link,
                scenario.plan.pushes.len()
            );
            scenario.plan.pushes.clear();
            scenario.expect.recovers_within_s = None;
        }
        let mut options = Options::new(scenario.bench.build());
        options.pace = self.pace;
        options.link.patience = self.config.patience();
        options.link.is_quiet = self.is_quiet;
        options
    }

    /// What the player is to do.
    pub(super) fn task(&self, scenario: Scenario) -> Result<Task, Error> {
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
            RunFacts::of(&name, &self.link.world(), &settings)
                .simulated(bench.seed, bench.plant.static_friction_nm())
        } else {
            RunFacts::of(&name, &self.link.to_string(), &settings)
        };
        armbridge_client::interrupt::listen()?;
        Ok(Task {
            judge: Some(Judge::new(expect, &plan.pushes)),
            plan,
            facts,
            success,
            files: Files {
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
    let listed = SHIPPED.iter().map(|shipped| {
        let scenario = Scenario::load(shipped.name, &Overrides::default())?;
        Ok(Listed {
            name: shipped.name,
            title: scenario.title,
            duration_s: scenario.plan.stop.after_us as f64 * 1e-6,
        })
    });
    let listed: Vec<Listed> = listed.collect::<Result<_, Error>>()?;
    if as_json {
        println!("{}", serde_json::to_string(&listed)?);
        return Ok(ExitCode::SUCCESS);
    }
    let rows: Vec<Vec<String>> = listed
        .into_iter()
        .map(|row| {
            let duration = format!("{} s", row.duration_s);
            vec![row.name.into(), duration, row.title]
        })
        .collect();
    print!("{}", table::columns(&rows));
    Ok(ExitCode::SUCCESS)
}

fn show(name: &str) -> Outcome {
    let shipped = Shipped::find(name)
        .ok_or_else(|| format!("no scenario `{name}` ships: `armbridge run --list` shows them"))?;
    print!("{}", shipped.text);
    Ok(ExitCode::SUCCESS)
}
