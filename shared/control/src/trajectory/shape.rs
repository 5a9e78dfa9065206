//! Shapes of motions, as plain data.

use super::WAYPOINTS_MAX;
use crate::real::Real;
use heapless::Vec;
use nalgebra::{ComplexField, Vector2};

/// An angle to pass.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Waypoint<T> {
    /// In s since the start.
    pub at_s: T,
    /// In rad.
    pub q: Vector2<T>,
}

/// Shape of a motion of both joints.
#[derive(Clone, Debug, PartialEq)]
pub enum Shape<T> {
    /// Rest at these angles, from now on. A regulator's setpoint: the only shape
    /// that does not care where the arm is.
    Hold {
        /// In rad.
        q: Vector2<T>,
    },
    /// To these angles with least jerk.
    MinimumJerk {
        /// In rad.
        to: Vector2<T>,
        /// `None` for as soon as the bounds permit.
        duration_s: Option<T>,
    },
    /// Through angles at times with least jerk, to rest at the last.
    Waypoints {
        /// In order of time.
        points: Vec<Waypoint<T>, WAYPOINTS_MAX>,
    },
    /// `centre + amplitude sin(2 pi frequency t + phase)`, at rest at the centre in
    /// the end.
    Sinusoid {
        /// In rad; approached while the wave grows.
        centre: Vector2<T>,
        /// In rad; 0 leaves a joint at the centre.
        amplitude_rad: Vector2<T>,
        /// In Hz.
        frequency_hz: Vector2<T>,
        /// In rad.
        phase_rad: Vector2<T>,
        /// For the wave to grow, and to die away, in s.
        ramp_s: T,
        /// Both ramps included.
        duration_s: T,
    },
    /// The same with a frequency that changes linearly with time.
    Chirp {
        /// In rad; approached while the wave grows.
        centre: Vector2<T>,
        /// In rad; 0 leaves a joint at the centre.
        amplitude_rad: Vector2<T>,
        /// At the start, in Hz.
        from_hz: Vector2<T>,
        /// At the end, in Hz.
        to_hz: Vector2<T>,
        /// For the wave to grow, and to die away, in s.
        ramp_s: T,
        /// Both ramps included.
        duration_s: T,
    },
}

impl<T: Real> Shape<T> {
    pub(super) fn is_finite(&self) -> bool {
        let vectors = |vectors: &[&Vector2<T>]| {
            let mut entries = vectors.iter().flat_map(|v| v.iter());
            entries.all(ComplexField::is_finite)
        };
        match self {
            Self::Hold { q } => vectors(&[q]),
            Self::MinimumJerk { to, duration_s } => {
                vectors(&[to]) && duration_s.is_none_or(|x| x.is_finite())
            }
            Self::Waypoints { points } => points
                .iter()
                .all(|point| point.at_s.is_finite() && vectors(&[&point.q])),
            Self::Sinusoid {
                centre,
                amplitude_rad,
                frequency_hz,
                phase_rad,
                ramp_s,
                duration_s,
            } => {
                vectors(&[centre, amplitude_rad, frequency_hz, phase_rad])
                    && ramp_s.is_finite()
                    && duration_s.is_finite()
            }
            Self::Chirp {
                centre,
                amplitude_rad,
                from_hz,
                to_hz,
                ramp_s,
                duration_s,
            } => {
                vectors(&[centre, amplitude_rad, from_hz, to_hz])
                    && ramp_s.is_finite()
                    && duration_s.is_finite()
            }
        }
    }
}
