//! A motion as the link carries it: plain arrays, and as many waypoints as fit.
//!
//! Their meaning, and the checks, are in
//! [`trajectory`](armbridge_control::trajectory).

use armbridge_control::trajectory::{Shape, WAYPOINTS_MAX, Waypoint};
use armbridge_servo::JOINTS;
use heapless::Vec;
use postcard::experimental::max_size::MaxSize;
use postcard_schema::Schema;
use serde::{Deserialize, Serialize};

/// Where to be, when.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, Schema, MaxSize)]
pub struct Via {
    /// In s since the start.
    pub at_s: f32,
    /// In rad.
    pub angle_rad: [f32; JOINTS],
}

/// A motion that the board computes itself, from wherever its reference is.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, Schema, MaxSize)]
pub enum Motion {
    /// Point to point with least jerk.
    MinimumJerk {
        /// In rad.
        to_rad: [f32; JOINTS],
        /// `None` for as soon as the bounds permit.
        duration_s: Option<f32>,
    },
    /// Through these angles with least jerk, to rest at the last; what comes
    /// after a `None` is not looked at.
    Waypoints([Option<Via>; WAYPOINTS_MAX]),
    /// `centre + amplitude sin(2 pi frequency t + phase)`.
    Sinusoid {
        /// In rad.
        centre_rad: [f32; JOINTS],
        /// In rad.
        amplitude_rad: [f32; JOINTS],
        /// In Hz.
        frequency_hz: [f32; JOINTS],
        /// In rad.
        phase_rad: [f32; JOINTS],
        /// For the wave to grow, and to die away, in s.
        ramp_s: f32,
        /// Both ramps included.
        duration_s: f32,
    },
    /// The same with a frequency that changes linearly with time.
    Chirp {
        /// In rad.
        centre_rad: [f32; JOINTS],
        /// In rad.
        amplitude_rad: [f32; JOINTS],
        /// At the start, in Hz.
        from_hz: [f32; JOINTS],
        /// At the end, in Hz.
        to_hz: [f32; JOINTS],
        /// For the wave to grow, and to die away, in s.
        ramp_s: f32,
        /// Both ramps included.
        duration_s: f32,
    },
}

impl Motion {
    /// First angle in rad other than 0 that it asks of a joint.
    pub(crate) fn demand_of(&self, joint: usize) -> Option<f32> {
        let is_demand = |angles: &&[f32; JOINTS]| angles.get(joint).is_some_and(|rad| *rad != 0.0);
        let angles = match self {
            Self::MinimumJerk { to_rad, .. } => Some(to_rad).filter(is_demand),
            Self::Waypoints(vias) => {
                let vias = vias.iter().map_while(Option::as_ref);
                vias.map(|via| &via.angle_rad).find(is_demand)
            }
            Self::Sinusoid {
                centre_rad,
                amplitude_rad,
                ..
            }
            | Self::Chirp {
                centre_rad,
                amplitude_rad,
                ..
            } => [centre_rad, amplitude_rad].into_iter().find(is_demand),
        };
        angles.and_then(|angles| angles.get(joint).copied())
    }

    /// Shape for the planner.
    ///
    /// ```
    /// use armbridge_control::trajectory::{Shape, Waypoint};
    /// use armbridge_link::motion::{Motion, Via};
    ///
    /// let mut vias = [None; 8];
    /// vias[0] = Some(Via { at_s: 0.5, angle_rad: [0.3, 0.0] });
    /// vias[1] = Some(Via { at_s: 1.0, angle_rad: [0.0, 0.0] });
    /// let Shape::Waypoints { points } = Motion::Waypoints(vias).shape() else { panic!() };
    /// assert_eq!(points.len(), 2);
    /// assert_eq!(points[0], Waypoint { at_s: 0.5, q: [0.3, 0.0].into() });
    /// ```
    pub fn shape(&self) -> Shape<f32> {
        match *self {
            Self::MinimumJerk { to_rad, duration_s } => Shape::MinimumJerk {
                to: to_rad.into(),
                duration_s,
            },
            Self::Waypoints(vias) => {
                let mut points = Vec::new();
                for via in vias.into_iter().map_while(|via| via) {
                    // There is room for all that there can be.
                    let _ = points.push(Waypoint {
                        at_s: via.at_s,
                        q: via.angle_rad.into(),
                    });
                }
                Shape::Waypoints { points }
            }
            Self::Sinusoid {
                centre_rad,
                amplitude_rad,
                frequency_hz,
                phase_rad,
                ramp_s,
                duration_s,
            } => Shape::Sinusoid {
                centre: centre_rad.into(),
                amplitude_rad: amplitude_rad.into(),
                frequency_hz: frequency_hz.into(),
                phase_rad: phase_rad.into(),
                ramp_s,
                duration_s,
            },
            Self::Chirp {
                centre_rad,
                amplitude_rad,
                from_hz,
                to_hz,
                ramp_s,
                duration_s,
            } => Shape::Chirp {
                centre: centre_rad.into(),
                amplitude_rad: amplitude_rad.into(),
                from_hz: from_hz.into(),
                to_hz: to_hz.into(),
                ramp_s,
                duration_s,
            },
        }
    }
}
