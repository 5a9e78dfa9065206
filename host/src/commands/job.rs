//! The demo's job, whoever runs the board: an operator who works through the
//! script, a progress bar, and at the end the run folder and the summary.

use std::io::Write;
use std::process::ExitCode;
use std::time::Duration;

use armbridge::bench::cosim::Host;
use armbridge::bench::plant::{Plant, PlantConfig};
use armbridge::facts::RunFacts;
use armbridge::log::{CsvWriter, McapWriter};
use armbridge::operator::{Operator, OperatorError, Script};
use armbridge::plot;
use armbridge::progress::Progress;
use armbridge::run_folder::RunFolder;
use armbridge::summary::Summary;
use armbridge_shared::JOINTS;
use armbridge_shared::actuator::{Joint, Pwm};
use armbridge_shared::arm::{Parameters, State};
use armbridge_shared::control::{Lqr, Weights};
use armbridge_shared::link::message::Setup;
use nalgebra::Vector2;

use super::Outcome;
use crate::cli::{ArmArgs, OutputArgs, RunArgs};

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
        let duration_us = (args.duration * 1e6) as u64;
        Ok(Self {
            operator: Operator::new(Script::demo(setup, duration_us)),
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

        let summary = Summary::of(&records, &facts, link, duration_s, wall.as_secs_f64());
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
