//! The command lines of `scan` and `servo`.

use std::ops::RangeInclusive;
use std::time::Duration;

use armbridge_client::servo_bus::{Port, client};
use clap::{Args, Subcommand};

pub(crate) const SCAN_EXAMPLES: &str = "\
Examples:
  armbridge scan --port serial:
  armbridge scan --port /dev/ttyUSB0
  armbridge scan --port tcp://127.0.0.1:7000 --ids 0..253
  armbridge scan --port /dev/ttyACM1 --bauds 1000000 --json

An id at which nobody is takes 40 ms at each rate: 6 s for what is looked at
unless said otherwise, 45 s for all ids at the same rates. Over TCP the other
side decides the rate, so there is one. Exit code 1: nobody was found.";

pub(crate) const SERVO_EXAMPLES: &str = "\
Examples:
  armbridge servo 1 read --port /dev/ttyUSB0
  armbridge servo 1 read present_voltage --port /dev/ttyUSB0
  armbridge servo 2 write pwm 1100 --port tcp://127.0.0.1:7000
  armbridge servo 1 set-id 2 --port /dev/ttyUSB0
  armbridge servo 2 set-baud 57600 --port /dev/ttyUSB0

Exit code 1: the servo did not answer, refused, or kept another value.";

/// The port and how to use it.
#[derive(Args, Clone, Debug)]
pub(crate) struct LineArgs {
    /// The bus: `serial:` for the transparent port of the board that is plugged in, a
    /// serial device such as /dev/ttyUSB0, `tcp://HOST:PORT` or `pty:///dev/pts/3`.
    #[arg(long, global = true, visible_alias = "link", value_name = "URI")]
    pub(crate) port: Option<Port>,
    /// How long an answer may take beyond its time on the wire, in ms.
    #[arg(long, global = true, value_name = "MS", default_value = "20", value_parser = patience)]
    pub(crate) patience: Duration,
}

/// Who is there.
#[derive(Args, Debug)]
pub(crate) struct ScanArgs {
    #[command(flatten)]
    pub(crate) line: LineArgs,
    /// First and last id to look at, at most 0..253.
    #[arg(long, value_name = "FIRST..LAST", default_value = "0..32", value_parser = ids)]
    pub(crate) ids: RangeInclusive<u8>,
    /// Baud rates to look at, in this order; of a serial device.
    #[arg(long, value_name = "BAUD,...", value_delimiter = ',', value_parser = baud,
          default_value = "1000000,57600,115200,500000")]
    pub(crate) bauds: Vec<u32>,
    /// Print one JSON object instead of the table.
    #[arg(long)]
    pub(crate) json: bool,
    /// No progress bar.
    #[arg(long)]
    pub(crate) quiet: bool,
}

/// One servo.
#[derive(Args, Debug)]
pub(crate) struct ServoArgs {
    /// Its id.
    #[arg(value_parser = clap::value_parser!(u8).range(0..=253))]
    pub(crate) id: u8,
    #[command(flatten)]
    pub(crate) line: LineArgs,
    /// Rate at which the servo is now; of a serial device.
    #[arg(long, global = true, default_value = "1000000", value_parser = baud)]
    pub(crate) baud: u32,
    /// Do not ask before anything moves or is changed for good.
    #[arg(long, global = true)]
    pub(crate) yes: bool,
    #[command(subcommand)]
    pub(crate) action: ServoAction,
}

/// What to do with it.
#[derive(Debug, Subcommand)]
pub(crate) enum ServoAction {
    /// Read one register, or all.
    Read {
        /// Its name, or its address.
        register: Option<String>,
        /// Print one JSON object instead of the table.
        #[arg(long)]
        json: bool,
    },
    /// Write one register and read it back.
    Write {
        /// Its name, or its address.
        register: String,
        /// As on the wire, without unit; 0x1F and 31 are the same.
        #[arg(value_parser = value)]
        value: u16,
    },
    /// Give it another id, if that is free.
    SetId {
        /// Its id from then on.
        new: u8,
    },
    /// Give it another baud rate.
    SetBaud {
        /// Its rate from then on, in baud.
        #[arg(value_parser = baud)]
        rate: u32,
        /// Also where the line's rate cannot follow, without reading back.
        #[arg(long)]
        blind: bool,
    },
    /// Restore all settings ex works: id 1, 1000000 baud.
    FactoryReset,
}

fn patience(text: &str) -> Result<Duration, String> {
    match text.parse() {
        Ok(ms) if (1..=10_000).contains(&ms) => Ok(Duration::from_millis(ms)),
        _ => Err(format!(
            "expected milliseconds from 1 to 10000; {} is usual",
            client::PATIENCE.as_millis()
        )),
    }
}

/// Rates from the slowest that a servo's register can say to the fastest.
fn baud(text: &str) -> Result<u32, String> {
    match text.trim().parse() {
        Ok(baud) if (7_843..=2_000_000).contains(&baud) => Ok(baud),
        _ => Err("expected a baud rate from 7843 to 2000000".into()),
    }
}

fn ids(text: &str) -> Result<RangeInclusive<u8>, String> {
    let (first, last) = text.split_once("..").unwrap_or((text, text));
    let last = last.trim_start_matches('=');
    match (first.trim().parse(), last.trim().parse()) {
        (Ok(first), Ok(last)) if first <= last && last <= 253 => Ok(first..=last),
        _ => Err("expected ids as 0..32 or 7, from 0 to 253".into()),
    }
}

/// A number of 16 bits, decimal or hexadecimal.
pub(crate) fn value(text: &str) -> Result<u16, String> {
    let number = match text.strip_prefix("0x") {
        Some(digits) => u16::from_str_radix(digits, 16),
        None => text.parse(),
    };
    number.map_err(|_| "expected a number from 0 to 65535, or 0x0 to 0xFFFF".into())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_written_is_what_is_meant() {
        assert_eq!(ids("0..32"), Ok(0..=32));
        assert_eq!(ids("7"), Ok(7..=7));
        assert_eq!(ids("1..=253"), Ok(1..=253));
        for wrong in ["", "3..1", "0..254", "a..b", "-1"] {
            assert!(ids(wrong).is_err(), "{wrong}");
        }
        assert_eq!((value("0x1F"), value("31")), (Ok(31), Ok(31)));
        for wrong in ["65536", "-1", "0x", "1.5"] {
            assert!(value(wrong).is_err(), "{wrong}");
        }
        assert!(baud("1000").is_err() && baud("1000000") == Ok(1_000_000));
        assert_eq!(patience("20"), Ok(client::PATIENCE));
        assert!(patience("0").is_err());
    }
}
