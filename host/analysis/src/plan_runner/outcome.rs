//! How a run ended, as far as it went.

use armbridge_client::enum_names;
use armbridge_shared::JOINTS;
use armbridge_shared::link::message::{Drive, Fault, Mode, Record};

use super::plan::Stop;

/// What ended a run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Ending {
    /// Its time was over.
    Time,
    /// A joint was beyond the angle at which to stop.
    Angle {
        /// Counting from 0.
        joint: usize,
        /// Where it was.
        angle_rad: f32,
    },
    /// A joint was too far from its reference.
    Error {
        /// Counting from 0.
        joint: usize,
        /// Estimate less reference.
        error_rad: f32,
    },
    /// The board switched torque off.
    Fault(Fault),
    /// Ctrl-C.
    Interrupted,
}

impl Ending {
    /// The word for it in scenario files; a fault's own name is another.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Time => "time",
            Self::Angle { .. } => "angle",
            Self::Error { .. } => "error",
            Self::Fault(_) => "fault",
            Self::Interrupted => "interrupted",
        }
    }

    /// What happened, as part of a sentence.
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
                format!(
                    "the board switched torque off: {}",
                    enum_names::fault(*fault)
                )
            }
            Self::Interrupted => "ctrl-c; motors are off".into(),
        }
    }
}

/// Watches for the conditions of a [`Stop`].
#[derive(Debug, Default)]
pub(super) struct Watch {
    /// Since when each joint is too far from its reference, on the board's clock.
    apart_since_us: [Option<u64>; JOINTS],
}

impl Watch {
    /// Whether this tick ends the run.
    pub(super) fn see(&mut self, stop: &Stop, record: &Record) -> Option<Ending> {
        if let Mode::Fault(fault) = record.mode {
            return Some(Ending::Fault(fault));
        }
        (0..JOINTS).find_map(|joint| {
            let angle_rad = record.angle_rad[joint];
            if stop
                .angle_rad
                .is_some_and(|limit| angle_rad.abs() > limit[joint])
            {
                return Some(Ending::Angle { joint, angle_rad });
            }
            let error_rad = angle_rad - record.reference_rad[joint];
            let is_asked = matches!(record.mode.drive(), Some(Drive::Regulate | Drive::Track));
            let is_apart = stop
                .error_rad
                .is_some_and(|limit| error_rad.abs() > limit[joint]);
            if !(is_asked && is_apart) {
                self.apart_since_us[joint] = None;
                return None;
            }
            let since_us = *self.apart_since_us[joint].get_or_insert(record.start_us);
            (record.start_us.saturating_sub(since_us) >= stop.error_for_us)
                .then_some(Ending::Error { joint, error_rad })
        })
    }
}
