//! Commands of two logs: the first that differs.

use armbridge_client::enum_names;
use armbridge_shared::link::message::Command;

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
    let show = |commands| at(commands, place).map(|command| command_text(&command));
    Some(CommandDiff {
        place: place + 1,
        commands: [show(a), show(b)],
    })
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
        | Command::Arm { .. }
        | Command::Prepare
        | Command::Release
        | Command::ClearFault
        | Command::Save
        | Command::Configure(_)
        | Command::Limit(_) => name.to_owned(),
    }
}
