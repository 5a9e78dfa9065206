//! What `run`, `demo` and `emulate` have in common: the demo's task, the bench that is
//! asked for, and how a run ends for whoever called it.

use std::process::ExitCode;

use armbridge_analysis::plan_runner::{Plan, PlanError, Script};
use armbridge_analysis::run;
use armbridge_analysis::run::{Files, Finished, Player, Task};
use armbridge_analysis::scenario::Success;
use armbridge_client::Host;
use armbridge_client::LinkError;
use armbridge_log::run_info::RunFacts;
use armbridge_shared::JOINTS;
use armbridge_shared::arm::State;
use armbridge_shared::link::message::{Settings, Setup};
use armbridge_sim::Bench;
use armbridge_sim::cosim::Client;
use armbridge_sim::link::Options;
use armbridge_sim::plant::{Plant, PlantConfig, PlantFile};
use armbridge_sim::usb2dynamixel_server::RemoteClient;

use super::{Error, Outcome};
use crate::cli::{ArmArgs, DemoArgs, OutputArgs, TransparentArgs};

/// Where the arm is held at first, in rad, unless asked otherwise.
const INITIAL_RAD: [f64; JOINTS] = [0.30, -0.25];

/// The virtual arm, held at its initial angles.
pub(crate) fn plant(args: &ArmArgs) -> Result<Plant, Error> {
    Ok(Plant::new(plant_config(args)?, args.seed))
}

/// What it is.
pub(crate) fn plant_config(args: &ArmArgs) -> Result<PlantConfig, Error> {
    let mut plant = match &args.plant {
        Some(path) => PlantFile::read(path)?.config(INITIAL_RAD),
        None => PlantConfig {
            initial: State::at_rest(INITIAL_RAD.into()),
            ..PlantConfig::default()
        },
    };
    if let Some(initial) = args.initial {
        plant.initial.q = initial.into();
    }
    if args.no_friction {
        plant.friction_on = false;
    }
    Ok(plant)
}

/// The virtual servos and arm, and the program at the transparent port, that are asked
/// for.
pub(crate) fn options(args: &DemoArgs) -> Result<Options, Error> {
    let bench = Bench::with_servos(plant(&args.arm)?, &args.servos.kinds()?);
    let mut options = Options::new(bench);
    options.client = client(&args.port)?;
    Ok(options)
}

/// The program at the transparent port that is asked for.
fn client(args: &TransparentArgs) -> Result<Option<Box<dyn Client>>, Error> {
    if let Some(endpoint) = &args.transparent_listen {
        let (listener, at) = endpoint.listen()?;
        eprintln!("transparent port on {at}, raw bus bytes");
        return Ok(Some(Box::new(RemoteClient::on_socket(listener)?)));
    }
    if args.transparent_pty {
        return on_terminal().map(Some);
    }
    Ok(None)
}

#[cfg(unix)]
fn on_terminal() -> Result<Box<dyn Client>, Error> {
    let pty = armbridge_client::pty::Pty::open()?;
    eprintln!("transparent port, raw bus bytes:");
    println!("{}", pty.name());
    Ok(Box::new(RemoteClient::on_terminal(pty)?))
}

#[cfg(not(unix))]
fn on_terminal() -> Result<Box<dyn Client>, Error> {
    Err(
        "there are no pseudo-terminals on this system: use --transparent-listen \
         tcp://127.0.0.1:PORT"
            .into(),
    )
}

/// Nobody at the control link, for ever.
pub(crate) struct Nobody;

impl Host for Nobody {
    type Error = std::convert::Infallible;

    fn transmit(&mut self, _now_us: u64) -> Result<&[u8], Self::Error> {
        Ok(&[])
    }

    fn receive(&mut self, _now_us: u64, _bytes: &[u8]) -> Result<(), Self::Error> {
        Ok(())
    }

    fn wake_at_us(&self) -> u64 {
        u64::MAX
    }

    fn is_done(&self) -> bool {
        false
    }
}

/// What there was with nobody at the link.
pub(crate) fn left_alone(result: Result<(), LinkError<std::convert::Infallible>>) -> Outcome {
    result?;
    Ok(ExitCode::SUCCESS)
}

/// A player of the demo's script; time waits for the disk, or not.
pub(crate) fn player(
    args: &DemoArgs,
    name: &str,
    world: &str,
    is_patient: bool,
) -> Result<Player, Error> {
    let setup = Setup {
        period_us: args.period_us,
        ..if args.compensate {
            Setup::best()
        } else {
            Setup::default()
        }
    };
    let settings = Settings {
        setup,
        ..Settings::default()
    };
    let script = Script::demo(setup, (args.duration * 1e6) as u64);
    let task = Task {
        plan: Plan {
            is_releasing: args.release,
            ..script.into()
        },
        facts: RunFacts::of(name, world, &settings)
            .simulated(args.arm.seed, plant_config(&args.arm)?.static_friction_nm()),
        success: vec![Success::Time],
        judge: None,
        files: Files {
            csv: true,
            plots: true,
        },
        is_patient,
        is_quiet: args.output.quiet || args.output.json,
    };
    armbridge_client::interrupt::listen()?;
    Ok(Player::new(task, args.output.out.as_deref())?)
}

/// Ends a run: its files, its summary, its exit code.
pub(crate) fn finish(
    player: Player,
    result: Result<(), LinkError<PlanError>>,
    output: &OutputArgs,
) -> Outcome {
    let Finished {
        summary,
        folder,
        verdict,
    } = player.finish(result)?;
    let path = folder.display();
    if output.json {
        run::print(&serde_json::to_string(&summary)?, &folder)?;
    } else if !output.quiet {
        run::print(&format!("{}\n{path}", summary.table()), &folder)?;
    }
    if let Some(ended) = &summary.ended {
        eprintln!("armbridge: the run ended early: {ended}");
    }
    Ok(ExitCode::from(verdict.exit_code()))
}
