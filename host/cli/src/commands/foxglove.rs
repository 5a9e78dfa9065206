//! `armbridge foxglove`: the topics of a log, as they happen, for viewers.

use std::net::{IpAddr, Ipv4Addr};

use clap::Args;

use super::Outcome;
use crate::args::{ExposeArgs, SessionArgs};

pub(crate) const EXAMPLES: &str = "\
Examples:
  armbridge foxglove                    the simulated arm, ws://127.0.0.1:8765
  armbridge foxglove --link serial:     the board that is plugged in
  armbridge foxglove --record run.mcap  the same as the first, and a log
  armbridge foxglove --allow-arm        viewers may let the motors come on

Open the address that it prints in Foxglove (Open connection, Foxglove
WebSocket). A viewer without the token in the address watches, and may call
/stop and /disarm. A viewer that has armed the arm holds it: when it leaves, the
arm is disarmed. Parameters are edited in its Parameters panel; /stop, /disarm
and /clear_fault are called from its Service Call panel, with {} as the request.
Ctrl-C disarms the board and ends the server.";

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
    /// Address to listen on; beyond loopback addresses --expose is needed.
    #[arg(long, value_name = "ADDRESS", default_value_t = IpAddr::V4(Ipv4Addr::LOCALHOST))]
    pub(crate) host: IpAddr,
    #[command(flatten)]
    pub(crate) expose: ExposeArgs,
    /// Let browser pages of this site connect too, such as `https://lab.example`. Pages of
    /// Foxglove's app and of this machine may, others are refused.
    #[arg(long, value_name = "URL")]
    pub(crate) allow_origin: Vec<String>,
    /// Token of viewers that may change settings and call every service, at least 16 letters,
    /// digits, - or _ [default: a new one, printed in the address]. Other users of this machine
    /// can see it in the list of processes.
    #[arg(long, value_parser = token)]
    pub(crate) token: Option<String>,
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

/// A token that stands in an address as it is.
fn token(text: &str) -> Result<String, String> {
    let is_plain = |byte: u8| byte.is_ascii_alphanumeric() || matches!(byte, b'-' | b'_');
    if text.len() >= 16 && text.bytes().all(is_plain) {
        Ok(text.into())
    } else {
        Err("expected at least 16 letters, digits, - or _".into())
    }
}

#[cfg(feature = "foxglove")]
pub(crate) fn run(args: &FoxgloveArgs) -> Outcome {
    use armbridge::foxglove::access::Access;
    use armbridge::foxglove::run;
    use armbridge::foxglove::server::Server;

    use super::session::OpenedLink;
    use armbridge_client::{ctrl_c, stdio};

    let access = Access::new(args.allow_origin.clone(), args.token.clone())
        .map_err(|error| format!("cannot make a token: {error}; give one with --token"))?;
    // First, so that a port in use is found before anything begins.
    let at = (args.host, args.port).into();
    let mut server = Server::start(at, args.expose.into(), args.allow_arm, access)?;
    let opened = OpenedLink::begin(
        &args.session,
        "foxglove",
        false,
        armbridge_client::transport::Intent::CommandOrObserve,
    )?;
    // A parent process reads the address here.
    stdio::print_line(server.url())?;
    stdio::note(format_args!("{}: open {}", opened.title, server.app_url()));
    let served = run::run(opened.session(), &opened.event_queue, &mut server);
    let ended = opened.end();
    drop(server);
    ended?;
    let served = served?;
    stdio::note(format_args!(
        "{} messages, {} events left out",
        served.messages, served.unseen
    ));
    Ok(std::process::ExitCode::from(ctrl_c::awaited_exit_code()))
}
