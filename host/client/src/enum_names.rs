//! Names of modes, commands and kinds of missing samples. Those of faults are in
//! [`Fault`].
//!
//! Log files, tables and plots all use these, so that a name found in one can
//! be searched for in the others.

use armbridge_link::message::{Command, Drive, Fault, Guards, Missing, Mode};
use armbridge_servo::Alarms;

use crate::servo_table::alarms;

/// Declares the values of an enum with their names: all values, and the name of one.
macro_rules! names {
    (
        $(#[$doc:meta])* $all:ident
        $(#[$name_doc:meta])* $name_of:ident($enum:ident)
        { $($value:ident $(($inner:path))? $name:literal,)* $(; $rest:pat => $rest_name:literal)? }
    ) => {
        $(#[$doc])*
        pub const $all: [$enum; [$($name),*].len()] = [$($enum::$value $(($inner))?),*];

        $(#[$name_doc])*
        pub const fn $name_of(value: $enum) -> &'static str {
            match value {
                $($enum::$value $(($inner))? => $name,)*
                $($rest => $rest_name,)?
            }
        }
    };
}

names! {
    /// Every mode but the faults.
    MODES
    /// Name of a mode; faults all are `fault`, see [`Fault::name`].
    mode(Mode)
    {
        Boot "boot",
        Idle "idle",
        MotorCheck "motor_check",
        Armed "armed",
        Running(Drive::Torque) "torque",
        Running(Drive::Regulate) "regulate",
        Running(Drive::Track) "track",
        Running(Drive::Hold) "hold",
        Running(Drive::Experiment) "experiment",
        Running(Drive::Float) "float",
        Running(Drive::Park) "park",
        Degraded(Drive::Torque) "torque_degraded",
        Degraded(Drive::Regulate) "regulate_degraded",
        Degraded(Drive::Track) "track_degraded",
        Degraded(Drive::Hold) "hold_degraded",
        Degraded(Drive::Experiment) "experiment_degraded",
        Degraded(Drive::Float) "float_degraded",
        Degraded(Drive::Park) "park_degraded",
        Passthrough "passthrough",
        ; Mode::Fault(_) => "fault"
    }
}

names! {
    /// Every kind of missing sample.
    MISSING
    /// Name of a kind of missing sample.
    missing(Missing)
    {
        NotAsked "not_asked",
        Silence "silence",
        EchoOnly "echo_only",
        BadChecksum "bad_checksum",
        WrongId "wrong_id",
        Short "short",
        Line "line",
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
        Command::Float => "float",
        Command::Park => "park",
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
