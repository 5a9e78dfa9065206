//! `armbridge live`: the topics of a log, as they happen, for viewers.

use std::io::Write;
use std::process::ExitCode;

use armbridge::live::run;
use armbridge::live::server::Server;

use super::Outcome;
use super::session::Opened;
use crate::cli::LiveArgs;

pub(crate) fn run(args: &LiveArgs) -> Outcome {
    // First: a port that is taken shall not begin anything.
    let server = Server::start(args.host, args.port, args.allow_arm)?;
    let opened = Opened::begin(&args.session, "live", false)?;
    if !args.host.is_loopback() {
        eprintln!(
            "armbridge: whoever reaches {} can change settings{}; use it on networks you trust",
            args.host,
            if args.allow_arm {
                " and move the arm"
            } else {
                ""
            }
        );
    }
    // Whoever starts this as a part of something else reads the address here.
    println!("ws://{}:{}", args.host, server.port());
    std::io::stdout().flush()?;
    eprintln!("{}: open {}", opened.title, server.app_url());
    let served = run::run(opened.session(), &opened.feed, &server);
    let ended = opened.end();
    server.stop();
    ended?;
    eprintln!(
        "{} messages, {} events left out",
        served.messages, served.unseen
    );
    Ok(ExitCode::SUCCESS)
}
