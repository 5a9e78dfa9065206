//! Names of modes, faults and kinds of missing samples.
//!
//! Log files, tables and plots all use these, so that a name found in one can
//! be searched for in the others.

use armbridge_link::message::{Command, Drive, Fault, Guards, Missing, Mode, StopSource};
use armbridge_servo::Alarms;

use crate::servo_table::alarms;

/// Every fault.
pub const FAULTS: [Fault; 28] = [
    Fault::EmergencyStop(StopSource::Host),
    Fault::EmergencyStop(StopSource::Pin),
    Fault::EmergencyStop(StopSource::Flood),
    Fault::EmergencyStop(StopSource::Crystal),
    Fault::HostSilent,
    Fault::AngleLimit,
    Fault::SpeedLimit,
    Fault::TorqueLimit,
    Fault::TorqueRate,
    Fault::PwmLimit,
    Fault::Temperature,
    Fault::DeadZone,
    Fault::ServoSilent,
    Fault::ServoReset,
    Fault::SamplesLost,
    Fault::SamplesRare,
    Fault::Overrun,
    Fault::Clock,
    Fault::Diverged,
    Fault::Stuck,
    Fault::EncoderFrozen,
    Fault::ExternalTorque,
    Fault::MotorDirection,
    Fault::JointsSwapped,
    Fault::NotFinite,
    Fault::ServoAlarm,
    Fault::FirmwareChanged,
    Fault::Corrupted,
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
pub const MODES: [Mode; 15] = [
    Mode::Boot,
    Mode::Idle,
    Mode::MotorCheck,
    Mode::Armed,
    Mode::Running(Drive::Torque),
    Mode::Running(Drive::Regulate),
    Mode::Running(Drive::Track),
    Mode::Running(Drive::Hold),
    Mode::Running(Drive::Experiment),
    Mode::Degraded(Drive::Torque),
    Mode::Degraded(Drive::Regulate),
    Mode::Degraded(Drive::Track),
    Mode::Degraded(Drive::Hold),
    Mode::Degraded(Drive::Experiment),
    Mode::Passthrough,
];

/// Name of a mode; faults all are `fault`, see [`fault`].
pub fn mode(mode: Mode) -> &'static str {
    match mode {
        Mode::Boot => "boot",
        Mode::Idle => "idle",
        Mode::MotorCheck => "motor_check",
        Mode::Armed => "armed",
        Mode::Running(Drive::Torque) => "torque",
        Mode::Running(Drive::Regulate) => "regulate",
        Mode::Running(Drive::Track) => "track",
        Mode::Running(Drive::Hold) => "hold",
        Mode::Running(Drive::Experiment) => "experiment",
        Mode::Degraded(Drive::Torque) => "torque_degraded",
        Mode::Degraded(Drive::Regulate) => "regulate_degraded",
        Mode::Degraded(Drive::Track) => "track_degraded",
        Mode::Degraded(Drive::Hold) => "hold_degraded",
        Mode::Degraded(Drive::Experiment) => "experiment_degraded",
        Mode::Passthrough => "passthrough",
        Mode::Fault(_) => "fault",
    }
}

/// Name of a command.
pub fn command(command: &Command) -> &'static str {
    match command {
        Command::Idle => "idle",
        Command::Arm { .. } => "arm",
        Command::Torque(_) => "torque",
        Command::Regulate(_) => "regulate",
        Command::Follow(_) => "follow",
        Command::Stream { .. } => "stream",
        Command::Experiment(_) => "experiment",
        Command::Prepare => "prepare",
        Command::Release => "release",
        Command::ClearFault => "clear_fault",
        Command::Configure(_) => "configure",
        Command::Limit(_) => "limit",
        Command::Save => "save",
    }
}

/// Whether servos have been found.
pub fn is_up(mode: Mode) -> bool {
    !matches!(mode, Mode::Boot | Mode::Passthrough)
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
        Fault::EmergencyStop(StopSource::Host) => "emergency_stop_host",
        Fault::EmergencyStop(StopSource::Pin) => "emergency_stop_pin",
        Fault::EmergencyStop(StopSource::Flood) => "emergency_stop_flood",
        Fault::EmergencyStop(StopSource::Crystal) => "emergency_stop_crystal",
        Fault::HostSilent => "host_silent",
        Fault::AngleLimit => "angle_limit",
        Fault::SpeedLimit => "speed_limit",
        Fault::TorqueLimit => "torque_limit",
        Fault::TorqueRate => "torque_rate",
        Fault::PwmLimit => "pwm_limit",
        Fault::Temperature => "temperature",
        Fault::DeadZone => "dead_zone",
        Fault::ServoSilent => "servo_silent",
        Fault::ServoReset => "servo_reset",
        Fault::SamplesLost => "samples_lost",
        Fault::SamplesRare => "samples_rare",
        Fault::Overrun => "overrun",
        Fault::Clock => "clock",
        Fault::Diverged => "diverged",
        Fault::Stuck => "stuck",
        Fault::EncoderFrozen => "encoder_frozen",
        Fault::ExternalTorque => "external_torque",
        Fault::MotorDirection => "motor_direction",
        Fault::JointsSwapped => "joints_swapped",
        Fault::NotFinite => "not_finite",
        Fault::ServoAlarm => "servo_alarm",
        Fault::FirmwareChanged => "firmware_changed",
        Fault::Corrupted => "corrupted",
    }
}

/// Separator of several names.
const AND: &str = "+";

/// Names of the alarms in a stock servo's error byte; empty for none.
pub fn alarms(bits: u8) -> String {
    alarms::names(Alarms::from_bits(bits)).join(AND)
}

/// Limiters of the torque, and their names.
const GUARDS: [(Guards, &str); 4] = [
    (Guards::BRAKED, "braked"),
    (Guards::TORQUE, "torque"),
    (Guards::RATE, "rate"),
    (Guards::PWM, "pwm"),
];

/// Names of the limiters that changed a torque; empty for none.
pub fn guards(guards: Guards) -> String {
    let named = GUARDS.iter().filter(|(guard, _)| guards.contains(*guard));
    named.map(|(_, name)| *name).collect::<Vec<_>>().join(AND)
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
