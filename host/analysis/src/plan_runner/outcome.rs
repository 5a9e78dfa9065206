//! End of a run and its stop conditions.

use armbridge_client::ctrl_c;
use armbridge_link::message::{Drive, Fault, Mode, Record};
use armbridge_servo::JOINTS;

use super::plan::Stop;

/// Cause of the end of a run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Ending {
    /// The duration elapsed.
    Time,
    /// A joint exceeded the stop angle.
    Angle {
        /// Joint, counting from 0.
        joint: usize,
        /// Its angle in rad.
        angle_rad: f32,
    },
    /// A joint was too far from its reference.
    Error {
        /// Joint, counting from 0.
        joint: usize,
        /// Estimate minus reference in rad.
        error_rad: f32,
    },
    /// The board switched torque off.
    Fault(Fault),
    /// Ctrl-C.
    Interrupted,
}

impl Ending {
    /// Name in scenario files; a fault also has its own name.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Time => "time",
            Self::Angle { .. } => "angle",
            Self::Error { .. } => "error",
            Self::Fault(_) => "fault",
            Self::Interrupted => "interrupted",
        }
    }

    /// Description as part of a sentence.
    pub fn in_words(&self) -> String {
        match self {
            Self::Time => "its time was over".into(),
            Self::Angle { joint, angle_rad } => format!(
                "joint {} was at {angle_rad:+.3} rad, beyond the angle at which to stop",
                joint + 1
            ),
            Self::Error { joint, error_rad } => format!(
                "joint {} was {error_rad:+.3} rad from its reference, too far",
                joint + 1
            ),
            Self::Fault(fault) => {
                format!("the board switched torque off: {}", fault.name())
            }
            Self::Interrupted => format!("{}; motors are off", ctrl_c::in_words()),
        }
    }
}

/// Monitor of the conditions of a [`Stop`].
#[derive(Debug, Default)]
pub(super) struct StopMonitor {
    /// Start of each joint's excessive error, on the board's clock.
    error_since_us: [Option<u64>; JOINTS],
}

impl StopMonitor {
    /// Cause to end the run at this tick, if any.
    pub(super) fn check(&mut self, stop: &Stop, record: &Record) -> Option<Ending> {
        if let Mode::Fault(fault) = record.mode {
            return Some(Ending::Fault(fault));
        }
        (0..JOINTS).find_map(|joint| {
            let angle_rad = record.output.angle_rad[joint];
            if stop
                .angle_rad
                .is_some_and(|limit| angle_rad.abs() > limit[joint])
            {
                return Some(Ending::Angle { joint, angle_rad });
            }
            let error_rad = angle_rad - record.output.reference_rad[joint];
            let has_reference = matches!(record.mode.drive(), Some(Drive::Regulate | Drive::Track));
            let is_excessive = stop
                .error_rad
                .is_some_and(|limit| error_rad.abs() > limit[joint]);
            if !(has_reference && is_excessive) {
                self.error_since_us[joint] = None;
                return None;
            }
            let since_us = *self.error_since_us[joint].get_or_insert(record.input.start_us);
            (record.input.start_us.saturating_sub(since_us) >= stop.error_for_us)
                .then_some(Ending::Error { joint, error_rad })
        })
    }
}
