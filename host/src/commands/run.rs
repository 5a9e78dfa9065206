//! `armbridge run`: a scenario, on whatever link.

use std::process::ExitCode;

use armbridge::config::Config;
use armbridge::facts::RunFacts;
use armbridge::links::{LinkUri, Options, Pace, drive};
use armbridge::player::{Files, Player, Task};
use armbridge::scenario::{Judge, Overrides, SHIPPED, Scenario, Shipped};
use armbridge::table;
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
    let world = World::of(&link);
    if let (None, false) = (world, scenario.plan.pushes.is_empty()) {
        eprintln!(
            "note: nobody pushes the arm at {link}; its {} pushes are for sim: and emulate:",
            scenario.plan.pushes.len()
        );
        scenario.plan.pushes.clear();
        scenario.expect.recovers_within_s = None;
    }
    let mut options = Options::new(scenario.bench.build());
    options.pace = args.pace.into();
    options.patience = config.patience();
    options.is_quiet = args.output.quiet;
    let player = player(args, &config, &link, world, scenario)?;
    options.taps.push(player.tap());
    let (player, result) = drive(&link, options, player);
    job::finish(player, result, &args.output)
}

/// What of a link is simulated.
#[derive(Clone, Copy)]
struct World(&'static str);

impl World {
    /// `None` where the arm is real, or somebody else's.
    fn of(link: &LinkUri) -> Option<Self> {
        match link {
            LinkUri::Sim => Some(Self("simulated: bench")),
            LinkUri::Emulate(_) => Some(Self("simulated: QEMU mps2-an386")),
            LinkUri::Usb(_) | LinkUri::Serial(_) | LinkUri::Tcp(_) | LinkUri::Pty(_) => None,
        }
    }
}

fn player(
    args: &RunArgs,
    config: &Config,
    link: &LinkUri,
    world: Option<World>,
    scenario: Scenario,
) -> Result<Player, Error> {
    let Scenario {
        name,
        plan,
        settings,
        bench,
        success,
        expect,
        ..
    } = scenario;
    let facts = match world {
        Some(World(world)) => {
            RunFacts::of(&name, world, &settings).simulated(bench.seed, &bench.plant)
        }
        None => RunFacts::of(&name, &link.to_string(), &settings),
    };
    let task = Task {
        judge: Some(Judge::new(expect, &plan.pushes)),
        plan,
        facts,
        success,
        files: Files {
            csv: config.writes_csv() && world.is_some(),
            plots: config.draws_plots(),
        },
        is_patient: world.is_some() && Pace::from(args.pace) == Pace::Free,
        is_quiet: args.output.quiet || args.output.json,
    };
    armbridge::interrupt::listen()?;
    Ok(Player::new(
        task,
        Some(&config.out(args.output.out.as_deref())),
    )?)
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
