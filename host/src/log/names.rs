//! One word for each mode, fault and kind of missing sample.
//!
//! Log files, tables and plots all use these, so that a word found in one can
//! be searched for in the others.

use armbridge_shared::link::message::{Command, Fault, Missing, Mode};
use armbridge_shared::servo::protocol1::Alarms;

/// Every fault.
pub const FAULTS: [Fault; 6] = [
    Fault::HostSilent,
    Fault::SamplesLost,
    Fault::AngleLimit,
    Fault::Overrun,
    Fault::NotFinite,
    Fault::ServoAlarm,
];

/// Every kind of missing sample.
pub const MISSING: [Missing; 7] = [
    Missing::NotAsked,
    Missing::Silence,
    Missing::EchoOnly,
    Missing::BadChecksum,
    Missing::WrongId,
    Missing::Short,
    Missing::Line,
];

/// Every mode but the faults.
pub const MODES: [Mode; 6] = [
    Mode::BringUp,
    Mode::Idle,
    Mode::Torque,
    Mode::Regulate,
    Mode::Track,
    Mode::Passthrough,
];

/// Name of a mode; faults all are `fault`, see [`fault`].
pub fn mode(mode: Mode) -> &'static str {
    match mode {
        Mode::BringUp => "bring_up",
        Mode::Idle => "idle",
        Mode::Torque => "torque",
        Mode::Regulate => "regulate",
        Mode::Track => "track",
        Mode::Passthrough => "passthrough",
        Mode::Fault(_) => "fault",
    }
}

/// Name of a command.
pub fn command(command: &Command) -> &'static str {
    match command {
        Command::Idle => "idle",
        Command::Torque(_) => "torque",
        Command::Regulate(_) => "regulate",
        Command::Follow(_) => "follow",
        Command::Stream { .. } => "stream",
        Command::Prepare => "prepare",
        Command::Release => "release",
        Command::ClearFault => "clear_fault",
        Command::Configure(_) => "configure",
    }
}

/// Whether servos have been found.
pub fn is_up(mode: Mode) -> bool {
    !matches!(mode, Mode::BringUp | Mode::Passthrough)
}

/// The fault of a mode, if it is one.
pub fn fault_of(mode: Mode) -> Option<Fault> {
    match mode {
        Mode::Fault(fault) => Some(fault),
        _ => None,
    }
}

/// Name of a fault.
pub fn fault(fault: Fault) -> &'static str {
    match fault {
        Fault::HostSilent => "host_silent",
        Fault::SamplesLost => "samples_lost",
        Fault::AngleLimit => "angle_limit",
        Fault::Overrun => "overrun",
        Fault::NotFinite => "not_finite",
        Fault::ServoAlarm => "servo_alarm",
    }
}

/// What stands between the names of several alarms.
const AND: &str = "+";

/// Names of the alarms in a stock servo's error byte; empty for none.
pub fn alarms(bits: u8) -> String {
    let names: Vec<_> = Alarms::from_bits(bits).names().collect();
    names.join(AND)
}

/// The error byte whose alarms have these names.
pub fn alarms_from(names: &str) -> Option<u8> {
    let mut alarms = names.split(AND).filter(|name| !name.is_empty());
    let all = alarms.try_fold(Alarms::NONE, |all, name| {
        Alarms::by_name(name).map(|alarm| all.or(alarm))
    });
    all.map(Alarms::bits)
}

/// Name of a kind of missing sample.
pub fn missing(missing: Missing) -> &'static str {
    match missing {
        Missing::NotAsked => "not_asked",
        Missing::Silence => "silence",
        Missing::EchoOnly => "echo_only",
        Missing::BadChecksum => "bad_checksum",
        Missing::WrongId => "wrong_id",
        Missing::Short => "short",
        Missing::Line => "line",
    }
}

/// The mode with this name; `fault_name` is looked at for `fault` only.
pub fn mode_from(mode_name: &str, fault_name: &str) -> Option<Mode> {
    match mode_name {
        "fault" => FAULTS
            .into_iter()
            .find(|&f| fault(f) == fault_name)
            .map(Mode::Fault),
        name => MODES.into_iter().find(|&m| mode(m) == name),
    }
}

/// The kind of missing sample with this name.
pub fn missing_from(name: &str) -> Option<Missing> {
    MISSING.into_iter().find(|&m| missing(m) == name)
}
