//! Facts that the replay reads from one record.

use armbridge_link::message::{Fault, Record};
use armbridge_servo::Pwm;

/// Whether a fault has a cause that no record shows. Such a fault is replayed by
/// `Board::trip`; the others are decided again.
pub(super) const fn is_external(fault: Fault) -> bool {
    match fault {
        Fault::EmergencyStop(_)
        | Fault::Temperature
        | Fault::ServoReset
        | Fault::Clock
        | Fault::FirmwareChanged => true,
        // The first two occur within a decision: see `HostEvent`.
        Fault::HostSilent
        | Fault::Corrupted
        | Fault::AngleLimit
        | Fault::SpeedLimit
        | Fault::TorqueLimit
        | Fault::TorqueRate
        | Fault::PwmLimit
        | Fault::DeadZone
        | Fault::ServoSilent
        | Fault::SamplesLost
        | Fault::SamplesRare
        | Fault::Overrun
        | Fault::Diverged
        | Fault::Stuck
        | Fault::EncoderFrozen
        | Fault::ExternalTorque
        | Fault::MotorDirection
        | Fault::JointsSwapped
        | Fault::NotFinite
        | Fault::ServoAlarm => false,
    }
}

/// Planned start of a recorded tick, in µs.
pub(super) const fn planned_us(record: &Record) -> u64 {
    record
        .start_us
        .saturating_sub(record.timing.start_error_us as u64)
}

/// Whether the motors are off in this tick.
pub(super) fn is_off(record: &Record) -> bool {
    let off = Pwm::OFF.counts();
    record.pwm_in_force.iter().all(|pwm| *pwm == off)
}

/// Whether every joint has a sample: a restarted estimator needs them.
pub(super) fn is_complete(record: &Record) -> bool {
    record
        .samples
        .iter()
        .all(|sample| sample.counts().is_some())
}

/// Event that only a record's mode shows, so that it cannot be decided again.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum HostEvent {
    /// No such event.
    None,
    /// Silence of the host after which the arm is braked, or torque goes off.
    Silence,
    /// Silence of the host that is a fault.
    LongSilence,
    /// Corruption of numbers in memory.
    Corruption,
}
