//! `armbridge foxglove`: the topics of a log, as they happen, for viewers.

use std::net::{IpAddr, Ipv4Addr};

use clap::Args;

use super::Outcome;
use crate::args::SessionArgs;

pub(crate) const EXAMPLES: &str = "\
Examples:
  armbridge foxglove                                    the simulated arm, on ws://127.0.0.1:8765
  armbridge foxglove --link serial: --record run.mcap   the board that is plugged in, and a log
  armbridge foxglove --allow-arm                        viewers may let the motors come on

Open the address that it prints in Foxglove (Open connection, Foxglove WebSocket).
Parameters are edited in its Parameters panel; /stop, /disarm and /clear_fault are called
from its Service Call panel, with {} as the request. Ctrl-C disarms the board and ends the server.";

/// Port that viewers look for.
const PORT: u16 = 8765;

/// A Foxglove server.
#[derive(Args, Debug)]
pub(crate) struct FoxgloveArgs {
    #[command(flatten)]
    pub(crate) session: SessionArgs,
    /// Port of the server; 0 for any free one.
    #[arg(long, default_value_t = PORT)]
    pub(crate) port: u16,
    /// Address to listen on. Beyond a loopback address, every host of the network can change
    /// settings and stop the arm.
    #[arg(long, value_name = "ADDRESS", default_value_t = IpAddr::V4(Ipv4Addr::LOCALHOST))]
    pub(crate) host: IpAddr,
    /// Let viewers arm the board, hold the arm, and move it upright.
    #[arg(long)]
    pub(crate) allow_arm: bool,
}

/// The server is built where it is asked for.
#[cfg(not(feature = "foxglove"))]
pub(crate) fn run(_: &FoxgloveArgs) -> Outcome {
    Err(
        "this build has no server for viewers; `cargo build --release --features foxglove` makes \
         one that has"
            .into(),
    )
}

#[cfg(feature = "foxglove")]
pub(crate) fn run(args: &FoxgloveArgs) -> Outcome {
    use std::io::Write;

    use armbridge::foxglove::run;
    use armbridge::foxglove::server::Server;

    use super::session::OpenedLink;

    // First, so that a port in use is found before anything begins.
    let server = Server::start(args.host, args.port, args.allow_arm)?;
    let opened = OpenedLink::begin(&args.session, "foxglove", false)?;
    if !args.host.is_loopback() {
        eprintln!(
            "armbridge: any host that reaches {} can change settings{}; use trusted networks only",
            args.host,
            if args.allow_arm {
                " and move the arm"
            } else {
                ""
            }
        );
    }
    // A parent process reads the address here.
    println!("ws://{}:{}", args.host, server.port());
    std::io::stdout().flush()?;
    eprintln!("{}: open {}", opened.title, server.app_url());
    let served = run::run(opened.session(), &opened.event_queue, &server);
    let ended = opened.end();
    server.stop();
    ended?;
    eprintln!(
        "{} messages, {} events left out",
        served.messages, served.unseen
    );
    Ok(std::process::ExitCode::SUCCESS)
}
