//! `armbridge setup`: from an assembled board to the first motion, step by step.

use std::io::Write;
use std::process::ExitCode;
use std::time::Duration;

use armbridge::config::Config;
use armbridge::finding::Finding;
use armbridge::setup::{Setup, SetupOptions};
use armbridge_client::ctrl_c;
use armbridge_client::servo_bus::Port;
use armbridge_client::stdio::{self, Stdout};
use armbridge_client::transport::LinkUri;
use armbridge_sim::link::BoardUri;
use clap::Args;
use serde_json::{Value, json};

use super::Outcome;
use super::terminal_guide::Terminal;
use crate::args::patience;
use crate::args::values::duration;

pub(crate) const EXAMPLES: &str = "\
Examples:
  armbridge setup                     the board that is plugged in
  armbridge setup --yes --json
To practise, on a simulated arm that armbridge hand moves:
  1  armbridge serve board --listen tcp://127.0.0.1:7001 \\
       --transparent tcp://127.0.0.1:7002
  2  armbridge setup --link tcp://127.0.0.1:7001 --port tcp://127.0.0.1:7002
  3  armbridge hand 0,0 --link tcp://127.0.0.1:7001       as 2 asks

Checks the computer's permissions, the board and its servos; sets ids,
calibrates by hand with the motors off, tests the motors' directions gently, holds the
arm for some seconds, and switches the motors off. The first thing missing ends
it, with what to do; the next run goes on from there. In a script, each line of
the input is one answer.

Exit codes: 0 the arm was held, 1 something is missing.";

/// The board, and how much is asked.
#[derive(Args, Debug)]
pub(crate) struct SetupArgs {
    /// Link to the board: usb:, serial:, tcp://HOST:PORT or a pty
    /// [default: a board that `ARMBRIDGE_LINK` or armbridge.toml names, or usb:].
    #[arg(long, value_name = "URI")]
    link: Option<BoardUri>,
    /// The servo bus on the board's transparent port, if it is not on USB: a serial device,
    /// `tcp://HOST:PORT` or `pty:///dev/pts/3`.
    #[arg(long, value_name = "URI")]
    port: Option<Port>,
    /// Time-out of a servo's reply beyond its time on the wire, in ms.
    #[arg(long, value_name = "MS", default_value = "20", value_parser = patience)]
    patience: Duration,
    /// Change ids and save the calibration without asking. A motion is still asked for.
    #[arg(long)]
    yes: bool,
    /// Time for which the arm is held, in s.
    #[arg(long, value_name = "S", default_value = "3", value_parser = duration)]
    hold: f64,
    /// Print one JSON object instead of the table.
    #[arg(long)]
    json: bool,
}

pub(crate) fn run(args: &SetupArgs) -> Outcome {
    ctrl_c::listen()?;
    let link = match Config::discover()?.link(args.link.as_ref())? {
        BoardUri::Link(link) => link,
        simulated if args.link.is_some() => {
            return Err(format!(
                "{simulated} is simulated inside each program that uses it, and is gone after \
                 each step: serve it, as `armbridge setup --help` shows"
            )
            .into());
        }
        BoardUri::Sim | BoardUri::Emulate(_) => LinkUri::Usb(None),
    };
    let options = SetupOptions {
        link,
        port: args.port.clone(),
        patience: args.patience,
        is_sure: args.yes,
        hold: Duration::from_secs_f64(args.hold),
    };
    let mut rows: Vec<Value> = Vec::new();
    let mut printed = Ok(());
    let mut guide = Terminal::new();
    let is_complete = Setup::new(&options, &mut guide).run(|step, finding| {
        if args.json {
            rows.push(as_json(step, finding));
        } else if printed.is_ok() {
            printed = print(step, finding);
        }
    })?;
    printed?;
    if args.json {
        stdio::print_line(json!({ "complete": is_complete, "steps": rows }))?;
    } else if is_complete {
        stdio::print_line(format_args!(
            "\nThe arm is set up. Next: armbridge watch --link {}",
            options.link
        ))?;
    }
    Ok(ExitCode::from(u8::from(!is_complete)))
}

/// A line, and lines with what to do.
fn print(step: &str, finding: &Finding) -> std::io::Result<()> {
    let (state, text, remedy) = finding.parts();
    let mut out = Stdout;
    writeln!(out, "{step:<13}{state:<9}{text}")?;
    let mut lines = remedy.unwrap_or_default().lines();
    lines.try_for_each(|line| writeln!(out, "    {line}"))
}

fn as_json(step: &str, finding: &Finding) -> Value {
    let (state, text, remedy) = finding.parts();
    json!({ "step": step, "state": state, "finding": text, "remedy": remedy })
}
