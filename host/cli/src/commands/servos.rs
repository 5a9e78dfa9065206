//! `armbridge servos`: the virtual servos and arm for other programs.

use std::process::ExitCode;

use armbridge_client::endpoint::Endpoint;
use armbridge_client::transport::LinkUri;
use armbridge_sim::Bench;
use armbridge_sim::kind::ServoKind;
use armbridge_sim::raw_bus_server::LiveBench;

use super::{Outcome, job};
use crate::cli::ServosArgs;

pub(crate) fn run(args: &ServosArgs) -> Outcome {
    let plant = job::plant(&args.arm)?;
    let kinds = args.kinds()?;
    let mut bench = Bench::with_servos(plant, &kinds);
    bench.set_baud(args.baud);
    let mut bench = LiveBench::new(bench, args.slow);
    let who = in_words(&kinds);
    match &args.at.listen {
        Some(LinkUri::Tcp(endpoint)) => on_tcp(args, &who, endpoint, &mut bench),
        Some(LinkUri::Pty(None)) | None => on_pty(args, &who, &mut bench),
        Some(other @ (LinkUri::Usb(_) | LinkUri::Serial(_) | LinkUri::Pty(Some(_)))) => Err(
            format!("servos cannot be offered on {other}: expected tcp://HOST:PORT or pty:").into(),
        ),
    }
}

/// As "1 (morpheus, 1000000 baud) and 2 (stock, 1000000 baud)".
fn in_words(kinds: &[ServoKind]) -> String {
    let each: Vec<String> = kinds.iter().map(ToString::to_string).collect();
    each.join(" and ")
}

fn on_tcp(args: &ServosArgs, who: &str, endpoint: &Endpoint, bench: &mut LiveBench) -> Outcome {
    let (listener, at) = endpoint.listen()?;
    eprintln!(
        "virtual servos {who} on {at}, raw bus bytes at {} baud; end with ctrl-c",
        args.baud
    );
    loop {
        let (stream, peer) = bench.accept(&listener)?;
        eprintln!("{peer} is on the bus");
        match bench.serve(stream.try_clone()?, stream, || None, args.echo) {
            Ok(()) => eprintln!("{peer} has left; the servos go on as they were told"),
            Err(error) => eprintln!("{peer} is gone: {error}"),
        }
    }
}

#[cfg(unix)]
fn on_pty(args: &ServosArgs, who: &str, bench: &mut LiveBench) -> Outcome {
    use armbridge_client::pty::Pty;

    let pty = Pty::open()?;
    let ours = pty.controller()?;
    eprintln!("virtual servos {who}, raw bus bytes; end with ctrl-c");
    println!("{}", pty.name());
    let baud = move || Pty::baud(&ours);
    bench.serve(pty.controller()?, pty.controller()?, baud, args.echo)?;
    Ok(ExitCode::SUCCESS)
}

#[cfg(not(unix))]
fn on_pty(_: &ServosArgs, _: &str, _: &mut LiveBench) -> Outcome {
    Err("there are no pseudo-terminals on this system: use --listen tcp://127.0.0.1:PORT".into())
}
