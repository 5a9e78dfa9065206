//! `armbridge scan`: searches the bus for servos.

use std::io::Write;
use std::ops::RangeInclusive;
use std::process::ExitCode;

use armbridge_analysis::progress::Progress;
use armbridge_client::servo_bus::scan::{Area, Found, Report, ScanError, Step, scan};
use armbridge_client::servo_bus::{Diagnosis, Port};
use armbridge_client::servo_table::alarms;
use armbridge_client::stdio::Stdout;
use armbridge_log::text_table;
use armbridge_servo::Firmware;
use clap::Args;
use serde_json::{Value, json};

use super::{Outcome, bus};
use crate::args::{BusArgs, baud};

pub(crate) const EXAMPLES: &str = "\
Examples:
  armbridge scan --port serial:
  armbridge scan --port /dev/ttyUSB0      on Windows: --port COM3
  armbridge scan --port tcp://127.0.0.1:7000 --ids 0..253
  armbridge scan --port /dev/ttyACM1 --bauds 1000000 --json

An id without a servo takes 40 ms at each rate: 6 s for the default ids and
rates, 45 s for all ids at these rates. Over TCP the other side sets the rate,
so only one is tried. Exit code 1: no servo was found.";

/// Area and output of a scan.
#[derive(Args, Debug)]
pub(crate) struct ScanArgs {
    #[command(flatten)]
    pub(crate) line: BusArgs,
    /// First and last id to try, at most 0..253.
    #[arg(long, value_name = "FIRST..LAST", default_value = "0..32", value_parser = ids)]
    pub(crate) ids: RangeInclusive<u8>,
    /// Baud rates to try on a serial device, in this order.
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

fn ids(text: &str) -> Result<RangeInclusive<u8>, String> {
    let (first, last) = text.split_once("..").unwrap_or((text, text));
    let last = last.trim_start_matches('=');
    match (first.trim().parse(), last.trim().parse()) {
        (Ok(first), Ok(last)) if first <= last && last <= 253 => Ok(first..=last),
        _ => Err("expected ids as 0..32 or 7, from 0 to 253".into()),
    }
}

pub(crate) fn run(args: &ScanArgs) -> Outcome {
    let area = Area {
        ids: args.ids.clone(),
        bauds: args.bauds.clone(),
    };
    let first = area.bauds.first().copied().unwrap_or_default();
    let mut client = bus::open(&args.line, first)?;

    // Most ids have no servo, and take this long.
    let s_per_ping = args.line.patience.as_secs_f64();
    let rates = client.baud().map_or(1, |_| area.bauds.len());
    let pings = rates * area.ids.len() * Firmware::ALL.len();
    let total_s = pings as f64 * s_per_ping;
    let progress = Progress::new(total_s, args.quiet || args.json);
    let report = scan(&mut client, &area, |step: Step| {
        progress.set_position(total_s * step.done as f64 / step.total as f64);
        progress.set_message(match step.baud {
            Some(baud) => format!("{baud} baud, id {}", step.id),
            None => format!("id {}", step.id),
        });
    })
    .map_err(|error| format!("the port failed during the scan: {error}"))?;
    progress.finish();

    let mut out = Stdout;
    if args.json {
        writeln!(out, "{}", as_json(args.line.port.as_ref(), &report))?;
    } else {
        write!(out, "{}", as_text(&report))?;
    }
    Ok(ExitCode::from(u8::from(report.found.is_empty())))
}

fn as_text(report: &Report) -> String {
    let mut text = String::new();
    if !report.found.is_empty() {
        let heads = [
            "id",
            "firmware",
            "baud",
            "model",
            "version",
            "temperature",
            "voltage",
            "alarms",
        ];
        let mut rows = vec![heads.map(str::to_owned).to_vec()];
        rows.extend(report.found.iter().map(row));
        text.push_str(&text_table::columns(&rows));
    }
    // The same trouble at several ids is one line.
    let of_one_kind = report
        .troubles
        .chunk_by(|a, b| (a.baud, a.firmware, &a.diagnosis) == (b.baud, b.firmware, &b.diagnosis));
    text.extend(of_one_kind.filter_map(trouble));
    if report.is_mixed() {
        text.push_str(
            "Both firmwares are on this bus, where the packets of one disturb the other. The \
             board refuses that: take one kind off, or give all servos the same firmware.\n",
        );
    }
    if report
        .found
        .iter()
        .any(|found| found.firmware == Firmware::Morpheus)
    {
        text.push_str(
            "Morpheus servos answer Morpheus packets only; the vendor's SDK speaks Protocol\n\
             1.0, and finds stock servos alone.\n",
        );
    }
    if report.found.is_empty() && report.troubles.is_empty() {
        let silence = Diagnosis::silence(report.echoes);
        text = text
            + &format!("No servo has answered: {silence}. To look at more ids and rates: ")
            + "--ids 0..253 --bauds 1000000,500000,115200,57600,9600\n";
    }
    text
}

fn trouble(same: &[ScanError]) -> Option<String> {
    let first = same.first()?;
    let ids: Vec<String> = same.iter().map(|trouble| trouble.id.to_string()).collect();
    let at = first.baud.map(|baud| format!(" at {baud} baud"));
    Some(format!(
        "id {}{}, asked as {}: {}\n",
        ids.join(", "),
        at.unwrap_or_default(),
        first.firmware,
        first.diagnosis
    ))
}

fn row(found: &Found) -> Vec<String> {
    let none = || "-".to_owned();
    let details = found.details;
    let temperature = details.temperature.map(|raw| match found.firmware {
        Firmware::Morpheus => format!("{raw} counts"),
        Firmware::Stock | Firmware::XSeries => format!("{raw} degC"),
    });
    let volts = details.decivolt.map(|raw| format!("{:.1} V", volts(raw)));
    let alarms = match found.firmware {
        Firmware::Morpheus => none(),
        Firmware::Stock | Firmware::XSeries => alarms::text(found.alarms),
    };
    vec![
        found.id.to_string(),
        found.firmware.to_string(),
        found.baud.map_or_else(none, |baud| baud.to_string()),
        details.model.map_or_else(none, |model| model.to_string()),
        details
            .version
            .map_or_else(none, |version| version.to_string()),
        temperature.unwrap_or_else(none),
        volts.unwrap_or_else(none),
        alarms,
    ]
}

fn volts(decivolt: u32) -> f64 {
    f64::from(decivolt) / 10.0
}

fn as_json(port: Option<&Port>, report: &Report) -> Value {
    let servo = |found: &Found| {
        let is_morpheus = found.firmware == Firmware::Morpheus;
        let temperature = |of_morpheus| {
            let temperature = found.details.temperature;
            temperature.filter(|_| is_morpheus == of_morpheus)
        };
        json!({
            "id": found.id,
            "firmware": found.firmware.to_string(),
            "baud": found.baud,
            "model": found.details.model,
            "version": found.details.version,
            "temperature_degc": temperature(false),
            "temperature_counts": temperature(true),
            "voltage_v": found.details.decivolt.map(volts),
            "alarms": alarms::names(found.alarms),
        })
    };
    let servos: Vec<Value> = report.found.iter().map(servo).collect();
    let troubles: Vec<Value> = report
        .troubles
        .iter()
        .map(|trouble| {
            json!({
                "id": trouble.id,
                "baud": trouble.baud,
                "asked_as": trouble.firmware.to_string(),
                "diagnosis": trouble.diagnosis,
            })
        })
        .collect();
    json!({
        "port": port.map(ToString::to_string),
        "servos": servos,
        "troubles": troubles,
        "echoes": report.echoes,
        "mixed": report.is_mixed(),
    })
}
