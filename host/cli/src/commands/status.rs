//! `armbridge status`: board, servo and link status.

use std::io::Write;
use std::path::PathBuf;
use std::process::ExitCode;

use armbridge::board_tasks::TaskHost;
use armbridge::board_tasks::status::Status;
use armbridge_client::error::end_in_words;
use armbridge_client::image_list::{ImageList, ImageListError};
use armbridge_client::status::FoundServos;
use armbridge_client::stdio::Stdout;
use armbridge_client::{enum_names, fault_text};
use armbridge_link::message::{BoardReport, End, Fault, SettingsFrom, SettingsGroups};
use armbridge_link::server::LinkRole;
use armbridge_log::text_table;
use armbridge_servo::Firmware;
use armbridge_sim::link::{BoardUri, Pace};
use clap::Args;
use serde_json::{Value, json};

use super::{Outcome, task};
use crate::args::TaskArgs;

pub(crate) const EXAMPLES: &str = "\
Examples:
  armbridge status                        of the simulated board
  armbridge status --link serial:         of the board that is plugged in
  armbridge status --link tcp://127.0.0.1:7001 --json
  armbridge status --link serial: --images images.json

A hello disarms the board or parks the arm, as a link has one host. Of a served board that
another program commands, the status is what that program receives. If another
program has the link alone, the command reports that and does nothing.";

/// The link, and the images to compare the board's with.
#[derive(Args, Clone, Debug)]
pub(crate) struct StatusArgs {
    #[command(flatten)]
    task: TaskArgs,
    /// List of a release's images, to compare the board's with
    /// [default: images.json beside the program, if it is there].
    #[arg(long, value_name = "FILE")]
    images: Option<PathBuf>,
}

impl StatusArgs {
    fn list(&self) -> Result<Option<ImageList>, ImageListError> {
        match &self.images {
            Some(path) => ImageList::open(path).map(Some),
            None => ImageList::beside_program(),
        }
    }
}

pub(crate) fn run(args: &StatusArgs) -> Outcome {
    // Before the board, which is disarmed by a hello.
    let list = args.list()?;
    let (uri, host) = task::go(&args.task, "status", Pace::Free, Status::default())?;
    let mut out = Stdout;
    if args.task.json {
        writeln!(out, "{}", as_json(&uri, &host, list.as_ref()))?;
    } else {
        write!(out, "{}", as_text(&uri, &host, list.as_ref()))?;
    }
    Ok(ExitCode::SUCCESS)
}

fn as_text(uri: &BoardUri, host: &TaskHost<Status>, list: Option<&ImageList>) -> String {
    let mut rows = vec![
        ["link".to_owned(), format!("{uri} ({})", uri.world())],
        ["board".into(), board(host)],
    ];
    if let Some(report) = host.session.status().report {
        rows.push(["last end".into(), last_end(&report)]);
        rows.push(["settings".into(), settings_from(report.settings)]);
        rows.push(["stack".into(), stack(&report)]);
        rows.push(["image".into(), image(&report, list)]);
    }
    rows.push(["servos".into(), servos(host)]);
    rows.extend(mode(host));
    let joints = host.session.status().joints();
    rows.extend(
        (0..joints).map(|joint| [format!("joint {}", joint + 1), joint_in_words(host, joint)]),
    );
    if let Some(role) = host.session.status().role {
        rows.push(["commanded by".into(), commander(role)]);
    }
    rows.push(["link health".into(), health(host)]);
    rows.push(["round trip".into(), round_trip(host)]);
    let rows: Vec<Vec<String>> = rows.into_iter().map(Vec::from).collect();
    text_table::columns(&rows)
}

fn board(host: &TaskHost<Status>) -> String {
    let hello = host.session.status().hello.map_or_else(
        || "no hello".to_owned(),
        |hello| {
            let [major, minor, patch] = hello.version;
            let schema = u64::from_be_bytes(hello.schema);
            format!("version {major}.{minor}.{patch}, schema {schema:016x}")
        },
    );
    match host.session.status().report {
        Some(report) => format!("{hello}, session {:#x}", report.session),
        None => hello,
    }
}

fn last_end(report: &BoardReport) -> String {
    match report.last_end.cause {
        End::PowerUp => "power was switched on".into(),
        End::BrownOut
        | End::ResetPin
        | End::Software
        | End::Watchdog
        | End::Panic
        | End::HardFault
        | End::StackOverflow
        | End::Crystal => end_in_words(&report.last_end),
    }
}

/// Source of the settings, what of them is lost, and the remedy.
fn settings_from(from: SettingsFrom) -> String {
    let source = match from {
        SettingsFrom::Default => "the defaults; none were ever saved",
        SettingsFrom::Saved => "as saved on the board",
        SettingsFrom::Damaged => "the defaults: the saved ones are damaged",
        SettingsFrom::OtherVersion { .. } => "as saved by another version",
        SettingsFrom::Refused => "the defaults: the saved ones are beyond the hard bounds",
        SettingsFrom::Unreadable => "the defaults: the memory cannot be read",
    };
    let lost = from.lost();
    if lost.is_empty() {
        return source.to_owned();
    }
    let names: Vec<&str> = SETTINGS_GROUPS
        .iter()
        .filter(|(group, _)| lost.contains(*group))
        .map(|(_, name)| *name)
        .collect();
    format!(
        "{source}; lost: {}; the board does not arm before `params --save` confirms those in force",
        names.join(", ")
    )
}

/// Groups of settings that are stored, and lost, as a whole.
const SETTINGS_GROUPS: [(SettingsGroups, &str); 4] = [
    (SettingsGroups::CONTROL, "period, controller and estimator"),
    (SettingsGroups::ARM, "arm"),
    (SettingsGroups::JOINTS, "calibration"),
    (SettingsGroups::LIMITS, "limits"),
];

fn stack(report: &BoardReport) -> String {
    report.stack.map_or_else(
        || "not watched on this board".into(),
        |stack| {
            let percent = 100.0 * f64::from(stack.used) / f64::from(stack.size.max(1));
            format!(
                "{} of {} bytes used at most ({percent:.0} %)",
                stack.used, stack.size
            )
        },
    )
}

fn image(report: &BoardReport, list: Option<&ImageList>) -> String {
    match (report.image, list) {
        (None, _) => "none in flash: the program is not run from there".into(),
        (Some(crc), None) => format!("CRC-32 {crc:08x}"),
        (Some(crc), Some(list)) => format!("CRC-32 {crc:08x}: {}", list.in_words(crc)),
    }
}

/// The commanding program of a served board.
fn commander(role: LinkRole) -> String {
    match role.commander {
        _ if role.is_commander => "this program".into(),
        Some(program) => program.to_string(),
        None => "no program".into(),
    }
}

fn servos(host: &TaskHost<Status>) -> String {
    let status = host.session.status();
    match (status.servos, status.obstacle) {
        (
            Some(FoundServos {
                firmware,
                baud,
                is_ready: true,
            }),
            _,
        ) => {
            format!("{firmware}, {baud} baud, ready")
        }
        (
            Some(FoundServos {
                firmware,
                baud,
                is_ready: false,
            }),
            _,
        ) => format!(
            "{firmware}, {baud} baud; not set up for torque: `armbridge arm --prepare` sets them"
        ),
        (None, Some(obstacle)) => obstacle.to_string(),
        (None, None) => "not found yet".into(),
    }
}

fn mode(host: &TaskHost<Status>) -> Vec<[String; 2]> {
    let status = host.session.status();
    let Some(now) = status.mode() else {
        return vec![["mode".into(), "no tick received".into()]];
    };
    let (name, means) = fault_text::mode(now);
    let mut rows = vec![["mode".into(), format!("{name}: {means}")]];
    if let Some(tripped) = status.trip {
        let description = fault_text::in_words(&tripped);
        let measured = description
            .measured
            .map_or_else(String::new, |measured| format!(": {measured}"));
        rows.push([
            "fault".into(),
            format!("{}{measured} (tick {})", description.cause, tripped.tick),
        ]);
        if let Some(report) = &status.off {
            rows.push(["after it".into(), fault_text::off(report)]);
        }
        rows.push(["what to do".into(), description.remedy.into()]);
    }
    rows
}

/// In °C from a stock servo, in counts of its converter from Morpheus.
fn temperature(host: &TaskHost<Status>, joint: usize) -> Option<(u16, &'static str)> {
    let status = host.session.status();
    let servos = status.servos?;
    let value = status.temperature[joint]?;
    Some(match servos.firmware {
        Firmware::Morpheus => (value, "counts"),
        Firmware::Stock | Firmware::XSeries => (value, "degC"),
    })
}

fn joint_in_words(host: &TaskHost<Status>, joint: usize) -> String {
    let angle = host.session.status().record.map_or_else(
        || "angle not known".to_owned(),
        |record| {
            let counts = record.input.samples[joint]
                .counts()
                .map_or_else(|| "no sample".into(), |counts| format!("count {counts}"));
            format!("{:+.3} rad ({counts})", record.output.angle_rad[joint])
        },
    );
    match temperature(host, joint) {
        Some((value, unit)) => format!("{angle}, temperature {value} {unit}"),
        None => angle,
    }
}

fn health(host: &TaskHost<Status>) -> String {
    let stats = host.session.stats();
    format!(
        "{:.0} frames/s; {} lost, {} damaged, {} dropped by the board",
        host.task.frames_per_s(),
        stats.lost,
        stats.damaged,
        stats.dropped
    )
}

/// Median and longest in ms.
fn round_trip_ms(host: &TaskHost<Status>) -> Option<[f64; 2]> {
    let sorted = host.task.round_trips_us();
    let median = sorted.get(sorted.len() / 2)?;
    let longest = sorted.last()?;
    Some([*median, *longest].map(|us| us as f64 * 1e-3))
}

fn round_trip(host: &TaskHost<Status>) -> String {
    round_trip_ms(host).map_or_else(
        || "not measured: no command was sent".into(),
        |[median_ms, longest_ms]| {
            let count = host.task.round_trips_us().len();
            format!("median {median_ms:.1} ms, longest {longest_ms:.1} ms of {count}")
        },
    )
}

fn as_json(uri: &BoardUri, host: &TaskHost<Status>, list: Option<&ImageList>) -> Value {
    let status = host.session.status();
    let image = status.report.and_then(|report| report.image);
    let listed = image.and_then(|crc| list?.find(crc));
    let stats = host.session.stats();
    let mode = status.mode();
    let joints: Vec<Value> = (0..status.joints())
        .map(|joint| {
            let temperature = temperature(host, joint);
            json!({
                "angle_rad": status.record.map(|record| record.output.angle_rad[joint]),
                "counts": status.record.and_then(|record| record.input.samples[joint].counts()),
                "temperature": temperature.map(|(value, _)| value),
                "temperature_unit": temperature.map(|(_, unit)| unit),
            })
        })
        .collect();
    json!({
        "link": uri.to_string(),
        "world": uri.world(),
        "version": host.session.status().hello.map(|hello| hello.version.map(|part| part.to_string()).join(".")),
        "schema": host.session.status().hello.map(|hello| format!("{:016x}", u64::from_be_bytes(hello.schema))),
        "session": status.report.map(|report| report.session),
        "last_end": status.report.map(|report| last_end(&report)),
        "settings": status.report.map(|report| settings_from(report.settings)),
        "stack_used_bytes": status.report.and_then(|report| report.stack).map(|stack| stack.used),
        "stack_size_bytes": status.report.and_then(|report| report.stack).map(|stack| stack.size),
        "image_crc32": image.map(|crc| format!("{crc:08x}")),
        "image_release": list.map(|list| &list.version),
        "image_board": listed.map(|image| &image.board),
        "firmware": status.servos.map(|servos| servos.firmware.to_string()),
        "baud": status.servos.map(|servos| servos.baud),
        "ready": status.servos.map(|servos| servos.is_ready),
        "trouble": status.obstacle.map(|obstacle| obstacle.to_string()),
        "mode": mode.map(enum_names::mode),
        "fault": mode.and_then(enum_names::fault_of).map(Fault::name),
        "cause": status.trip.map(|tripped| fault_text::in_words(&tripped).cause),
        "advice": status.trip.map(|tripped| fault_text::in_words(&tripped).remedy),
        "joints": joints,
        "commanded_by": status.role.map(commander),
        "frames_per_s": host.task.frames_per_s(),
        "lost": stats.lost,
        "damaged": stats.damaged,
        "dropped": stats.dropped,
        "round_trip_median_ms": round_trip_ms(host).map(|[median, _]| median),
        "round_trip_longest_ms": round_trip_ms(host).map(|[_, longest]| longest),
    })
}
