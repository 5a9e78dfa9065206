//! `armbridge emulate`: the firmware image under QEMU.
//!
//! | bus            | link           | time                                      |
//! |----------------|----------------|-------------------------------------------|
//! | virtual servos | the demo's job | lockstep, as fast as it goes              |
//! | virtual servos | `--link-listen`| lockstep, held back to wall-clock time    |
//! | `--bus`        | either         | the wall clock, in slow motion            |

use std::path::Path;
use std::process::ExitCode;
use std::time::Instant;

use armbridge::bench::cosim::{Cosim, CosimError, Host};
use armbridge::emulator::{self, EmulatedBoard, Qemu, QemuOptions, Time};
use armbridge::endpoint::Endpoint;
use armbridge::remote::RemoteHost;
use armbridge::wall::{self, WallError};

use super::Outcome;
use super::job::{self, Job, Nobody};
use crate::cli::EmulateArgs;

const WORLD: &str = "simulated: QEMU mps2-an386";

pub(crate) fn run(args: &EmulateArgs) -> Outcome {
    let image = args
        .image
        .clone()
        .unwrap_or_else(emulator::qemu::default_image);
    let time = match args.bus {
        None => Time::Lockstep,
        Some(_) => Time::Slow(args.slow),
    };
    let options = QemuOptions {
        image,
        time,
        icount: args.icount,
        provoke: None,
    };
    match (&args.bus, &args.link_listen) {
        (None, None) => demo(args, &options),
        (None, Some(at)) => offer(args, at, &options),
        (Some(bus), None) => demo_on(args, bus, &options),
        (Some(bus), Some(at)) => offer_on(bus, at, &options),
    }
}

/// Starts QEMU and shows what the firmware logs.
fn start(options: &QemuOptions, quiet: bool) -> Result<Qemu, Box<dyn std::error::Error>> {
    let qemu = Qemu::start(options)?;
    let show = move |line: String| {
        if !quiet {
            eprintln!("board: {line}");
        }
    };
    emulator::log::spawn(Path::new(&options.image), qemu.log.try_clone()?, show)?;
    Ok(qemu)
}

fn demo(args: &EmulateArgs, options: &QemuOptions) -> Outcome {
    let is_silent = args.run.output.quiet || args.run.output.json;
    let board = EmulatedBoard::new(start(options, is_silent)?)?;
    let bench = job::bench(&args.run)?;
    if args.run.port.disarmed {
        let cosim = Cosim::new(board, bench, Nobody);
        return for_ever(job::with_port(cosim, &args.run.port)?);
    }
    let job = Job::new(&args.run, "emulate", WORLD)?;
    let mut cosim = job::with_port(Cosim::new(board, bench, job), &args.run.port)?;
    let begun = Instant::now();
    match cosim.run() {
        Ok(()) => cosim.host.finish(begun.elapsed()),
        Err(CosimError::Host(error)) => Err(error.into()),
        Err(CosimError::Board(error)) => Err(error.into()),
    }
}

fn offer(args: &EmulateArgs, at: &Endpoint, options: &QemuOptions) -> Outcome {
    let (listener, at) = at.listen()?;
    let board = EmulatedBoard::new(start(options, args.run.output.quiet)?)?;
    eprintln!("control link on {at}; end with ctrl-c");
    let cosim = Cosim::new(board, job::bench(&args.run)?, RemoteHost::new(listener)?);
    for_ever(job::with_port(cosim, &args.run.port)?)
}

/// Until the board is gone, or whoever is at its link.
fn for_ever<H: Host>(mut cosim: Cosim<EmulatedBoard, H>) -> Outcome
where
    H::Error: std::error::Error + 'static,
{
    match cosim.run() {
        Ok(()) => Ok(ExitCode::SUCCESS),
        Err(CosimError::Host(error)) => Err(error.into()),
        Err(CosimError::Board(error)) => Err(error.into()),
    }
}

fn demo_on(args: &EmulateArgs, bus: &Endpoint, options: &QemuOptions) -> Outcome {
    let bus = bus.connect()?;
    let mut qemu = start(options, args.run.output.quiet || args.run.output.json)?;
    let mut job = Job::new(&args.run, "emulate", "QEMU mps2-an386, bus elsewhere")?;
    let _copiers = wall::join(&bus, &qemu.bus)?;
    let begun = Instant::now();
    match wall::run(&mut qemu.link, &mut job, args.slow) {
        Ok(()) => job.finish(begun.elapsed()),
        Err(WallError::Host(error)) => Err(error.into()),
        Err(WallError::Io(error)) => Err(qemu.explain(error).into()),
    }
}

fn offer_on(bus: &Endpoint, at: &Endpoint, options: &QemuOptions) -> Outcome {
    let (listener, at) = at.listen()?;
    let bus = bus.connect()?;
    let qemu = start(options, false)?;
    let _copiers = wall::join(&bus, &qemu.bus)?;
    eprintln!("control link on {at}, for one program; end with ctrl-c");
    let (link, peer) = listener.accept()?;
    link.set_nodelay(true)?;
    eprintln!("{peer} has the link");
    for copier in wall::join(&link, &qemu.link)? {
        // A copier cannot panic.
        let _ = copier.join();
    }
    Ok(ExitCode::SUCCESS)
}
