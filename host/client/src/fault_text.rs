//! Faults and modes as text: the cause, the measured value against its limit, and the
//! remedy.

use std::fmt;

use crate::number_text::beside_limit;
use armbridge_link::message::{Drive, Fault, Mode, OffReport, OffState, Trip};

/// Explanation of a trip for the user. Lines without a full stop.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FaultDescription {
    /// Cause.
    pub cause: String,
    /// Value against limit; `None` where there are no numbers.
    pub measured: Option<String>,
    /// Remedy.
    pub remedy: &'static str,
}

/// Cause, value against limit, and remedy, in one sentence.
impl fmt::Display for FaultDescription {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.cause)?;
        if let Some(measured) = &self.measured {
            write!(f, " ({measured})")?;
        }
        write!(f, "; {}", self.remedy)
    }
}

/// Explains a trip.
pub fn in_words(trip: &Trip) -> FaultDescription {
    let cause = trip.fault.cause();
    let joint = trip.joint.map(|joint| u32::from(joint) + 1);
    FaultDescription {
        cause: joint.map_or_else(
            || cause.to_owned(),
            |joint| format!("joint {joint}: {cause}"),
        ),
        measured: measured(trip),
        remedy: trip.fault.remedy(),
    }
}

/// Value against limit, in the unit of the limit.
fn measured(trip: &Trip) -> Option<String> {
    let Trip { value, limit, .. } = *trip;
    let against = |unit: &str, digits: usize| {
        let [value, limit] = beside_limit(value, limit, digits);
        Some(format!("{value} {unit}, allowed are {limit}"))
    };
    match trip.fault {
        Fault::AngleLimit | Fault::Diverged => against("rad", 3),
        Fault::SpeedLimit => against("rad/s", 2),
        Fault::EncoderFrozen => against("ms", 0),
        Fault::TorqueLimit | Fault::Stuck | Fault::ExternalTorque => against("N m", 2),
        Fault::TorqueRate => against("N m/s", 0),
        Fault::PwmLimit => Some(format!("the limit is {limit:.0} counts from off")),
        // °C or counts, by the servo's firmware.
        Fault::Temperature => Some(format!("{value:.0}, allowed are {limit:.0}")),
        Fault::DeadZone => Some(format!("at count {value:.0}, the track ends at {limit:.0}")),
        Fault::HostSilent | Fault::Overrun => Some(format!(
            "{:.1} ms, allowed are {:.1}",
            value * 1e3,
            limit * 1e3
        )),
        Fault::ServoSilent | Fault::SamplesLost => {
            Some(format!("for {value:.0} ms, allowed are {limit:.0}"))
        }
        Fault::MotorDirection => Some(format!("{value:.2} of the model's motion")),
        Fault::JointsSwapped => Some(format!(
            "joint 1 responds {value:.2} times as much as joint 2"
        )),
        Fault::SamplesRare => Some(format!("{value:.0} %, allowed are {limit:.0}")),
        Fault::ServoReset => Some(format!("{value:.0} ticks without a sample")),
        Fault::Clock => Some(format!("by {:.1} ms", value * 1e3)),
        Fault::EmergencyStop(_)
        | Fault::NotFinite
        | Fault::ServoAlarm
        | Fault::FirmwareChanged
        | Fault::Corrupted => None,
    }
}

/// Name of a mode, and its meaning.
pub fn mode(mode: Mode) -> (&'static str, &'static str) {
    match mode {
        Mode::Boot => ("BOOT", "stop sequence, then the servos are looked for"),
        Mode::Idle => ("IDLE", "motors off, angles are read"),
        Mode::MotorCheck => ("CHECK", "moves each joint a little to test its motor"),
        Mode::Armed => ("ARMED", "ready to move, zero torque"),
        Mode::Running(Drive::Torque) => ("RUNNING", "constant torque"),
        Mode::Running(Drive::Regulate) => ("RUNNING", "regulates about the setpoint"),
        Mode::Running(Drive::Track) => ("RUNNING", "follows a motion, then rests at its end"),
        Mode::Running(Drive::Hold) => (
            "RUNNING",
            "the host was silent, or an experiment is over: braked, and holds",
        ),
        Mode::Running(Drive::Experiment) => ("RUNNING", "an experiment drives the arm"),
        Mode::Running(Drive::Float) => ("RUNNING", "weightless: lead it by hand"),
        Mode::Running(Drive::Park) => ("PARKING", "moves to its pose, and is lowered there"),
        Mode::Degraded(Drive::Torque) => ("DEGRADED", "constant torque; samples missing"),
        Mode::Degraded(Drive::Regulate) => ("DEGRADED", "regulates; samples missing, predicted"),
        Mode::Degraded(Drive::Track) => {
            ("DEGRADED", "follows a motion; samples missing, predicted")
        }
        Mode::Degraded(Drive::Hold) => ("DEGRADED", "braked, and holds; samples missing"),
        Mode::Degraded(Drive::Experiment) => ("DEGRADED", "an experiment; samples missing"),
        Mode::Degraded(Drive::Float) => ("DEGRADED", "weightless; samples missing, predicted"),
        Mode::Degraded(Drive::Park) => ("PARKING", "moves to its pose; samples missing"),
        Mode::Passthrough => (
            "PASSTHROUGH",
            "a program on the transparent port has the bus",
        ),
        Mode::Fault(_) => ("FAULT", "motors off, latched until it is cleared"),
    }
}

/// Report on motors that must be off, as text.
pub fn off(report: &OffReport) -> String {
    let joint = |state| match state {
        OffState::Off => "is seen to be off",
        OffState::Unconfirmed => {
            "was commanded off, which was not confirmed: switch its supply off"
        }
        OffState::OutOfReach => "does not answer, so that its motor may be on: check it",
    };
    let [first, second] = report.joints;
    if first == second {
        let both = match first {
            OffState::Off => "both motors are seen to be off",
            OffState::Unconfirmed => {
                "both motors were commanded off, which was not confirmed: switch the supply off"
            }
            OffState::OutOfReach => "neither servo answers, so that motors may be on: check them",
        };
        return both.to_owned();
    }
    format!("motor 1 {}, motor 2 {}", joint(first), joint(second))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_fault_has_cause_remedy_and_measured_value() {
        for fault in Fault::ALL {
            let description = in_words(&Trip {
                fault,
                joint: Some(1),
                tick: 3,
                at_us: 3_000,
                value: 1.6,
                limit: 1.5,
            });
            assert!(description.cause.starts_with("joint 2: "), "{fault:?}");
            assert!(!description.remedy.is_empty() && !description.remedy.ends_with('.'));
            // Each fits into a line of a terminal, with the text around it.
            let lengths = [&description.cause, description.remedy].map(|text| text.chars().count());
            assert!(lengths[0] <= 70 && lengths[1] <= 65, "{description:?}");
        }
        let trip = Trip {
            fault: Fault::HostSilent,
            joint: None,
            tick: 3,
            at_us: 3_000,
            value: 0.5123,
            limit: 0.5,
        };
        assert_eq!(
            in_words(&trip).measured.as_deref(),
            Some("512.3 ms, allowed are 500.0")
        );
    }
}
