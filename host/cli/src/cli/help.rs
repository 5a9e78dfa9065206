//! The help: of the program itself, its commands grouped by purpose; of all commands, as
//! wide as a terminal, in plain text.

use std::fmt::Write;

use armbridge_log::text_table::WIDTH;
use clap::Command;
use clap::builder::{Resettable, StyledStr};

/// Purposes, each with its commands.
const GROUPS: [(&str, &[&str]); 6] = [
    ("Run", &["run", "teach", "watch", "foxglove"]),
    (
        "Board and servos",
        &[
            "setup",
            "status",
            "arm",
            "disarm",
            "stop",
            "clear",
            "calibrate",
            "params",
            "scan",
            "servo",
        ],
    ),
    ("Set up", &["design", "identify", "config", "doctor"]),
    ("Logs", &["info", "plot", "export", "diff", "replay"]),
    (
        "Simulation",
        &[
            "serve",
            "push",
            "hand",
            "sweep",
            "plants",
            "trials",
            "fault-campaign",
            "merge",
            "paper",
        ],
    ),
    ("Shell", &["completions", "man", "help"]),
];

/// The program with that help.
pub(super) fn with_help(command: Command) -> Command {
    let command = in_plain_text(command.max_term_width(WIDTH));
    let mut named = command.clone();
    // Gives it its `help`.
    named.build();
    let help = help(&named);
    command.override_help(help)
}

/// The texts of a command and those below it without code marks: they are comments of the
/// code, and a terminal shows the marks as they are.
fn in_plain_text(command: Command) -> Command {
    let about = plain(command.get_about());
    let long_about = plain(command.get_long_about());
    let after = plain(command.get_after_help());
    command
        .about(about)
        .long_about(long_about)
        .after_help(after)
        .mut_args(|arg| {
            let [help, long] = [arg.get_help(), arg.get_long_help()].map(plain);
            arg.help(help).long_help(long)
        })
        .mut_subcommands(in_plain_text)
}

fn plain(text: Option<&StyledStr>) -> Resettable<StyledStr> {
    text.map(|text| text.to_string().replace('`', "").into())
        .into()
}

fn help(command: &Command) -> String {
    let mut text = String::new();
    // Writing to a string cannot fail.
    let _ = write_help(&mut text, command);
    text
}

fn write_help(out: &mut String, command: &Command) -> std::fmt::Result {
    if let Some(about) = command.get_about() {
        writeln!(out, "{about}\n")?;
    }
    writeln!(
        out,
        "Usage: armbridge [COMMAND] [OPTIONS]; without a command, run demo"
    )?;
    for (group, names) in GROUPS {
        let found = names
            .iter()
            .filter_map(|name| command.find_subcommand(name));
        write_group(out, group, found)?;
    }
    let is_grouped = |name: &str| GROUPS.iter().any(|(_, names)| names.contains(&name));
    let others = command.get_subcommands();
    write_group(
        out,
        "More",
        others.filter(|other| !is_grouped(other.get_name())),
    )?;
    write!(
        out,
        "\nOptions:\n  \
         -h, --help      Print this, or after a command its options and examples\n  \
         -V, --version   Print the version\n\n\
         Commands for a board take --link; armbridge config shows the default.\n"
    )
}

fn write_group<'a>(
    out: &mut String,
    group: &str,
    commands: impl Iterator<Item = &'a Command>,
) -> std::fmt::Result {
    let mut commands = commands.filter(|command| !command.is_hide_set()).peekable();
    if commands.peek().is_some() {
        writeln!(out, "\n{group}:")?;
    }
    commands.try_for_each(|command| {
        let about = command.get_about().map(ToString::to_string);
        let about = about.unwrap_or_default();
        writeln!(out, "  {:<15}{about}", command.get_name())
    })
}

#[cfg(test)]
mod tests {
    use clap::{Arg, Command};

    use super::*;
    use crate::cli::command;

    fn built() -> Command {
        let mut command = command();
        command.build();
        command
    }

    fn walk<'a>(command: &'a Command, path: &str, see: &mut impl FnMut(&str, &'a Command)) {
        for inner in command.get_subcommands() {
            if inner.get_name() != "help" {
                let path = format!("{path} {}", inner.get_name());
                see(&path, inner);
                walk(inner, &path, see);
            }
        }
    }

    #[test]
    fn the_help_fits_on_a_screen_and_has_every_command_once() {
        let command = built();
        let help = help(&command);
        assert!(help.lines().count() <= 56, "{help}");
        assert!(!help.contains("\nMore:"), "in no group: {help}");
        for name in command.get_subcommands().map(Command::get_name) {
            let line = format!("\n  {name:<15}");
            assert_eq!(help.matches(&line).count(), 1, "{name}");
        }
    }

    #[test]
    fn no_help_is_wider_than_a_terminal_or_has_code_marks() {
        let mut helps = 0;
        let mut check = |path: &str, command: &Command| {
            let mut command = command.clone();
            let texts = [command.render_help(), command.render_long_help()];
            for text in texts.map(|text| text.to_string()) {
                let wide = text.lines().find(|line| line.chars().count() > WIDTH);
                assert_eq!(wide, None, "{path}");
                let marked = text.lines().find(|line| line.contains('`'));
                assert_eq!(marked, None, "{path}");
                helps += 1;
            }
        };
        check("armbridge", &built());
        walk(&built(), "armbridge", &mut check);
        assert!(helps > 70, "{helps}");
    }

    #[test]
    fn every_command_has_a_description_and_an_example() {
        walk(&built(), "armbridge", &mut |path, command| {
            let about = command.get_about().map(ToString::to_string);
            let about = about.unwrap_or_default();
            assert!(about.len() > 10, "{path} has no description");
            assert!(about.chars().count() <= 80, "{path} is too long: {about}");
            // A command of commands has its examples; they have their own or none.
            let top = path.split(' ').count() == 2;
            let after = command.get_after_long_help().or(command.get_after_help());
            let after = after.map(ToString::to_string).unwrap_or_default();
            let has_example = after.contains("Example") && after.contains(&format!("  {path}"));
            assert!(has_example || !top, "{path} has no example of itself");
        });
    }

    #[test]
    fn every_option_has_a_description() {
        let check = |path: &str, command: &Command| {
            let ours = |arg: &&Arg| !["help", "version"].contains(&arg.get_id().as_str());
            for arg in command.get_arguments().filter(ours) {
                let text = arg.get_long_help().or(arg.get_help());
                let text = text.map(ToString::to_string).unwrap_or_default();
                assert!(text.len() > 5, "{path} {arg} has no description");
            }
        };
        check("armbridge", &built());
        walk(&built(), "armbridge", &mut |path, command| {
            check(path, command);
        });
    }
}
