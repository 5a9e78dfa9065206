//! Commands of two logs: the first that differs.

use armbridge_client::{enum_names, params};
use armbridge_link::message::{Command, Settings};

use super::super::drive_text;
use super::super::log::SentCommand;
use super::CommandDiff;

pub(super) fn first_command(a: &[SentCommand], b: &[SentCommand]) -> Option<CommandDiff> {
    let at = |commands: &[SentCommand], place: usize| commands.get(place).map(|sent| sent.command);
    let mut places = 0..a.len().max(b.len());
    let place = places.find(|place| match (at(a, *place), at(b, *place)) {
        // The session number differs in every run.
        (Some(Command::Arm { .. }), Some(Command::Arm { .. })) => false,
        (a, b) => a != b,
    })?;
    let pair = [at(a, place), at(b, place)];
    Some(CommandDiff {
        place: place + 1,
        settings: settings(&pair),
        commands: pair.map(|command| command.map(|command| command_text(&command))),
    })
}

/// Settings in which two commands that set them differ.
fn settings(commands: &[Option<Command>; 2]) -> Vec<&'static str> {
    let sets = [0, 1].map(|run| {
        let mut settings = Settings::default();
        match commands[run]? {
            Command::Configure(setup) => settings.setup = setup,
            Command::Limit(limits) => settings.limits = limits,
            _ => return None,
        }
        Some(settings)
    });
    let [Some(a), Some(b)] = sets else {
        return Vec::new();
    };
    let differs = |key: &&str| params::get(&a, key) != params::get(&b, key);
    let keys = params::all().iter().map(|parameter| parameter.key);
    keys.filter(differs).collect()
}

/// A command as one line.
pub fn command_text(command: &Command) -> String {
    let pair = |[a, b]: [f32; 2], unit: &str| format!("{a}, {b} {unit}");
    let name = enum_names::command(command);
    match command {
        Command::Torque(torque) => format!("{name} {}", pair(*torque, "N m")),
        Command::Regulate(angle) => format!("{name} {}", pair(*angle, "rad")),
        Command::Stream {
            at_us, angle_rad, ..
        } => format!(
            "{name} {} at {} s",
            pair(*angle_rad, "rad"),
            *at_us as f64 / 1e6
        ),
        Command::Follow(motion) => format!("{name} {}", drive_text::motion(motion)),
        Command::Experiment(plan) => format!("{name} {}", drive_text::experiment(plan)),
        // The contents of these two are compared by name, as settings.
        Command::Idle
        | Command::Park
        | Command::Arm { .. }
        | Command::Float
        | Command::Prepare
        | Command::Release
        | Command::ClearFault
        | Command::Save
        | Command::Configure(_)
        | Command::Limit(_) => name.to_owned(),
    }
}
