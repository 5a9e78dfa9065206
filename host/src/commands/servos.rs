//! `armbridge servos`: the virtual servos and arm for other programs.

use std::process::ExitCode;

use armbridge::bench::Bench;
use armbridge::endpoint::Endpoint;
use armbridge::serve::LiveBench;

use super::{Outcome, job};
use crate::cli::ServosArgs;

pub(crate) fn run(args: &ServosArgs) -> Outcome {
    let plant = job::plant(&args.arm);
    let mut bench = LiveBench::new(Bench::new(plant), args.slow);
    match &args.at.listen {
        Some(endpoint) => on_tcp(args, endpoint, &mut bench),
        None => on_pty(args, &mut bench),
    }
}

fn on_tcp(args: &ServosArgs, endpoint: &Endpoint, bench: &mut LiveBench) -> Outcome {
    let (listener, at) = endpoint.listen()?;
    eprintln!("virtual servos 1 and 2 on {at}, raw bus bytes at 1 Mbaud; end with ctrl-c");
    loop {
        let (stream, peer) = bench.accept(&listener)?;
        eprintln!("{peer} is on the bus");
        match bench.serve(stream.try_clone()?, stream, args.echo) {
            Ok(()) => eprintln!("{peer} has left; the servos go on as they were told"),
            Err(error) => eprintln!("{peer} is gone: {error}"),
        }
    }
}

#[cfg(unix)]
fn on_pty(args: &ServosArgs, bench: &mut LiveBench) -> Outcome {
    let pty = armbridge::pty::Pty::open()?;
    eprintln!("virtual servos 1 and 2, raw bus bytes; end with ctrl-c");
    println!("{}", pty.name());
    bench.serve(pty.controller()?, pty.controller()?, args.echo)?;
    Ok(ExitCode::SUCCESS)
}

#[cfg(not(unix))]
fn on_pty(_: &ServosArgs, _: &mut LiveBench) -> Outcome {
    Err("there are no pseudo-terminals on this system: use --listen tcp://127.0.0.1:PORT".into())
}
