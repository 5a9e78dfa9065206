//! Settings of a board, changed as a group, for `params`, `design` and `identify`.

use std::process::ExitCode;

use armbridge::config::Config;
use armbridge_client::params::settings_exchange::{Exchange, Exchanged, commands};
use armbridge_client::params::to_text;
use armbridge_client::transport::Intent;
use armbridge_client::{params, refusal_text, stdio};
use armbridge_link::message::{Command, Settings};
use armbridge_log::text_table;
use armbridge_sim::link::BoardUri;
use serde_json::json;

use super::{Error, Outcome, link};
use crate::args::LinkArgs;

/// Options of an exchange of settings, and of its output.
pub(super) struct ExchangeOptions<'a> {
    /// Link to the board.
    pub(super) link: &'a LinkArgs,
    /// Across power-off.
    pub(super) save: bool,
    /// Only show the changes.
    pub(super) dry_run: bool,
    /// As JSON.
    pub(super) json: bool,
}

/// Changes the settings of a board to those wanted, and prints the result.
pub(super) fn apply(
    options: &ExchangeOptions<'_>,
    wanted: impl FnOnce(&Settings) -> Result<Settings, Error>,
) -> Outcome {
    let orders = |before: &Settings, after: &Settings| {
        if options.dry_run {
            Vec::new()
        } else {
            commands(before, after, options.save)
        }
    };
    let sent = Sent::to(options.link, wanted, orders)?;
    show(options, &sent)?;
    Ok(match sent.refusal() {
        None => ExitCode::SUCCESS,
        Some(line) => {
            stdio::note(format_args!("armbridge: {line}"));
            ExitCode::from(1)
        }
    })
}

/// Settings of a board before and after an exchange, and its result.
pub(super) struct Sent {
    pub(super) before: Settings,
    pub(super) after: Settings,
    exchanged: Exchanged,
}

impl Sent {
    /// Reads a board's settings, and sends the commands that lead to those wanted.
    pub(super) fn to(
        link: &LinkArgs,
        wanted: impl FnOnce(&Settings) -> Result<Settings, Error>,
        orders: impl FnOnce(&Settings, &Settings) -> Vec<Command>,
    ) -> Result<Self, Error> {
        let mut decided = None;
        let decide = |before: &Settings| {
            let after = wanted(before);
            let orders = match &after {
                Ok(after) => orders(before, after),
                Err(_) => Vec::new(),
            };
            decided = Some(after);
            orders
        };
        let host = link::run_host(
            link,
            &Config::discover()?,
            Intent::Command,
            Exchange::new(decide),
        )?;
        let exchanged = host.exchanged;
        let (Some(before), Some(after)) = (exchanged.before, decided) else {
            return Err("the board did not report its settings; nothing was changed".into());
        };
        Ok(Self {
            before,
            after: after?,
            exchanged,
        })
    }

    /// The board's refusal in words, if there is one.
    pub(super) fn refusal(&self) -> Option<String> {
        let (command, reason) = self.exchanged.refused?;
        let done = match (command, self.exchanged.taken.is_empty()) {
            (Command::Save, _) => "all was changed, but not saved",
            (_, true) => "nothing was changed",
            (_, false) => "the limits were changed, the set-up was not",
        };
        Some(format!(
            "the board refused {}: {}; {done}",
            name(command),
            refusal_text::in_words(reason)
        ))
    }
}

/// Differences, as a table.
pub(super) fn differences(before: &Settings, after: &Settings) -> String {
    let changes = params::changed(before, after);
    let rows = changes.iter().map(|(parameter, value)| {
        let before = parameter.value(before);
        vec![
            parameter.key.to_owned(),
            before.as_ref().map_or_else(|| "-".into(), to_text),
            "->".to_owned(),
            to_text(value),
            parameter.unit.to_owned(),
        ]
    });
    text_table::columns(&rows.collect::<Vec<_>>())
}

fn show(options: &ExchangeOptions<'_>, sent: &Sent) -> Result<(), Error> {
    let Sent {
        before,
        after,
        exchanged,
    } = sent;
    let link = Config::discover()?.link(options.link.link.as_ref())?;
    let changes = params::changed(before, after);
    let has = |is: fn(&Command) -> bool| exchanged.taken.iter().any(is);
    let is_saved = has(|command| *command == Command::Save);
    if options.json {
        let rows = changes.iter().map(|(parameter, value)| {
            json!({
                "key": parameter.key,
                "before": parameter.value(before),
                "after": value,
                "unit": parameter.unit,
            })
        });
        let report = json!({
            "changes": rows.collect::<Vec<_>>(),
            "done": exchanged.refused.is_none() && !options.dry_run,
            "saved": is_saved && !link.is_simulated(),
            "refused": exchanged.refused.map(|(command, reason)| json!({
                "command": name(command),
                "reason": refusal_text::in_words(reason),
            })),
        });
        stdio::print_line(report)?;
        return Ok(());
    }
    stdio::print(differences(before, after))?;
    let message = match (
        changes.is_empty(),
        options.dry_run,
        exchanged.refused.is_some(),
    ) {
        (_, _, true) => return Ok(()),
        (true, ..) => "nothing to change: the board has these values",
        (false, true, _) => {
            stdio::print_line("nothing was changed: this was a dry run")?;
            return Ok(());
        }
        (false, false, _) => "the board has taken it",
    };
    let kept = kept(&link, is_saved);
    stdio::print_line(format_args!("{message}{kept}"))?;
    Ok(())
}

/// Note on how long a board keeps the settings that it has taken.
pub(super) fn kept(link: &BoardUri, is_saved: bool) -> &'static str {
    match (link.is_simulated(), is_saved) {
        (true, _) => "; it is simulated and ends here, so nothing is kept",
        (false, true) => ", and keeps its settings across power-off",
        (false, false) => "",
    }
}

fn name(command: Command) -> &'static str {
    match command {
        Command::Limit(_) => "the limits",
        Command::Configure(_) => "the set-up",
        Command::Save => "to save",
        Command::Idle
        | Command::Park
        | Command::Arm { .. }
        | Command::Torque(_)
        | Command::Regulate(_)
        | Command::Follow(_)
        | Command::Stream { .. }
        | Command::Experiment(_)
        | Command::Float
        | Command::Prepare
        | Command::Release
        | Command::ClearFault => "a command",
    }
}
