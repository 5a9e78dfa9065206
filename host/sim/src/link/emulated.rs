//! Host on the firmware image under QEMU: in lockstep with the bench, or in slowed
//! wall-clock time on an external servo bus.

use std::error::Error;
use std::thread::JoinHandle;

use armbridge_client::tap::Tapped;
use armbridge_client::tcp_pump::{self, PumpError};
use armbridge_client::{Host, LinkError};

use super::uri::{EmulatorUri, ExternalBus};
use super::{Options, virtual_board};
use crate::emulator::{EmulatedBoard, Image, Qemu, QemuError, QemuOptions, Time, log};

/// Like [`drive`](super::drive), on this board.
pub(super) fn run<H: Host>(
    uri: &EmulatorUri,
    options: Options,
    host: H,
) -> (H, Result<(), LinkError<H::Error>>) {
    let failed = |error: QemuError| LinkError::Link(error.into());
    match (&uri.bus, start(uri, options.board_log)) {
        (_, Err(error)) => (host, Err(failed(error))),
        (Some(bus), Ok(qemu)) => on_bus(bus, qemu, options, host),
        (None, Ok(qemu)) => match EmulatedBoard::new(qemu) {
            Ok(board) => virtual_board::run(board, options, host),
            Err(error) => (host, Err(failed(error))),
        },
    }
}

/// Starts the image.
fn start(uri: &EmulatorUri, board_log: fn(&str)) -> Result<Qemu, QemuError> {
    let options = QemuOptions {
        image: match &uri.image {
            Some(path) => Image::open(path)?,
            None => Image::current()?,
        },
        time: match &uri.bus {
            None => Time::Lockstep,
            Some(bus) => Time::Slow(bus.slow),
        },
        icount: uri.icount,
        provoke: None,
    };
    let qemu = Qemu::start(&options)?;
    board_log(&format!("firmware image {}", options.image));
    // Read in any case: a full socket would block the board.
    log::spawn(&options.image, qemu.log.try_clone()?, move |line| {
        board_log(&line);
    })?;
    Ok(qemu)
}

fn on_bus<H: Host>(
    bus: &ExternalBus,
    mut qemu: Qemu,
    options: Options,
    host: H,
) -> (H, Result<(), LinkError<H::Error>>) {
    let mut host = Tapped::new(host, options.link.taps);
    let result = match join(bus, &qemu) {
        Err(error) => Err(LinkError::Link(error)),
        Ok(_copiers) => {
            tcp_pump::run(&mut qemu.link, &mut host, bus.slow).map_err(|error| match error {
                PumpError::Host(error) => LinkError::Host(error),
                PumpError::Io(error) => LinkError::Link(qemu.explain(error).into()),
            })
        }
    };
    (host.host, result)
}

/// Connects the emulated bus with the external one, by two threads.
fn join(
    bus: &ExternalBus,
    qemu: &Qemu,
) -> Result<[JoinHandle<()>; 2], Box<dyn Error + Send + Sync>> {
    Ok(tcp_pump::join(&bus.at.connect()?, &qemu.bus)?)
}
