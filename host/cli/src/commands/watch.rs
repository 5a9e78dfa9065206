//! `armbridge watch`: a dashboard on the terminal.

use std::io::IsTerminal;
use std::process::ExitCode;

use armbridge::watch::screen;
use armbridge::watch::screen::ScreenError;
use armbridge_client::ctrl_c::Signal;
use armbridge_client::transport::Intent;
use armbridge_client::{ctrl_c, stdio};
use clap::Args;

use super::Outcome;
use super::session::OpenedLink;
use crate::args::SessionArgs;

pub(crate) const EXAMPLES: &str = "\
Examples:
  armbridge watch                   the simulated arm; r arms and regulates
  armbridge watch --link serial:    the board that is plugged in
  armbridge watch --link tcp://127.0.0.1:7001 --record run.mcap
  armbridge watch --link tcp://127.0.0.1:7001 --observe
                                    beside a program that commands

Keys: space stops, d disarms, q quits, after a park or a disarm, ? shows all of them.
Exit code 129: the terminal went away; the board is disarmed, and the log is
closed.";

/// A dashboard.
#[derive(Args, Debug)]
pub(crate) struct WatchArgs {
    #[command(flatten)]
    pub(crate) session: SessionArgs,
    /// Only observe a served board, and never command it, also when no other program does.
    /// Stop works all the same.
    #[arg(long)]
    pub(crate) observe: bool,
}

pub(crate) fn run(args: &WatchArgs) -> Outcome {
    if !std::io::stdout().is_terminal() || !std::io::stdin().is_terminal() {
        return Err(
            "`watch` needs a terminal for input and output; in a script use `armbridge status`"
                .into(),
        );
    }
    let intent = if args.observe {
        Intent::Observe
    } else {
        Intent::CommandOrObserve
    };
    let opened = OpenedLink::begin(&args.session, "watch", true, intent)?;
    let shown = screen::show(
        opened.session(),
        &opened.event_queue,
        opened.is_simulated,
        &opened.title,
    );
    let ended = opened.end();
    match shown {
        Err(ScreenError::Gone) => {
            let end = match &ended {
                Ok(()) => "the board is disarmed".to_owned(),
                Err(error) => error.to_string(),
            };
            stdio::note(format_args!("armbridge: {}; {end}", ScreenError::Gone));
            Ok(ExitCode::from(Signal::HangUp.exit_code()))
        }
        shown => {
            ended?;
            shown?;
            Ok(ExitCode::from(ctrl_c::awaited_exit_code()))
        }
    }
}
