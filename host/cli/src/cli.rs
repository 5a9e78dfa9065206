//! The command line: its commands, and the names that they had before.

mod help;
mod suggestion;

use clap::{CommandFactory, FromArgMatches, Parser, Subcommand};

use crate::args::{OutputArgs, TaskArgs};
use crate::commands::{
    Outcome, arm, calibrate, clear, completions, config, design, diff, disarm, doctor, export,
    fault_campaign, foxglove, hand, identify, info, man, merge, paper, params, plants, plot, push,
    replay, run, scan, serve, servo, setup, status, stop, sweep, teach, trials, watch,
};

/// Deterministic control of a two-joint Dynamixel arm.
#[derive(Debug, Parser)]
#[command(name = "armbridge", version)]
pub(crate) struct Cli {
    /// Without one: `run demo`.
    #[command(subcommand)]
    pub(crate) command: Option<Command>,
}

/// Commands.
#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    /// Run a scenario: a timeline of setpoints, motions and pushes.
    #[command(after_help = run::EXAMPLES)]
    Run(Box<run::RunArgs>),
    /// Watch and steer a board on a dashboard in the terminal.
    #[command(after_help = watch::EXAMPLES)]
    Watch(watch::WatchArgs),
    /// Serve the topics of a log live to viewers such as Foxglove.
    #[command(after_help = foxglove::EXAMPLES)]
    Foxglove(foxglove::FoxgloveArgs),
    /// Go from an assembled board to the first motion, step by step.
    #[command(after_help = setup::EXAMPLES)]
    Setup(setup::SetupArgs),
    /// Show board, servo and link status.
    #[command(after_help = status::EXAMPLES)]
    Status(status::StatusArgs),
    /// Make the arm ready to move, with zero torque, until ctrl-c.
    #[command(after_help = arm::EXAMPLES)]
    Arm(arm::ArmedArgs),
    /// Switch the motors off.
    #[command(after_help = disarm::EXAMPLES)]
    Disarm(TaskArgs),
    /// Emergency stop.
    #[command(after_help = stop::EXAMPLES)]
    Stop(TaskArgs),
    /// Clear a latched fault.
    #[command(after_help = clear::EXAMPLES)]
    Clear(TaskArgs),
    /// Find each joint's zero and direction by hand, and save them.
    #[command(after_help = calibrate::EXAMPLES)]
    Calibrate(calibrate::CalibrateArgs),
    /// Find the servos on a bus.
    #[command(after_help = scan::EXAMPLES)]
    Scan(scan::ScanArgs),
    /// Read and write a servo's registers; change its id or baud rate.
    #[command(after_help = servo::EXAMPLES)]
    Servo(servo::ServoArgs),
    /// Show or change the board's gains, limits, calibration and model.
    #[command(after_help = params::EXAMPLES)]
    Params(params::ParamsArgs),
    /// Design gains; show poles, margins and the step response.
    #[command(after_help = design::EXAMPLES)]
    Design(Box<design::DesignArgs>),
    /// Lead the arm by hand, and keep the motion.
    #[command(after_help = teach::EXAMPLES)]
    Teach(teach::TeachArgs),
    /// Identify an arm's parameters from its logs.
    #[command(after_help = identify::EXAMPLES)]
    Identify(identify::IdentifyArgs),
    /// Show the configuration in force, or every key.
    #[command(after_help = config::EXAMPLES)]
    Config(config::ConfigArgs),
    /// Check this machine for what each job needs, with remedies.
    #[command(after_help = doctor::EXAMPLES)]
    Doctor(doctor::DoctorArgs),
    /// Summarise a log: run, gaps, faults, commands, settings, clocks.
    #[command(after_help = info::EXAMPLES)]
    Info(info::InfoArgs),
    /// Draw a log, or several over each other.
    #[command(after_help = plot::EXAMPLES)]
    Plot(plot::PlotArgs),
    /// Write a log as CSV, Parquet or .mat, or the arm as MJCF or URDF.
    #[command(after_help = export::EXAMPLES)]
    Export(export::ExportArgs),
    /// Show where two logs differ: settings, commands, outputs.
    #[command(after_help = diff::EXAMPLES)]
    Diff(diff::DiffArgs),
    /// Run a log's inputs through the board's code, and compare bits.
    #[command(after_help = replay::EXAMPLES)]
    Replay(replay::ReplayArgs),
    /// Run any controller and estimator on simulated arms, many times.
    #[command(after_help = trials::EXAMPLES)]
    Trials(trials::TrialsArgs),
    /// Run a scenario with every combination of several values.
    #[command(after_help = sweep::EXAMPLES)]
    Sweep(Box<sweep::SweepArgs>),
    /// List the virtual arms that ship; explain a plant file's keys.
    #[command(after_help = plants::EXAMPLES)]
    Plants(plants::PlantsArgs),
    /// Inject faults in simulation, and check the board's reaction.
    #[command(after_help = fault_campaign::EXAMPLES)]
    FaultCampaign(fault_campaign::FaultCampaignArgs),
    /// Join parts of a fault campaign that ran apart.
    #[command(after_help = merge::EXAMPLES)]
    Merge(merge::MergeArgs),
    /// Recompute the paper's numbers and figures, with verdicts.
    #[command(after_help = paper::EXAMPLES)]
    Paper(OutputArgs),
    /// Serve a simulated board or virtual servos to other programs.
    #[command(after_help = serve::EXAMPLES)]
    Serve(serve::ServeArgs),
    /// Push the simulated arm of `serve board`.
    #[command(after_help = push::EXAMPLES)]
    Push(push::PushArgs),
    /// Move the simulated arm of `serve board` by hand, and hold it.
    #[command(after_help = hand::EXAMPLES)]
    Hand(hand::HandArgs),
    /// Print completions for a shell.
    #[command(after_help = completions::EXAMPLES)]
    Completions(completions::CompletionsArgs),
    /// Print the manual page, or write those of all commands.
    #[command(after_help = man::EXAMPLES)]
    Man(man::ManArgs),
}

impl Command {
    /// Runs the command.
    pub(crate) fn run(&self) -> Outcome {
        match self {
            Self::Run(args) => run::run(args),
            Self::Watch(args) => watch::run(args),
            Self::Foxglove(args) => foxglove::run(args),
            Self::Setup(args) => setup::run(args),
            Self::Status(args) => status::run(args),
            Self::Arm(args) => arm::run(args),
            Self::Disarm(args) => disarm::run(args),
            Self::Stop(args) => stop::run(args),
            Self::Clear(args) => clear::run(args),
            Self::Calibrate(args) => calibrate::run(args),
            Self::Scan(args) => scan::run(args),
            Self::Servo(args) => servo::run(args),
            Self::Params(args) => params::run(args),
            Self::Design(args) => design::run(args),
            Self::Teach(args) => teach::run(args),
            Self::Identify(args) => identify::run(args),
            Self::Config(args) => config::run(args),
            Self::Doctor(args) => doctor::run(args),
            Self::Info(args) => info::run(args),
            Self::Plot(args) => plot::run(args),
            Self::Export(args) => export::run(args),
            Self::Diff(args) => diff::run(args),
            Self::Replay(args) => replay::run(args),
            Self::Trials(args) => trials::run(args),
            Self::Sweep(args) => sweep::run(args),
            Self::Plants(args) => plants::run(args),
            Self::FaultCampaign(args) => fault_campaign::run(args),
            Self::Merge(args) => merge::run(args),
            Self::Paper(args) => paper::run(args),
            Self::Serve(args) => serve::run(args),
            Self::Push(args) => push::run(args),
            Self::Hand(args) => hand::run(args),
            Self::Completions(args) => completions::run(args, command()),
            Self::Man(args) => man::run(args, command()),
        }
    }
}

/// Commands that have another name now, and that name.
const RENAMED: [(&str, &str); 7] = [
    ("demo", "run demo"),
    ("emulate", "run demo --link emulate:"),
    ("servos", "serve servos"),
    ("live", "foxglove"),
    ("torture", "fault-campaign"),
    ("get", "params"),
    ("set", "params"),
];

/// The program, with all its commands.
pub(crate) fn command() -> clap::Command {
    help::with_help(with_negative_numbers(Cli::command()))
}

/// `-1` is a value, not an option: the option that takes it reports its range.
fn with_negative_numbers(command: clap::Command) -> clap::Command {
    command
        .allow_negative_numbers(true)
        .mut_subcommands(with_negative_numbers)
}

/// The command that was typed; `run demo` if none was.
pub(crate) fn parse() -> Result<Command, clap::Error> {
    parse_from(std::env::args_os().collect())
}

fn parse_from(words: Vec<std::ffi::OsString>) -> Result<Command, clap::Error> {
    let mut command = command();
    let first = words.get(1).and_then(|word| word.to_str());
    let renamed = RENAMED.iter().find(|(old, _)| Some(*old) == first);
    if let Some((old, new)) = renamed {
        let line = format!("`{old}` is `armbridge {new}` now\n");
        return Err(command.error(clap::error::ErrorKind::InvalidSubcommand, line));
    }
    let typed: Vec<String> = words
        .iter()
        .map(|word| word.to_string_lossy().into_owned())
        .collect();
    let matches = command
        .clone()
        .try_get_matches_from(words)
        .map_err(|error| suggestion::with_suggestion(error, &command, &typed))?;
    match Cli::from_arg_matches(&matches)?.command {
        Some(command) => Ok(command),
        None => parse_from(["armbridge", "run", "demo"].map(Into::into).into()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parse(words: &[&str]) -> Result<Command, String> {
        let words = ["armbridge"].iter().chain(words);
        parse_from(words.map(Into::into).collect()).map_err(|error| error.to_string())
    }

    #[test]
    fn arguments_are_consistent_and_mistakes_are_named() {
        Cli::command().debug_assert();
        let Ok(Command::Run(run)) = parse(&[]) else {
            panic!("not a run");
        };
        assert_eq!(run.scenario, "demo");
        let words = ["run", "--initial", "-0.2,0.2", "--seed", "7"];
        let Ok(Command::Run(run)) = parse(&words) else {
            panic!("not a run");
        };
        let simulated = &run.simulated;
        assert_eq!(
            (simulated.arm.initial, simulated.seed),
            (Some([-0.2, 0.2]), Some(7))
        );
        for (words, expected) in [
            (["run", "--duration", "0"].as_slice(), "seconds"),
            (&["run", "--initial", "9,9"], "two angles"),
            (
                &["serve", "servos", "--listen", "udp://x"],
                "tcp://HOST:PORT",
            ),
            (&["serve", "servos"], "--listen"),
            (&["serve", "board"], "--listen"),
        ] {
            let error = parse(words).unwrap_err();
            assert!(error.contains(expected), "{words:?}: {error}");
        }
    }

    #[test]
    fn a_command_with_swapped_letters_is_suggested() {
        for (words, name) in [
            (["rnu"].as_slice(), "'run'"),
            (&["help", "rnu"], "'run'"),
            (&["staus"], "'status'"),
            (&["servo", "1", "raed"], "'read'"),
            (&["serve", "bord"], "'board'"),
            (&["identify", "fti"], "'fit'"),
        ] {
            let error = parse(words).unwrap_err();
            assert!(error.contains(name), "{words:?}: {error}");
        }
        let error = parse(&["zzz"]).unwrap_err();
        assert!(!error.contains("similar"), "{error}");
    }

    #[test]
    fn old_names_give_the_new_one() {
        for (old, new) in RENAMED {
            let error = parse(&[old, "--json"]).unwrap_err();
            assert!(error.contains(&format!("`armbridge {new}`")), "{error}");
            let words: Vec<&str> = new.split(' ').take(1).collect();
            assert!(Cli::command().find_subcommand(words[0]).is_some(), "{new}");
        }
    }
}
