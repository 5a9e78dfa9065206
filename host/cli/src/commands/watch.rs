//! `armbridge watch`: a dashboard on the terminal.

use std::io::IsTerminal;
use std::process::ExitCode;

use armbridge::watch::screen;

use super::Outcome;
use super::session::Opened;
use crate::cli::WatchArgs;

pub(crate) fn run(args: &WatchArgs) -> Outcome {
    if !std::io::stdout().is_terminal() || !std::io::stdin().is_terminal() {
        return Err(
            "`watch` draws on a terminal, and this is none; use `armbridge status` where \
             there is nobody to look"
                .into(),
        );
    }
    let opened = Opened::begin(&args.session, "watch", true)?;
    let shown = screen::show(
        opened.session(),
        &opened.feed,
        opened.is_simulated,
        &opened.title,
    );
    opened.end()?;
    shown.map_err(|error| format!("cannot draw on this terminal: {error}; is TERM right?"))?;
    Ok(ExitCode::SUCCESS)
}
