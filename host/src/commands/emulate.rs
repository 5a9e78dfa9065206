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

use armbridge::bench::Bench;
use armbridge::bench::cosim::{Cosim, CosimError};
use armbridge::emulator::{self, EmulatedBoard, Qemu, QemuOptions, Time};
use armbridge::endpoint::Endpoint;
use armbridge::remote::RemoteHost;
use armbridge::wall::{self, WallError};

use super::Outcome;
use super::job::{self, Job};
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
    let board = EmulatedBoard::new(start(
        options,
        args.run.output.quiet || args.run.output.json,
    )?)?;
    let job = Job::new(&args.run, "emulate", WORLD)?;
    let mut cosim = Cosim::new(board, virtual_bench(args), job);
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
    let mut cosim = Cosim::new(board, virtual_bench(args), RemoteHost::new(listener)?);
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

fn virtual_bench(args: &EmulateArgs) -> Bench {
    Bench::new(job::plant(&args.run.arm))
}
