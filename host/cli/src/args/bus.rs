//! The servo bus, as `scan` and `servo` take it.

use std::time::Duration;

use armbridge_client::servo_bus::{Port, master};
use clap::Args;

/// The port and how to use it.
#[derive(Args, Clone, Debug)]
pub(crate) struct BusArgs {
    /// The bus: `serial:` for the transparent port of the board that is plugged in, a
    /// serial device such as /dev/ttyUSB0 or COM3, `tcp://HOST:PORT` or `pty:///dev/pts/3`.
    #[arg(long, global = true, visible_alias = "link", value_name = "URI")]
    pub(crate) port: Option<Port>,
    /// Time-out of a reply beyond its time on the wire, in ms.
    #[arg(long, global = true, value_name = "MS", default_value = "20", value_parser = patience)]
    pub(crate) patience: Duration,
}

/// A time-out of a reply in ms.
pub(crate) fn patience(text: &str) -> Result<Duration, String> {
    match text.parse() {
        Ok(ms) if (1..=10_000).contains(&ms) => Ok(Duration::from_millis(ms)),
        _ => Err(format!(
            "expected milliseconds from 1 to 10000; {} is usual",
            master::PATIENCE.as_millis()
        )),
    }
}

/// Rates from the slowest that a servo's register can hold to the fastest.
pub(crate) fn baud(text: &str) -> Result<u32, String> {
    match text.trim().parse() {
        Ok(baud) if (7_843..=2_000_000).contains(&baud) => Ok(baud),
        _ => Err("expected a baud rate from 7843 to 2000000".into()),
    }
}
