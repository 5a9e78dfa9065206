//! Suggestion of a command for a name that does not exist.

use armbridge_client::params;
use clap::error::{ContextKind, ContextValue, ErrorKind};
use clap::{Command, Error};

/// Adds the command with the most similar name to an error of an unknown one. clap does so
/// only for names that are longer or more alike.
pub(super) fn with_suggestion(mut error: Error, program: &Command, words: &[String]) -> Error {
    let is_unknown = error.kind() == ErrorKind::InvalidSubcommand;
    if !is_unknown || error.get(ContextKind::SuggestedSubcommand).is_some() {
        return error;
    }
    let Some(ContextValue::String(typed)) = error.get(ContextKind::InvalidSubcommand) else {
        return error;
    };
    // A command of commands is followed by one of its own.
    let before = words.iter().take_while(|word| *word != typed);
    let parent = before.fold(program, |parent, word| {
        parent.find_subcommand(word).unwrap_or(parent)
    });
    let names = parent.get_subcommands().map(Command::get_name);
    if let Some(name) = params::nearest(typed, names) {
        let names = ContextValue::Strings(vec![name.to_owned()]);
        error.insert(ContextKind::SuggestedSubcommand, names);
    }
    error
}
