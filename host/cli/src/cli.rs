//! The command line.

mod bench;
mod bus;
mod design;
mod errand;
mod examples;
mod identify;
mod link;
mod live;
mod look;
mod params;
mod replay;
mod root;
mod run;
mod servos;
mod session;
mod shell;
mod surroundings;
mod torture;
mod watch;

pub(crate) use bench::{BenchArgs, ControlArgs, ControllerName, EstimateArgs, EstimatorName};
pub(crate) use bus::{LineArgs, ScanArgs, ServoAction, ServoArgs, value as register_value};
pub(crate) use design::{DesignArgs, DesignControlArgs};
pub(crate) use errand::{ArmedArgs, CalibrateArgs, ErrandArgs};
pub(crate) use identify::{FitArgs, Identify, IdentifyArgs, IdentifyRunArgs, PaperArgs};
pub(crate) use link::LinkArgs;
pub(crate) use live::LiveArgs;
pub(crate) use look::{DiffArgs, ExportArgs, FormatName, InfoArgs, Picture, PlotArgs, What};
pub(crate) use params::{GetArgs, SetArgs};
pub(crate) use replay::ReplayArgs;
pub(crate) use run::RunArgs;
pub(crate) use servos::ServosArgs;
pub(crate) use session::SessionArgs;
pub(crate) use shell::{CompletionsArgs, ConfigArgs, ManArgs};
pub(crate) use surroundings::{TransparentArgs, VirtualServoArgs};
pub(crate) use torture::TortureArgs;
pub(crate) use watch::WatchArgs;

use std::path::PathBuf;

use clap::{Args, CommandFactory, FromArgMatches, Parser, Subcommand};

use armbridge_client::endpoint::Endpoint;
use armbridge_client::transport::LinkUri;

/// Deterministic control of a two-joint Dynamixel arm.
#[derive(Debug, Parser)]
#[command(name = "armbridge", version, args_conflicts_with_subcommands = true)]
pub(crate) struct Cli {
    #[command(subcommand)]
    pub(crate) command: Option<Command>,
    /// Without a command: `demo`.
    #[command(flatten)]
    pub(crate) demo: DemoArgs,
}

/// The program, with all its commands.
pub(crate) fn command() -> clap::Command {
    root::with_help(Cli::command())
}

/// What was typed.
pub(crate) fn parse() -> Result<Cli, clap::Error> {
    Cli::from_arg_matches(&command().try_get_matches()?)
}

/// What to do.
#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    /// Balance the virtual arm by the code of the board, run in this process.
    #[command(after_help = examples::DEMO)]
    Demo(DemoArgs),
    /// The same by the firmware image, run under QEMU.
    #[command(after_help = examples::EMULATE)]
    Emulate(EmulateArgs),
    /// Play a scenario: setpoints, motions, gains and pushes on a timeline.
    #[command(after_help = run::EXAMPLES)]
    Run(RunArgs),
    /// Serve the virtual servos and arm to other programs, in wall-clock time.
    #[command(after_help = examples::SERVOS)]
    Servos(ServosArgs),
    /// Tell what the board says of itself, of its servos, and how the link does.
    #[command(after_help = errand::STATUS_EXAMPLES)]
    Status(ErrandArgs),
    /// Make the arm ready to move, with zero torque, and stay until ctrl-c.
    #[command(after_help = errand::ARM_EXAMPLES)]
    Arm(ArmedArgs),
    /// Switch the motors off.
    #[command(after_help = errand::DISARM_EXAMPLES)]
    Disarm(ErrandArgs),
    /// Emergency stop.
    #[command(after_help = errand::STOP_EXAMPLES)]
    Stop(ErrandArgs),
    /// Clear a latched fault.
    #[command(after_help = errand::CLEAR_EXAMPLES)]
    Clear(ErrandArgs),
    /// Find each joint's zero and sign, guided, and save them on the board.
    #[command(after_help = errand::CALIBRATE_EXAMPLES)]
    Calibrate(CalibrateArgs),
    /// Find the servos on a bus.
    #[command(after_help = bus::SCAN_EXAMPLES)]
    Scan(ScanArgs),
    /// Read and write one servo's registers, and change its id or baud rate.
    #[command(after_help = bus::SERVO_EXAMPLES)]
    Servo(ServoArgs),
    /// Try any controller and estimator on any virtual arm, for many seeds.
    #[command(after_help = bench::EXAMPLES)]
    Bench(BenchArgs),
    /// Inject every kind of fault on the bench, and judge what the board makes of it.
    #[command(after_help = torture::EXAMPLES)]
    Torture(TortureArgs),
    /// Show the board's parameters: gains, limits, calibration, model.
    #[command(after_help = params::GET_EXAMPLES)]
    Get(GetArgs),
    /// Change the board's parameters, as one group.
    #[command(after_help = params::SET_EXAMPLES)]
    Set(SetArgs),
    /// Design gains, and see poles, margins and an answer to a step.
    #[command(after_help = design::EXAMPLES)]
    Design(Box<DesignArgs>),
    /// Find out what an arm is, from its logs.
    #[command(after_help = identify::EXAMPLES)]
    Identify(IdentifyArgs),
    /// Show what armbridge.toml and the environment say, and what they could.
    #[command(after_help = shell::CONFIG_EXAMPLES)]
    Config(ConfigArgs),
    /// Print the completions of a shell.
    #[command(after_help = shell::COMPLETIONS_EXAMPLES)]
    Completions(CompletionsArgs),
    /// Print the manual page, or write those of all commands.
    #[command(after_help = shell::MAN_EXAMPLES)]
    Man(ManArgs),
    /// Tell what a log holds: run, gaps, faults, commands, settings, clocks.
    #[command(after_help = look::INFO_EXAMPLES)]
    Info(InfoArgs),
    /// Draw a log, or two logs on top of each other.
    #[command(after_help = look::PLOT_EXAMPLES)]
    Plot(PlotArgs),
    /// Write a log as CSV, Parquet or .mat.
    #[command(after_help = look::EXPORT_EXAMPLES)]
    Export(ExportArgs),
    /// Tell where two logs differ: settings, commands, outputs.
    #[command(after_help = look::DIFF_EXAMPLES)]
    Diff(DiffArgs),
    /// Watch and steer a board on a dashboard in the terminal.
    #[command(after_help = watch::EXAMPLES)]
    Watch(WatchArgs),
    /// Put a log's inputs through the board's code again, and compare bit for bit.
    #[command(after_help = replay::EXAMPLES)]
    Replay(ReplayArgs),
    /// Serve the topics of a log to viewers such as Foxglove, as they happen.
    #[command(after_help = live::EXAMPLES)]
    Live(LiveArgs),
    /// Compute the paper's numbers and figures again, as a page with verdicts.
    #[command(after_help = examples::PAPER)]
    Paper(OutputArgs),
}

/// The virtual arm.
#[derive(Args, Clone, Debug)]
pub(crate) struct ArmArgs {
    /// Seed of the encoders' noise.
    #[arg(long, default_value_t = 1)]
    pub(crate) seed: u64,
    /// Joint angles in rad at which the arm is held until torque comes on
    /// [default: 0.3,-0.25, unless the plant file says where].
    #[arg(long, value_name = "RAD,RAD", value_parser = angles, allow_hyphen_values = true)]
    pub(crate) initial: Option<[f64; 2]>,
    /// The virtual arm, as host/plants/default.toml describes it.
    #[arg(long, value_name = "FILE")]
    pub(crate) plant: Option<PathBuf>,
    /// Take dry friction off the virtual arm.
    #[arg(long)]
    pub(crate) no_friction: bool,
}

/// What is written and shown of a run.
#[derive(Args, Clone, Debug)]
pub(crate) struct OutputArgs {
    /// Folder in which the run folder is made.
    #[arg(long, value_name = "DIR")]
    pub(crate) out: Option<PathBuf>,
    /// No progress bar, no table.
    #[arg(long)]
    pub(crate) quiet: bool,
    /// Print the summary as one JSON object instead of the table.
    #[arg(long)]
    pub(crate) json: bool,
}

/// A run of the demo's script.
#[derive(Args, Clone, Debug)]
pub(crate) struct DemoArgs {
    /// Simulated time in s from the first setpoint on.
    #[arg(long, value_name = "S", default_value_t = 10.0, value_parser = duration)]
    pub(crate) duration: f64,
    /// Tick period in µs.
    #[arg(long, value_name = "US", default_value_t = 1_000, value_parser = period)]
    pub(crate) period_us: u32,
    /// Let the board overcome friction: a Kalman filter that finds the torques
    /// nobody commanded, and friction fed forward.
    #[arg(long)]
    pub(crate) compensate: bool,
    /// In the end, give stock servos back the mode and the return delay they were
    /// found with.
    #[arg(long)]
    pub(crate) release: bool,
    #[command(flatten)]
    pub(crate) arm: ArmArgs,
    #[command(flatten)]
    pub(crate) servos: VirtualServoArgs,
    #[command(flatten)]
    pub(crate) port: TransparentArgs,
    #[command(flatten)]
    pub(crate) output: OutputArgs,
}

/// A run of the firmware image.
#[derive(Args, Debug)]
pub(crate) struct EmulateArgs {
    #[command(flatten)]
    pub(crate) run: DemoArgs,
    /// Firmware image; by default what `cargo build-emulator` made.
    #[arg(long, value_name = "ELF")]
    pub(crate) image: Option<PathBuf>,
    /// Give every instruction a fixed virtual time, so that measured compute
    /// times repeat.
    #[arg(long)]
    pub(crate) icount: bool,
    /// Connect the servo bus to somebody else's raw byte stream instead of the
    /// virtual servos. The board then runs in wall-clock time.
    #[arg(long = "bus", value_name = "tcp://HOST:PORT",
          conflicts_with_all = ["transparent_listen", "transparent_pty", "disarmed"])]
    pub(crate) bus: Option<Endpoint>,
    /// How many times slower than the wall clock the board's time runs on a bus
    /// of somebody else's, whose bytes take their time.
    #[arg(long, value_name = "TIMES", default_value_t = 50, requires = "bus",
          value_parser = clap::value_parser!(u32).range(1..=10_000))]
    pub(crate) slow: u32,
    /// Offer the control link to another program instead of running the demo: on a
    /// socket, or by `pty:` on a new pseudo-terminal.
    #[arg(long, value_name = "tcp://HOST:PORT|pty:")]
    pub(crate) link_listen: Option<LinkUri>,
}

/// Longest run: a day.
const DURATION_MAX_S: f64 = 86_400.0;

fn duration(text: &str) -> Result<f64, String> {
    match text.parse() {
        Ok(seconds) if (0.1..=DURATION_MAX_S).contains(&seconds) => Ok(seconds),
        _ => Err(format!("expected seconds from 0.1 to {DURATION_MAX_S}")),
    }
}

fn period(text: &str) -> Result<u32, String> {
    use armbridge_shared::bridge::limits::{PERIOD_MAX_US, PERIOD_MIN_US};
    match text.parse() {
        Ok(us) if (PERIOD_MIN_US..=PERIOD_MAX_US).contains(&us) => Ok(us),
        _ => Err(format!(
            "expected microseconds from {PERIOD_MIN_US} to {PERIOD_MAX_US}"
        )),
    }
}

/// Largest initial angle: inside the board's angle limit.
const INITIAL_MAX_RAD: f64 = 1.4;

fn angles(text: &str) -> Result<[f64; 2], String> {
    numbers(text)
        .filter(|angles: &[f64; 2]| angles.iter().all(|q| q.abs() <= INITIAL_MAX_RAD))
        .ok_or_else(|| {
            format!(
                "expected two angles from -{INITIAL_MAX_RAD} to {INITIAL_MAX_RAD} rad, as 0.3,-0.25"
            )
        })
}

/// So many numbers with commas between.
fn numbers<T: std::str::FromStr + Copy, const N: usize>(text: &str) -> Option<[T; N]> {
    let numbers: Result<Vec<T>, _> = text.split(',').map(|x| x.trim().parse()).collect();
    numbers.ok()?.try_into().ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn arguments_are_consistent_and_mistakes_are_named() {
        Cli::command().debug_assert();
        let parse = |args: &[&str]| Cli::try_parse_from([&["armbridge"], args].concat());
        let demo = parse(&["--initial", "-0.2,0.2", "--seed", "7"])
            .unwrap()
            .demo;
        assert_eq!((demo.arm.initial, demo.arm.seed), (Some([-0.2, 0.2]), 7));
        for (args, word) in [
            (["--duration", "0"].as_slice(), "seconds"),
            (&["--period-us", "10"], "microseconds"),
            (&["--initial", "9,9"], "two angles"),
            (&["servos", "--listen", "udp://x"], "tcp://HOST:PORT"),
            (&["servos"], "--listen"),
        ] {
            let error = parse(args).unwrap_err().to_string();
            assert!(error.contains(word), "{args:?}: {error}");
        }
    }
}
