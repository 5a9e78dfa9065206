//! `armbridge serve`: a board, or virtual servos alone, for other programs.

mod servos;
mod until_signal;

use std::process::ExitCode;

use armbridge::config::Config;
use armbridge::json_server;
use armbridge_client::endpoint::{Endpoint, Exposure};
use armbridge_client::host::NoHost;
use armbridge_client::transport::LinkUri;
use armbridge_client::{ctrl_c, stdio};
use armbridge_sim::Bench;
use armbridge_sim::link::{BoardUri, Options, Pace, drive};
use armbridge_sim::link_server::LinkServer;
use armbridge_sim::plant::Plant;
use clap::{Args, Subcommand};

use super::{Error, Outcome, transparent_port, virtual_arm};
use crate::args::listen::{FORMS, listen_at};
use crate::args::{ArmArgs, ExposeArgs, LinkArgs, VirtualServoArgs};
use until_signal::UntilSignal;

pub(crate) const EXAMPLES: &str = "\
Examples:
  armbridge serve board --listen tcp://127.0.0.1:7001
  armbridge serve board --link emulate: --listen pty:
  armbridge serve board --json tcp://127.0.0.1:7002
  armbridge serve board --transparent tcp://127.0.0.1:7003
  armbridge serve servos --listen tcp://127.0.0.1:7000
  armbridge scan --port tcp://127.0.0.1:7000

The arm of a board that is served on tcp:// can be pushed and moved by hand:
  armbridge push --link tcp://127.0.0.1:7001
  armbridge hand 0.3,-0.2 --link tcp://127.0.0.1:7001

Simulated time keeps pace with the wall clock. Ctrl-C ends the server,
with exit code 0.";

/// A server.
#[derive(Args, Debug)]
pub(crate) struct ServeArgs {
    #[command(subcommand)]
    what: Served,
}

#[derive(Debug, Subcommand)]
enum Served {
    /// Serve a simulated board's link and transparent port, and any board as JSON.
    Board(Box<BoardArgs>),
    /// Serve virtual servos, as raw bytes of their bus.
    Servos(servos::ServosArgs),
}

/// A board.
#[derive(Args, Debug)]
struct BoardArgs {
    #[command(flatten)]
    link: LinkArgs,
    /// Serve the control link on a socket, where one program commands, any number watch and
    /// each may stop, or by `pty:` on a new pseudo-terminal, to one program.
    #[arg(
        long,
        value_name = FORMS,
        value_parser = listen_at,
        required_unless_present_any = ["transparent", "json"]
    )]
    listen: Option<LinkUri>,
    /// Serve the board to programs in any language: one JSON object a line both ways. One
    /// program commands, any number watch and each may stop, those of --listen included.
    #[arg(long, value_name = "tcp://HOST:PORT")]
    json: Option<Endpoint>,
    /// Serve the transparent port, which behaves like the vendor's USB adapter; its SDK needs
    /// `--firmware stock`. Without --listen, nothing else uses the bus.
    #[arg(long, value_name = FORMS, value_parser = listen_at)]
    transparent: Option<LinkUri>,
    #[command(flatten)]
    expose: ExposeArgs,
    /// Do not print the log of an emulated board.
    #[arg(long)]
    quiet: bool,
    #[command(flatten)]
    arm: ArmArgs,
    #[command(flatten)]
    servos: VirtualServoArgs,
}

pub(crate) fn run(args: &ServeArgs) -> Outcome {
    ctrl_c::listen()?;
    let what = match &args.what {
        Served::Board(args) => {
            board(args)?;
            "the board"
        }
        Served::Servos(args) => {
            servos::run(args)?;
            "the servos"
        }
    };
    if ctrl_c::is_raised() {
        let signal = ctrl_c::in_words();
        stdio::note(format_args!(
            "{what} and the arm are gone: ended by {signal}"
        ));
    }
    Ok(ExitCode::from(ctrl_c::awaited_exit_code()))
}

fn board(args: &BoardArgs) -> Result<(), Error> {
    let link = Config::discover()?.link(args.link.link.as_ref())?;
    if !link.is_simulated() && args.json.is_none() {
        return Err(format!("{link} is a board: it is served by --json alone").into());
    }
    if let (Some(LinkUri::Tcp(listen)), Some(LinkUri::Tcp(port))) =
        (&args.listen, &args.transparent)
        && listen == port
        && !listen.is_any_port()
    {
        return Err(
            format!("--listen and --transparent are both {port}: expected two ports").into(),
        );
    }
    let config = virtual_arm::config(&args.arm)?;
    let firmware = args.servos.firmware()?;
    let config = firmware.map_or(config, |[first, _]| config.with_servos(first));
    let kinds = args.servos.kinds(config.firmware())?;
    let plant = Plant::new(config, args.arm.seed);
    let mut options = Options::new(Bench::with_servos(plant, &kinds));
    options.pace = Pace::WallClock;
    options.is_stoppable = true;
    if !args.quiet {
        options.board_log = |line| stdio::note(format_args!("board: {line}"));
    }
    options.client = transparent_port::open(args.transparent.as_ref(), args.expose.into())?;
    // Programs that speak JSON reach the link as others do.
    let inner = args
        .json
        .as_ref()
        .map(|_| LinkUri::Tcp(Endpoint::ANY_LOCAL));
    match args.listen.as_ref().or(inner.as_ref()) {
        Some(at) => {
            let (mut host, at) = LinkServer::offer(at, args.expose.into())?;
            if let Some(endpoint) = &args.json {
                serve_json(endpoint, &at, args.expose.into())?;
            }
            if args.listen.is_some() {
                stdio::note(format_args!("control link on {at}; end with ctrl-c"));
            }
            if link.has_bench() {
                options.interactions = host.interactions();
            }
            if options.interactions.is_some() && args.listen.is_some() && !args.quiet {
                stdio::note_text(touching(&at));
            }
            drive(&link, options, UntilSignal(host)).1?;
        }
        None => drive(&link, options, UntilSignal(NoHost)).1?,
    }
    Ok(())
}

/// Serves the board at this link to programs that speak JSON.
fn serve_json(endpoint: &Endpoint, link: &LinkUri, exposure: Exposure) -> Result<(), Error> {
    if !matches!(link, LinkUri::Tcp(_)) {
        return Err(format!("--json goes with --listen tcp://HOST:PORT, not with {link}").into());
    }
    let (listener, at) = endpoint.listen(exposure)?;
    json_server::begin(listener, BoardUri::Link(link.clone()))?;
    stdio::note(format_args!("JSON, a line each, on {at}; end with ctrl-c"));
    Ok(())
}

/// Commands that use the served board and its arm.
fn touching(at: &LinkUri) -> String {
    let lines = [
        ("watch", "steer it; --observe looks on"),
        ("push", "push the simulated arm"),
        ("hand 0,0", "move the arm by hand, and hold it"),
    ];
    lines
        .map(|(command, effect)| format!("  armbridge {command:<8} --link {at}   {effect}\n"))
        .concat()
}
