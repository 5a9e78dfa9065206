//! The servo bus for `scan` and `servo`: opening the port, and confirmation.

use std::io::IsTerminal;

use armbridge_client::servo_bus::{BusMaster, Line};
use armbridge_client::stdio;
use armbridge_client::transport::device_names::DEVICE;

use super::Error;
use crate::args::BusArgs;

/// A client on the port, which a serial device offers at `baud`.
pub(super) fn open(args: &BusArgs, baud: u32) -> Result<BusMaster<Box<dyn Line>>, Error> {
    let port = args.port.as_ref().ok_or_else(|| {
        format!(
            "--port is missing: the serial device of the adapter, for example {DEVICE}, serial: \
             for the board's transparent port, or tcp://HOST:PORT"
        )
    })?;
    let line = port.open(baud)?;
    if let Some(hint) = port.latency_timer().and_then(|timer| timer.hint()) {
        stdio::note(format_args!("{port}: {hint}"));
    }
    let client = BusMaster::new(line, args.patience);
    client.map_err(|error| format!("{port} failed: {error}").into())
}

/// Asks for confirmation on the terminal, unless `yes` is set.
pub(super) fn confirm(action: &str, yes: bool) -> Result<(), Error> {
    if yes {
        return Ok(());
    }
    let input = std::io::stdin();
    if !input.is_terminal() {
        return Err(format!(
            "{action}: not confirmed, as the input is no terminal; add --yes to do it"
        )
        .into());
    }
    stdio::note_text(format_args!("{action}. Go on? [y/N] "));
    let mut answer = String::new();
    input.read_line(&mut answer)?;
    match answer.trim() {
        "y" | "Y" | "yes" => Ok(()),
        _ => Err("nothing was changed".into()),
    }
}
