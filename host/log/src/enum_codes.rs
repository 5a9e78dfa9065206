//! Modes, faults and kinds of missing samples as the numbers of the log's schema.

use armbridge_link::message::{self as link, Drive, StopSource};

use super::proto;

/// Numbers of a mode and its fault.
pub(super) fn mode(mode: link::Mode) -> (proto::Mode, proto::Fault) {
    let drives = match mode {
        link::Mode::Boot => proto::Mode::Boot,
        link::Mode::Idle => proto::Mode::Idle,
        link::Mode::MotorCheck => proto::Mode::MotorCheck,
        link::Mode::Armed => proto::Mode::Armed,
        link::Mode::Running(Drive::Torque) => proto::Mode::Torque,
        link::Mode::Running(Drive::Regulate) => proto::Mode::Regulate,
        link::Mode::Running(Drive::Track) => proto::Mode::Track,
        link::Mode::Running(Drive::Hold) => proto::Mode::Hold,
        link::Mode::Running(Drive::Experiment) => proto::Mode::Experiment,
        link::Mode::Degraded(Drive::Torque) => proto::Mode::TorqueDegraded,
        link::Mode::Degraded(Drive::Regulate) => proto::Mode::RegulateDegraded,
        link::Mode::Degraded(Drive::Track) => proto::Mode::TrackDegraded,
        link::Mode::Degraded(Drive::Hold) => proto::Mode::HoldDegraded,
        link::Mode::Degraded(Drive::Experiment) => proto::Mode::ExperimentDegraded,
        link::Mode::Passthrough => proto::Mode::Passthrough,
        link::Mode::Fault(cause) => return (proto::Mode::Fault, fault(cause)),
    };
    (drives, proto::Fault::None)
}

/// The mode of these numbers; `None` for a fault without a cause.
pub(super) fn mode_from(mode: proto::Mode, fault: proto::Fault) -> Option<link::Mode> {
    Some(match mode {
        proto::Mode::Boot => link::Mode::Boot,
        proto::Mode::Idle => link::Mode::Idle,
        proto::Mode::MotorCheck => link::Mode::MotorCheck,
        proto::Mode::Armed => link::Mode::Armed,
        proto::Mode::Torque => link::Mode::Running(Drive::Torque),
        proto::Mode::Regulate => link::Mode::Running(Drive::Regulate),
        proto::Mode::Track => link::Mode::Running(Drive::Track),
        proto::Mode::Hold => link::Mode::Running(Drive::Hold),
        proto::Mode::Experiment => link::Mode::Running(Drive::Experiment),
        proto::Mode::TorqueDegraded => link::Mode::Degraded(Drive::Torque),
        proto::Mode::RegulateDegraded => link::Mode::Degraded(Drive::Regulate),
        proto::Mode::TrackDegraded => link::Mode::Degraded(Drive::Track),
        proto::Mode::HoldDegraded => link::Mode::Degraded(Drive::Hold),
        proto::Mode::ExperimentDegraded => link::Mode::Degraded(Drive::Experiment),
        proto::Mode::Passthrough => link::Mode::Passthrough,
        proto::Mode::Fault => link::Mode::Fault(fault_from(fault)?),
    })
}

fn fault(fault: link::Fault) -> proto::Fault {
    use link::Fault as F;
    match fault {
        F::EmergencyStop(StopSource::Host) => proto::Fault::EmergencyStopHost,
        F::EmergencyStop(StopSource::Pin) => proto::Fault::EmergencyStopPin,
        F::EmergencyStop(StopSource::Flood) => proto::Fault::EmergencyStopFlood,
        F::EmergencyStop(StopSource::Crystal) => proto::Fault::EmergencyStopCrystal,
        F::HostSilent => proto::Fault::HostSilent,
        F::AngleLimit => proto::Fault::AngleLimit,
        F::SpeedLimit => proto::Fault::SpeedLimit,
        F::TorqueLimit => proto::Fault::TorqueLimit,
        F::TorqueRate => proto::Fault::TorqueRate,
        F::PwmLimit => proto::Fault::PwmLimit,
        F::Temperature => proto::Fault::Temperature,
        F::DeadZone => proto::Fault::DeadZone,
        F::ServoSilent => proto::Fault::ServoSilent,
        F::ServoReset => proto::Fault::ServoReset,
        F::SamplesLost => proto::Fault::SamplesLost,
        F::SamplesRare => proto::Fault::SamplesRare,
        F::Overrun => proto::Fault::Overrun,
        F::Clock => proto::Fault::Clock,
        F::Diverged => proto::Fault::Diverged,
        F::Stuck => proto::Fault::Stuck,
        F::EncoderFrozen => proto::Fault::EncoderFrozen,
        F::ExternalTorque => proto::Fault::ExternalTorque,
        F::MotorDirection => proto::Fault::MotorDirection,
        F::JointsSwapped => proto::Fault::JointsSwapped,
        F::NotFinite => proto::Fault::NotFinite,
        F::ServoAlarm => proto::Fault::ServoAlarm,
        F::FirmwareChanged => proto::Fault::FirmwareChanged,
        F::Corrupted => proto::Fault::Corrupted,
    }
}

fn fault_from(fault: proto::Fault) -> Option<link::Fault> {
    use link::Fault as F;
    Some(match fault {
        proto::Fault::None => return None,
        proto::Fault::EmergencyStopHost => F::EmergencyStop(StopSource::Host),
        proto::Fault::EmergencyStopPin => F::EmergencyStop(StopSource::Pin),
        proto::Fault::EmergencyStopFlood => F::EmergencyStop(StopSource::Flood),
        proto::Fault::EmergencyStopCrystal => F::EmergencyStop(StopSource::Crystal),
        proto::Fault::HostSilent => F::HostSilent,
        proto::Fault::AngleLimit => F::AngleLimit,
        proto::Fault::SpeedLimit => F::SpeedLimit,
        proto::Fault::TorqueLimit => F::TorqueLimit,
        proto::Fault::TorqueRate => F::TorqueRate,
        proto::Fault::PwmLimit => F::PwmLimit,
        proto::Fault::Temperature => F::Temperature,
        proto::Fault::DeadZone => F::DeadZone,
        proto::Fault::ServoSilent => F::ServoSilent,
        proto::Fault::ServoReset => F::ServoReset,
        proto::Fault::SamplesLost => F::SamplesLost,
        proto::Fault::SamplesRare => F::SamplesRare,
        proto::Fault::Overrun => F::Overrun,
        proto::Fault::Clock => F::Clock,
        proto::Fault::Diverged => F::Diverged,
        proto::Fault::Stuck => F::Stuck,
        proto::Fault::EncoderFrozen => F::EncoderFrozen,
        proto::Fault::ExternalTorque => F::ExternalTorque,
        proto::Fault::MotorDirection => F::MotorDirection,
        proto::Fault::JointsSwapped => F::JointsSwapped,
        proto::Fault::NotFinite => F::NotFinite,
        proto::Fault::ServoAlarm => F::ServoAlarm,
        proto::Fault::FirmwareChanged => F::FirmwareChanged,
        proto::Fault::Corrupted => F::Corrupted,
    })
}

/// Number of a kind of missing sample.
pub(super) fn missing(missing: link::Missing) -> proto::Missing {
    match missing {
        link::Missing::NotAsked => proto::Missing::NotAsked,
        link::Missing::Silence => proto::Missing::Silence,
        link::Missing::EchoOnly => proto::Missing::EchoOnly,
        link::Missing::BadChecksum => proto::Missing::BadChecksum,
        link::Missing::WrongId => proto::Missing::WrongId,
        link::Missing::Short => proto::Missing::Short,
        link::Missing::Line => proto::Missing::Line,
    }
}

/// The kind of missing sample of this number.
pub(super) fn missing_from(missing: proto::Missing) -> Option<link::Missing> {
    Some(match missing {
        proto::Missing::None => return None,
        proto::Missing::NotAsked => link::Missing::NotAsked,
        proto::Missing::Silence => link::Missing::Silence,
        proto::Missing::EchoOnly => link::Missing::EchoOnly,
        proto::Missing::BadChecksum => link::Missing::BadChecksum,
        proto::Missing::WrongId => link::Missing::WrongId,
        proto::Missing::Short => link::Missing::Short,
        proto::Missing::Line => link::Missing::Line,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use armbridge_client::enum_names::{FAULTS, MISSING, MODES};

    #[test]
    fn every_number_maps_back_to_its_value() {
        let modes = MODES.into_iter();
        for known in modes.chain(FAULTS.into_iter().map(link::Mode::Fault)) {
            let (number, fault) = mode(known);
            assert_eq!(mode_from(number, fault), Some(known));
        }
        for known in MISSING {
            assert_eq!(missing_from(missing(known)), Some(known));
        }
    }
}
