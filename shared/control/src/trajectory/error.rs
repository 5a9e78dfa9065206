//! Why a shape is refused.

use super::{Peak, Quantity};

/// Which argument of [`Trajectory::plan`](super::Trajectory::plan).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Argument {
    /// The reference to start from.
    From,
    /// Requested value.
    Shape,
    /// Permitted value.
    Bounds,
}

/// Why there is no such trajectory, or stream. Joints and waypoints count from 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Error<T> {
    /// Something in this argument is not finite.
    NotFinite(Argument),
    /// A bound is not positive.
    NoRoom(Quantity),
    /// Shorter than [`DURATION_MIN_S`](super::DURATION_MIN_S) or longer than [`DURATION_MAX_S`](super::DURATION_MAX_S).
    Duration {
        /// In s.
        value_s: T,
    },
    /// A ramp is shorter than [`DURATION_MIN_S`](super::DURATION_MIN_S), or longer than half of it all.
    Ramp {
        /// In s.
        value_s: T,
    },
    /// A frequency is negative or above [`FREQUENCY_MAX_HZ`](super::FREQUENCY_MAX_HZ).
    Frequency {
        /// Of this joint.
        joint: usize,
        /// In Hz.
        value_hz: T,
    },
    /// Not one waypoint.
    NoWaypoints,
    /// A waypoint is less than [`DURATION_MIN_S`](super::DURATION_MIN_S) after the one before or the
    /// start, or later than [`DURATION_MAX_S`](super::DURATION_MAX_S).
    WaypointTime {
        /// This one.
        waypoint: usize,
    },
    /// Waypoints so uneven in time that no smooth way through them was found.
    Uneven,
    /// A bound would be exceeded: most of all there.
    Exceeds(Peak<T>),
    /// No duration meets the bounds; the mildest excess of those tried.
    NoDuration(Peak<T>),
}
