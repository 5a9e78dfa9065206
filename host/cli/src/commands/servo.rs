//! `armbridge servo`: registers, id, baud rate and factory settings of one.

use std::io::Write;
use std::process::ExitCode;

use armbridge_client::servo_bus::change::ChangeError;
use armbridge_client::servo_bus::reading::{Reading, ServoError, Taken, Value};
use armbridge_client::servo_bus::{Line, Servo, moves};
use armbridge_client::servo_table::{Access, Register, Storage, Table, alarms};
use armbridge_client::stdio;
use armbridge_client::stdio::Stdout;
use armbridge_servo::Firmware;
use clap::{Args, Subcommand};
use serde_json::json;

use super::{Error, Outcome, bus};
use crate::args::{BusArgs, baud};

pub(crate) const EXAMPLES: &str = "\
Examples:
  armbridge servo 1 read --port /dev/ttyUSB0
  armbridge servo 1 read present_voltage --port /dev/ttyUSB0
  armbridge servo 2 write pwm 1100 --port tcp://127.0.0.1:7000
  armbridge servo 1 set-id 2 --port /dev/ttyUSB0
  armbridge servo 2 set-baud 57600 --port /dev/ttyUSB0

Exit code 1: the servo did not answer, refused, or kept another value.";

/// One servo.
#[derive(Args, Debug)]
pub(crate) struct ServoArgs {
    /// Id of the servo.
    #[arg(value_parser = clap::value_parser!(u8).range(0..=253))]
    pub(crate) id: u8,
    #[command(flatten)]
    pub(crate) line: BusArgs,
    /// Present baud rate of the servo, on a serial device.
    #[arg(long, global = true, default_value = "1000000", value_parser = baud)]
    pub(crate) baud: u32,
    /// Do not ask before a motion or a permanent change.
    #[arg(long, global = true)]
    pub(crate) yes: bool,
    #[command(subcommand)]
    pub(crate) action: ServoAction,
}

/// Action on a servo.
#[derive(Debug, Subcommand)]
pub(crate) enum ServoAction {
    /// Read one register, or all.
    Read {
        /// Name or address of the register.
        register: Option<String>,
        /// Print one JSON object instead of the table.
        #[arg(long)]
        json: bool,
    },
    /// Write one register and read it back.
    Write {
        /// Name or address of the register.
        register: String,
        /// Raw value, decimal or hexadecimal: 31 or 0x1F.
        #[arg(value_parser = register_value)]
        value: u32,
    },
    /// Change the servo's id, if the new one is free.
    SetId {
        /// The new id.
        new: u8,
    },
    /// Change the servo's baud rate.
    SetBaud {
        /// The new rate, in baud.
        #[arg(value_parser = baud)]
        rate: u32,
        /// Change it even if the line's rate cannot follow; it is then not read back.
        #[arg(long)]
        blind: bool,
    },
    /// Restore the factory settings: id 1, 1000000 baud (X series 57600).
    FactoryReset,
}

/// A number of 32 bits, decimal or hexadecimal.
fn register_value(text: &str) -> Result<u32, String> {
    let number = match text.strip_prefix("0x") {
        Some(digits) => u32::from_str_radix(digits, 16),
        None => text.parse(),
    };
    number.map_err(|_| "expected a number from 0 to 4294967295, or 0x0 to 0xFFFFFFFF".into())
}

pub(crate) fn run(args: &ServoArgs) -> Outcome {
    let mut client = bus::open(&args.line, args.baud)?;
    let done = Servo::find(&mut client, args.id)
        .map_err(Error::from)
        .and_then(|mut servo| act(&mut servo, args));
    match done {
        Ok(text) => {
            write!(Stdout, "{text}")?;
            Ok(ExitCode::SUCCESS)
        }
        Err(error) if is_servo_error(&error) => {
            stdio::note(format_args!("armbridge: {error}"));
            Ok(ExitCode::from(1))
        }
        Err(error) => Err(error),
    }
}

/// Whether the servo is at fault, and not the request or the port.
fn is_servo_error(error: &Error) -> bool {
    let servo = error.downcast_ref().map(ServoError::is_servo_error);
    let change = error.downcast_ref().map(ChangeError::is_servo_error);
    servo.or(change).unwrap_or(false)
}

/// Performs the action; returns the text to print.
fn act<L: Line>(servo: &mut Servo<L>, args: &ServoArgs) -> Result<String, Error> {
    let id = args.id;
    if !servo.alarms().is_empty() {
        stdio::note(format_args!(
            "servo {id} reports alarms: {}",
            alarms::text(servo.alarms())
        ));
    }
    match &args.action {
        ServoAction::Read { register, json } => read(servo, register.as_deref(), *json),
        ServoAction::Write { register, value } => write(servo, register, *value, args.yes),
        ServoAction::SetId { new } => {
            bus::confirm(&format!("servo {id} gets id {new}"), args.yes)?;
            servo.set_id(*new)?;
            Ok(format!("servo {id} now has id {new}, read back\n"))
        }
        ServoAction::SetBaud { rate, blind } => {
            bus::confirm(&format!("servo {id} gets {rate} baud"), args.yes)?;
            let how = match servo.set_baud(*rate, *blind)? {
                Taken::NotReadable => "not read back: check that it has changed",
                _ => "read back at that rate",
            };
            Ok(format!("servo {id} now runs at {rate} baud, {how}\n"))
        }
        ServoAction::FactoryReset => {
            let action = format!(
                "servo {id} loses its settings, and gets id 1 and the baud rate of the factory"
            );
            bus::confirm(&action, args.yes)?;
            servo.factory_reset()?;
            Ok("servo 1 holds its factory settings, read back\n".into())
        }
    }
}

fn read<L: Line>(
    servo: &mut Servo<L>,
    register: Option<&str>,
    as_json: bool,
) -> Result<String, Error> {
    let firmware = servo.firmware();
    let readings = match register {
        Some(name) => vec![servo.read(find(firmware, name)?)?],
        None => servo.read_all()?,
    };
    Ok(match readings.as_slice() {
        readings if as_json => {
            let registers: Vec<_> = readings.iter().map(json_of).collect();
            let alarms = alarms::names(servo.alarms());
            let object = json!({
                "id": servo.id(),
                "firmware": firmware.to_string(),
                "alarms": alarms,
                "registers": registers,
            });
            format!("{object}\n")
        }
        [one] if register.is_some() => {
            let [value, meaning] = cells(one);
            format!("{} {value} {meaning}", one.register.name)
                .trim_end()
                .to_owned()
                + "\n"
        }
        readings => {
            let heads = [
                "address", "register", "value", "meaning", "range", "access", "kept in",
            ];
            let mut rows = vec![heads.map(str::to_owned).to_vec()];
            rows.extend(readings.iter().map(row));
            format!(
                "servo {}, {firmware}\n{}",
                servo.id(),
                armbridge_log::text_table::columns(&rows)
            )
        }
    })
}

fn write<L: Line>(
    servo: &mut Servo<L>,
    name: &str,
    value: u32,
    yes: bool,
) -> Result<String, Error> {
    let register = find(servo.firmware(), name)?;
    let name = register.name;
    servo.check(register, value)?;
    if moves(servo.firmware(), register, value) {
        let action = format!("writing {value} to {name} can move servo {}", servo.id());
        bus::confirm(&action, yes)?;
    }
    let how = match servo.write(register, value)? {
        Taken::ReadBack => "read back",
        Taken::LowByteReadBack => "of which only the low byte can be read back",
        Taken::NotReadable if name == "position" => {
            "which cannot be read back; it moves if it has been given a speed, 1 to 10"
        }
        Taken::NotReadable => "which cannot be read back",
    };
    let shown = register.show(value).to_string();
    let shown = if shown == value.to_string() {
        String::new()
    } else {
        format!(" ({shown})")
    };
    Ok(format!(
        "{name} of servo {} is {value}{shown}, {how}\n",
        servo.id()
    ))
}

/// By name, or by address.
fn find(firmware: Firmware, name: &str) -> Result<&'static Register, Error> {
    let table = Table::for_firmware(firmware);
    let by_address = || {
        let address = register_value(name).ok()?.try_into().ok()?;
        table.at(address)
    };
    table.by_name(name).or_else(by_address).ok_or_else(|| {
        let names: Vec<&str> = table
            .registers
            .iter()
            .map(|register| register.name)
            .collect();
        format!(
            "{firmware} has no register {name}; it has {}",
            names.join(", ")
        )
        .into()
    })
}

/// Value and meaning; a meaning equal to the value is left out.
fn cells(reading: &Reading) -> [String; 2] {
    match reading.value {
        Value::Known(value) => {
            let meaning = reading.register.show(value).to_string();
            let value = value.to_string();
            let differs = meaning != value;
            [value, if differs { meaning } else { String::new() }]
        }
        Value::LowByte(low) => [
            format!("0x??{low:02X}"),
            "the servo does not report the high byte".into(),
        ],
    }
}

fn row(reading: &Reading) -> Vec<String> {
    let register = reading.register;
    let [value, meaning] = cells(reading);
    let (first, last) = (register.range.start(), register.range.end());
    vec![
        format!("0x{:02X}", register.address),
        register.name.to_owned(),
        value,
        meaning,
        format!("{first}..{last}"),
        match register.access {
            Access::Read => "read",
            Access::ReadWrite => "read, write",
        }
        .to_owned(),
        match register.storage {
            Storage::Eeprom => "EEPROM",
            Storage::Ram => "RAM",
        }
        .to_owned(),
    ]
}

fn json_of(reading: &Reading) -> serde_json::Value {
    let register = reading.register;
    let (value, low_byte) = match reading.value {
        Value::Known(value) => (Some(value), None),
        Value::LowByte(low) => (None, Some(low)),
    };
    json!({
        "name": register.name,
        "address": register.address,
        "value": value,
        "low_byte": low_byte,
        "meaning": value.map(|value| register.show(value).to_string()),
        "range": [register.range.start(), register.range.end()],
        "writable": register.access == Access::ReadWrite,
        "eeprom": register.storage == Storage::Eeprom,
    })
}
