//! Events as text, and their severity.

use armbridge_client::event::Direction;
use armbridge_client::{experiment_text, fault_text, refusal_text};
use armbridge_link::frame::FrameError;
use armbridge_link::message::{
    BoardReport, End, Missing, Mode, OffState, SettingsFrom, ToHost, Trip,
};

use super::proto::Severity;

/// Kind, severity and text of a board's message, other than records and settings.
pub fn describe(message: &ToHost) -> (&'static str, Severity, String) {
    match message {
        ToHost::Hello(hello) => {
            let [major, minor, patch] = hello.version;
            let text = format!("hello of the board, version {major}.{minor}.{patch}");
            ("hello", Severity::Info, text)
        }
        ToHost::Ack {
            sequence,
            result: Ok(()),
            ..
        } => {
            let text = format!("command in frame {sequence} accepted");
            ("ack", Severity::Debug, text)
        }
        ToHost::Ack {
            sequence,
            result: Err(refusal),
            ..
        } => {
            let reason = refusal_text::in_words(*refusal);
            let text = format!("command in frame {sequence} refused: {reason}");
            ("ack", Severity::Warning, text)
        }
        ToHost::Departs { sequence, moment } => {
            let text = format!("motion of frame {sequence} departs in tick {}", moment.tick);
            ("departs", Severity::Debug, text)
        }
        ToHost::Began(moment) => {
            let text = format!("motors off, estimator begins anew in tick {}", moment.tick);
            ("began", Severity::Info, text)
        }
        ToHost::Settings(_) => ("settings", Severity::Info, "settings in force".into()),
        ToHost::Absent { joint, missing } => (
            "absent",
            Severity::Warning,
            format!(
                "{} does not answer: {}",
                servo(*joint),
                missing_reply(*missing)
            ),
        ),
        ToHost::Found { firmware, baud, .. } => (
            "found",
            Severity::Info,
            format!("servos found: {firmware}, {baud} bit/s"),
        ),
        ToHost::Mixed([first, second]) => (
            "mixed",
            Severity::Error,
            format!("servo 1 runs {first} and servo 2 {second}: neither is driven"),
        ),
        ToHost::Unprepared { joint } => (
            "unprepared",
            Severity::Error,
            format!("{} does not take what it must be set to", servo(*joint)),
        ),
        ToHost::Passthrough => (
            "passthrough",
            Severity::Info,
            "a program at the transparent port has the bus".into(),
        ),
        ToHost::Port(port) => (
            "port",
            Severity::Debug,
            format!(
                "transparent port: {} packets passed, {} refused",
                port.passed, port.refused
            ),
        ),
        ToHost::Board(report) => ("board", board_severity(report), board(report)),
        ToHost::Tripped(trip) => ("tripped", Severity::Error, tripped(trip)),
        ToHost::Off(report) => {
            let is_off = report.joints.iter().all(|j| *j == OffState::Off);
            let severity = if is_off {
                Severity::Info
            } else {
                Severity::Error
            };
            let text = format!("after the stop sequence, {}", fault_text::off(report));
            ("off", severity, text)
        }
        ToHost::Concluded(conclusion) => {
            let severity = if experiment_text::is_whole(conclusion) {
                Severity::Info
            } else {
                Severity::Warning
            };
            (
                "concluded",
                severity,
                experiment_text::conclusion(conclusion),
            )
        }
        ToHost::Temperature { joint, value } => (
            "temperature",
            Severity::Debug,
            format!("temperature of {}: {value}", servo(*joint)),
        ),
        ToHost::Record(record) => ("record", Severity::Debug, format!("tick {}", record.tick)),
    }
}

fn missing_reply(missing: Missing) -> &'static str {
    match missing {
        Missing::NotAsked => "it has not been asked",
        Missing::Silence => "nothing was received",
        Missing::EchoOnly => "only our own bytes were received",
        Missing::BadChecksum => "a damaged reply was received",
        Missing::WrongId => "another servo answered",
        Missing::Short => "its reply broke off",
        Missing::Line => "the line was disturbed",
    }
}

fn tripped(tripped: &Trip) -> String {
    let (tick, description) = (tripped.tick, fault_text::in_words(tripped));
    format!("fault in tick {tick}: {description}")
}

fn board_severity(report: &BoardReport) -> Severity {
    match report.last_end.cause {
        End::PowerUp | End::ResetPin | End::Software => Severity::Info,
        End::BrownOut
        | End::Watchdog
        | End::Panic
        | End::HardFault
        | End::StackOverflow
        | End::Crystal => Severity::Warning,
    }
}

fn board(report: &BoardReport) -> String {
    let end = match report.last_end.cause {
        End::PowerUp => "power was switched on",
        End::BrownOut => "its supply sagged",
        End::ResetPin => "its reset pin was pulled",
        End::Software => "its program asked for a reset",
        End::Watchdog => "its watchdog bit",
        End::Panic => "its program panicked",
        End::HardFault => "its processor faulted",
        End::StackOverflow => "its stack overflowed",
        End::Crystal => "its crystal stopped",
    };
    let settings = match report.settings {
        SettingsFrom::Default => "default settings",
        SettingsFrom::Saved => "saved settings",
        SettingsFrom::Damaged => "default settings, the saved are damaged",
        SettingsFrom::OtherVersion { .. } => "settings of another version, some of them lost",
        SettingsFrom::Refused => "default settings, the saved are beyond bounds",
        SettingsFrom::Unreadable => "default settings, the memory cannot be read",
    };
    format!("board session {:#x}: {end}; {settings}", report.session)
}

/// A frame that cannot be decoded: its number in the schema, and text.
pub(super) fn garbled(direction: Direction, error: FrameError) -> (u32, u32, String) {
    let (code, version, what) = match error {
        FrameError::Damaged => (1, 0, "is damaged".into()),
        FrameError::Version(version) => (
            2,
            version,
            format!("has layout version {version}, which this program does not know"),
        ),
        FrameError::Direction => (3, 0, "travels the wrong way: an echo, or two hosts".into()),
        FrameError::Schema => (4, 0, "is of a board with another schema".into()),
    };
    (
        code,
        version.into(),
        format!("a frame {} {what}", towards(direction)),
    )
}

/// Lost frames.
pub(super) fn lost(direction: Direction, count: u16) -> String {
    format!("{count} frames {} went missing", towards(direction))
}

fn towards(direction: Direction) -> &'static str {
    match direction {
        Direction::ToBoard => "to the board",
        Direction::ToHost => "from the board",
    }
}

/// The start of a mode.
pub(super) fn mode(mode: Mode) -> (Severity, String) {
    let (name, meaning) = fault_text::mode(mode);
    match mode {
        Mode::Fault(fault) => {
            let cause = fault.cause();
            (Severity::Error, format!("{name}: {cause}; {meaning}"))
        }
        Mode::Degraded(_) => (Severity::Warning, format!("{name}: {meaning}")),
        Mode::Boot
        | Mode::Idle
        | Mode::MotorCheck
        | Mode::Armed
        | Mode::Running(_)
        | Mode::Passthrough => (Severity::Info, format!("{name}: {meaning}")),
    }
}

/// A joint's servo. The joint may be any number of a damaged message.
fn servo(joint: u8) -> String {
    format!("servo {}", u16::from(joint) + 1)
}
