//! `armbridge servos`: the virtual servos and arm for other programs.

use std::process::ExitCode;
use std::time::Instant;

use armbridge::bench::Bench;
use armbridge::endpoint::Endpoint;
use armbridge::serve::{self, Pace};

use super::{Outcome, job};
use crate::cli::ServosArgs;

pub(crate) fn run(args: &ServosArgs) -> Outcome {
    let mut bench = Bench::new(job::plant(args.initial, args.no_friction, args.seed));
    let pace = Pace {
        epoch: Instant::now(),
        slow: args.slow,
    };
    match &args.at.listen {
        Some(endpoint) => on_tcp(args, endpoint, &mut bench, pace),
        None => on_pty(args, &mut bench, pace),
    }
}

fn on_tcp(args: &ServosArgs, endpoint: &Endpoint, bench: &mut Bench, pace: Pace) -> Outcome {
    let (listener, at) = endpoint.listen()?;
    eprintln!("virtual servos 1 and 2 on {at}, raw bus bytes at 1 Mbaud; end with ctrl-c");
    loop {
        let (stream, peer) = listener.accept()?;
        stream.set_nodelay(true)?;
        eprintln!("{peer} is on the bus");
        match serve::serve(bench, pace, stream.try_clone()?, stream, args.echo) {
            Ok(()) => eprintln!("{peer} has left; the servos go on as they were told"),
            Err(error) => eprintln!("{peer} is gone: {error}"),
        }
    }
}

#[cfg(unix)]
fn on_pty(args: &ServosArgs, bench: &mut Bench, pace: Pace) -> Outcome {
    let pty = armbridge::pty::Pty::open()?;
    eprintln!("virtual servos 1 and 2, raw bus bytes; end with ctrl-c");
    println!("{}", pty.name());
    serve::serve(bench, pace, pty.controller()?, pty.controller()?, args.echo)?;
    Ok(ExitCode::SUCCESS)
}

#[cfg(not(unix))]
fn on_pty(_: &ServosArgs, _: &mut Bench, _: Pace) -> Outcome {
    Err("there are no pseudo-terminals on this system: use --listen tcp://127.0.0.1:PORT".into())
}
