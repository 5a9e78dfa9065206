//! The demo's job, whoever runs the board: an operator who works through the
//! script, a progress bar, and at the end the run folder and the summary.

use std::io::Write;
use std::process::ExitCode;
use std::time::Duration;

use armbridge::bench::Bench;
use armbridge::bench::board::Board;
use armbridge::bench::cosim::{Cosim, Host};
use armbridge::bench::plant::{Plant, PlantConfig};
use armbridge::facts::RunFacts;
use armbridge::log::{CsvWriter, McapWriter};
use armbridge::operator::{Operator, OperatorError, Script};
use armbridge::plot;
use armbridge::progress::Progress;
use armbridge::run_folder::RunFolder;
use armbridge::summary::{ServoSummary, Summary};
use armbridge::transparent::RemoteClient;
use armbridge_shared::JOINTS;
use armbridge_shared::actuator::{Joint, Pwm};
use armbridge_shared::arm::{Parameters, State};
use armbridge_shared::control::{Lqr, Weights};
use armbridge_shared::link::message::{PortCounters, Setup};
use nalgebra::Vector2;

use super::Outcome;
use crate::cli::{ArmArgs, OutputArgs, RunArgs, TransparentArgs};

/// Where the arm is held at first, in rad, unless asked otherwise.
const INITIAL_RAD: [f64; JOINTS] = [0.30, -0.25];

/// Virtual time between two looks at the progress bar.
const LOOK_US: u64 = 50_000;

/// The virtual arm, held at its initial angles.
pub(crate) fn plant(args: &ArmArgs) -> Plant {
    let initial = Vector2::from(args.initial.unwrap_or(INITIAL_RAD));
    let config = PlantConfig {
        initial: State::at_rest(initial),
        friction_on: !args.no_friction,
        ..PlantConfig::default()
    };
    Plant::new(config, args.seed)
}

/// The virtual servos and arm that are asked for.
pub(crate) fn bench(args: &RunArgs) -> Result<Bench, Box<dyn std::error::Error>> {
    Ok(Bench::with_servos(plant(&args.arm), &args.servos.kinds()?))
}

/// The same board and bench, with the program at the transparent port that is
/// asked for.
pub(crate) fn with_port<B: Board, H: Host>(
    cosim: Cosim<B, H>,
    args: &TransparentArgs,
) -> Result<Cosim<B, H>, Box<dyn std::error::Error>> {
    if let Some(endpoint) = &args.transparent_listen {
        let (listener, at) = endpoint.listen()?;
        eprintln!("transparent port on {at}, raw bus bytes");
        return Ok(cosim.with_client(RemoteClient::on_socket(listener)?));
    }
    if args.transparent_pty {
        return on_terminal(cosim);
    }
    Ok(cosim)
}

#[cfg(unix)]
fn on_terminal<B: Board, H: Host>(
    cosim: Cosim<B, H>,
) -> Result<Cosim<B, H>, Box<dyn std::error::Error>> {
    let pty = armbridge::pty::Pty::open()?;
    eprintln!("transparent port, raw bus bytes:");
    println!("{}", pty.name());
    Ok(cosim.with_client(RemoteClient::on_terminal(pty)?))
}

#[cfg(not(unix))]
fn on_terminal<B: Board, H: Host>(
    _: Cosim<B, H>,
) -> Result<Cosim<B, H>, Box<dyn std::error::Error>> {
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

    fn speak(&mut self, _now_us: u64) -> Result<&[u8], Self::Error> {
        Ok(&[])
    }

    fn hear(&mut self, _now_us: u64, _bytes: &[u8]) -> Result<(), Self::Error> {
        Ok(())
    }

    fn wake_at_us(&self) -> u64 {
        u64::MAX
    }

    fn is_done(&self) -> bool {
        false
    }
}

/// A run under way.
pub(crate) struct Job {
    operator: Operator,
    progress: Progress,
    folder: RunFolder,
    facts: RunFacts,
    duration_s: f64,
    look_us: u64,
    output: OutputArgs,
}

impl Job {
    /// Makes the run folder and an operator with the demo's script.
    pub(crate) fn new(
        args: &RunArgs,
        name: &str,
        world: &str,
    ) -> Result<Self, Box<dyn std::error::Error>> {
        let setup = Setup {
            period_us: args.period_us,
            ..if args.compensate {
                Setup::best()
            } else {
                Setup::default()
            }
        };
        let script = Script::demo(setup, (args.duration * 1e6) as u64);
        Ok(Self {
            operator: if args.release {
                Operator::new(script).releasing()
            } else {
                Operator::new(script)
            },
            progress: Progress::new(args.duration, args.output.quiet || args.output.json),
            folder: RunFolder::create(args.output.out.as_deref(), name)?,
            facts: facts(args, name, world, setup)?,
            duration_s: args.duration,
            look_us: 0,
            output: args.output.clone(),
        })
    }

    /// Writes the run folder and shows the summary.
    pub(crate) fn finish(self, wall: Duration) -> Outcome {
        let Self {
            operator,
            progress,
            folder,
            facts,
            duration_s,
            output,
            ..
        } = self;
        progress.finish();
        let servos = operator.found().map(|(firmware, baud)| ServoSummary {
            firmware: firmware.to_string(),
            baud,
        });
        let port = operator.port();
        let trips = operator.trips().to_vec();
        let (records, commands, link) = operator.into_parts();

        let mut mcap = McapWriter::create(&folder.file("run.mcap"), &facts)?;
        let mut csv = CsvWriter::create(&folder.file("run.csv"))?;
        for (at_us, command) in &commands {
            mcap.command(*at_us, command)?;
        }
        for record in &records {
            mcap.record(record)?;
            csv.record(record)?;
        }
        mcap.finish()?;
        csv.finish()?;
        plot::draw_all(folder.path(), &facts, &records)?;

        let mut summary =
            Summary::of(&records, &facts, link, duration_s, wall.as_secs_f64()).with_causes(&trips);
        summary.servos = servos;
        summary.port = (port != PortCounters::default()).then_some(port);
        let path = folder.path().display();
        let mut out = std::io::stdout();
        let printed = if output.json {
            writeln!(out, "{}", serde_json::to_string(&summary)?)
        } else if output.quiet {
            Ok(())
        } else {
            writeln!(out, "{}\n{path}", summary.table())
        };
        printed
            .map_err(|error| format!("cannot print the summary: {error}; the run is in {path}"))?;
        Ok(ExitCode::from(u8::from(!summary.faults.is_empty())))
    }
}

impl Host for Job {
    type Error = OperatorError;

    fn speak(&mut self, now_us: u64) -> Result<&[u8], OperatorError> {
        if now_us >= self.look_us {
            self.look_us = now_us + LOOK_US;
            self.progress
                .at(self.operator.fraction(now_us) * self.duration_s);
        }
        self.operator.speak(now_us)
    }

    fn hear(&mut self, now_us: u64, bytes: &[u8]) -> Result<(), OperatorError> {
        self.operator.hear(now_us, bytes)
    }

    fn wake_at_us(&self) -> u64 {
        self.operator.wake_at_us()
    }

    fn is_done(&self) -> bool {
        self.operator.is_done()
    }
}

/// What is known before the first tick.
fn facts(
    args: &RunArgs,
    name: &str,
    world: &str,
    setup: Setup,
) -> Result<RunFacts, Box<dyn std::error::Error>> {
    let joint = Joint::<f64>::paper();
    let static_friction_nm =
        (!args.arm.no_friction).then(|| PlantConfig::default().friction.map(|f| f.static_nm));
    let offset_mrad = |friction_nm: [f64; JOINTS]| {
        let stiffness = net_stiffness(args.period_us)
            .map_err(|error| format!("no gain for this period: {error:?}"))?;
        Ok::<_, String>([0, 1].map(|j| 1e3 * friction_nm[j] / stiffness[j]))
    };
    Ok(RunFacts {
        name: name.into(),
        world: world.into(),
        version: env!("CARGO_PKG_VERSION").into(),
        seed: Some(args.arm.seed),
        period_us: args.period_us,
        setup,
        rad_per_count: [joint.rad_per_count; JOINTS],
        zero_count: [joint.zero_count; JOINTS],
        torque_limits_nm: [[joint.torque(Pwm::MIN), joint.torque(Pwm::MAX)]; JOINTS],
        static_friction_nm,
        stiction_offset_mrad: static_friction_nm.map(offset_mrad).transpose()?,
    })
}

/// Torque per angle in N m/rad with which the loop pulls the arm upright: the
/// gain on the angle, less what gravity pushes.
fn net_stiffness(
    period_us: u32,
) -> Result<[f64; JOINTS], armbridge_shared::design::riccati::Error> {
    let arm = Parameters::<f64>::paper();
    let upright = Vector2::zeros();
    let model = arm
        .linearise(upright)
        .zero_order_hold(f64::from(period_us) * 1e-6);
    let gain = Lqr::design(&model, &Weights::paper())?.gain;
    let gravity = arm.gravity_slope(upright);
    Ok([0, 1].map(|j| gain[(j, j)] + gravity[(j, j)]))
}
