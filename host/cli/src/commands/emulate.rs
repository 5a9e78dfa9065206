//! `armbridge emulate`: the firmware image under QEMU.
//!
//! | bus            | link           | time                                      |
//! |----------------|----------------|-------------------------------------------|
//! | virtual servos | the demo's job | lockstep, as fast as it goes              |
//! | virtual servos | `--link-listen`| lockstep, held back to wall-clock time    |
//! | `--bus`        | either         | the wall clock, in slow motion            |

use std::path::Path;
use std::process::ExitCode;

use armbridge_client::LinkError;
use armbridge_client::endpoint::Endpoint;
use armbridge_client::tcp_pump;
use armbridge_client::tcp_pump::WallError;
use armbridge_client::transport::LinkUri;
use armbridge_sim::emulator;
use armbridge_sim::emulator::{EmulatedBoard, Qemu, QemuOptions, Time};
use armbridge_sim::link::drive_board;
use armbridge_sim::link_server::RemoteHost;

use super::Outcome;
use super::job::{self, Nobody};
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
    let mut options = job::options(&args.run)?;
    if args.run.port.disarmed {
        return job::left_alone(drive_board(board, options, Nobody).1);
    }
    let player = job::player(&args.run, "emulate", WORLD, true)?;
    options.link.taps.push(player.tap());
    let (player, result) = drive_board(board, options, player);
    job::finish(player, result, &args.run.output)
}

fn offer(args: &EmulateArgs, at: &LinkUri, options: &QemuOptions) -> Outcome {
    let (host, at) = RemoteHost::offer(at)?;
    let board = EmulatedBoard::new(start(options, args.run.output.quiet)?)?;
    eprintln!("control link on {at}; end with ctrl-c");
    let options = job::options(&args.run)?;
    // Until the board is gone, or whoever is at its link.
    drive_board(board, options, host).1?;
    Ok(ExitCode::SUCCESS)
}

fn demo_on(args: &EmulateArgs, bus: &Endpoint, options: &QemuOptions) -> Outcome {
    let bus = bus.connect()?;
    let mut qemu = start(options, args.run.output.quiet || args.run.output.json)?;
    let world = "QEMU mps2-an386, bus elsewhere";
    let mut player = job::player(&args.run, "emulate", world, false)?.listening();
    let _copiers = tcp_pump::join(&bus, &qemu.bus)?;
    let result = match tcp_pump::run(&mut qemu.link, &mut player, args.slow) {
        Ok(()) => Ok(()),
        Err(WallError::Host(error)) => Err(LinkError::Host(error)),
        Err(WallError::Io(error)) => Err(LinkError::Link(qemu.explain(error).to_string())),
    };
    job::finish(player, result, &args.run.output)
}

fn offer_on(bus: &Endpoint, at: &LinkUri, options: &QemuOptions) -> Outcome {
    let LinkUri::Tcp(at) = at else {
        return Err(
            format!("with --bus the link is offered on tcp://HOST:PORT, not on {at}").into(),
        );
    };
    let (listener, at) = at.listen()?;
    let bus = bus.connect()?;
    let qemu = start(options, false)?;
    let _copiers = tcp_pump::join(&bus, &qemu.bus)?;
    eprintln!("control link on {at}, for one program; end with ctrl-c");
    let (link, peer) = listener.accept()?;
    link.set_nodelay(true)?;
    eprintln!("{peer} has the link");
    for copier in tcp_pump::join(&link, &qemu.link)? {
        // A copier cannot panic.
        let _ = copier.join();
    }
    Ok(ExitCode::SUCCESS)
}
