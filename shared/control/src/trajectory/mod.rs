//! Trajectories that the board computes itself.
//!
//! A [`Shape`] describes the motion, as plain data. [`Trajectory::plan`] joins it to
//! whatever reference is in force, checks it against [`Bounds`] and makes it ready;
//! that may take milliseconds and is not for the tick. [`Trajectory::at`] is: it
//! returns the [`Reference`] for a time since the start and depends on nothing else. On
//! a Cortex-M4F it takes some 90 instructions, 130 with eight waypoints, 310 with a wave.
//!
//! | shape                     | motion                                             |
//! |---------------------------|----------------------------------------------------|
//! | [`Shape::Hold`]           | rest, at once: a step if the arm is elsewhere       |
//! | [`Shape::MinimumJerk`]    | point to point by a quintic                         |
//! | [`Shape::Waypoints`]      | the spline of least jerk through angles at times    |
//! | [`Shape::Sinusoid`]       | constant frequency about a centre                   |
//! | [`Shape::Chirp`]          | a frequency that grows or falls linearly            |
//!
//! [`stream`] is for references that the host computes while the arm moves.
//!
//! # Continuity
//!
//! All but `Hold` begin with the angle, speed and acceleration of the reference that
//! they are planned from, are continuous in all three throughout, and end at rest:
//! beyond the end [`Trajectory::at`] holds the last angle. So one may be replaced by
//! another at any time.
//!
//! # Bounds
//!
//! Quintics are checked exactly. Waves are checked at their worst phase: refused if
//! at any time they *could* be beyond a bound, were their phase unlucky. Between the
//! ramps that is the amplitude, and true for every wave of more than a turn or two.
//!
//! # Time
//!
//! In s since the start. In `f32` a millisecond is kept apart to 3 % at the longest
//! duration, [`DURATION_MAX_S`].
//!
//! # Example
//!
//! ```
//! use armbridge_control::trajectory::{Bounds, Error, Quantity, Reference, Shape, Trajectory};
//! use nalgebra::Vector2;
//!
//! let bounds = Bounds {
//!     angle_rad: 1.2_f64,
//!     speed_rad_s: 4.0,
//!     acceleration_rad_s2: 20.0,
//!     jerk_rad_s3: 4_000.0,
//! };
//! let from = Reference::at_rest(Vector2::zeros());
//! let to = Vector2::new(0.6, -0.4);
//!
//! let motion = Shape::MinimumJerk { to, duration_s: Some(0.8) };
//! let trajectory = Trajectory::plan(from, &motion, &bounds).unwrap();
//! // Half way in half the time, at 15/8 of the mean speed.
//! let middle = trajectory.at(0.4);
//! assert!((middle.q - to / 2.0).amax() < 1e-12);
//! assert!((middle.dq - to / 0.8 * 1.875).amax() < 1e-12);
//! assert_eq!(trajectory.at(0.8), Reference::at_rest(to));
//!
//! // The same in 0.2 s takes more than 4 rad/s, or more than 20 rad/s^2.
//! let hurry = Shape::MinimumJerk { to, duration_s: Some(0.2) };
//! let refused = Trajectory::plan(from, &hurry, &bounds);
//! let Err(Error::Exceeds(peak)) = refused else { panic!("{refused:?}") };
//! assert_eq!((peak.joint, peak.quantity), (0, Quantity::Acceleration));
//! assert!(peak.value.abs() > peak.limit);
//!
//! // Without a duration the shortest is found: here the acceleration touches its bound.
//! let soon = Shape::MinimumJerk { to, duration_s: None };
//! let shortest_s = Trajectory::plan(from, &soon, &bounds).unwrap().duration_s();
//! assert!(shortest_s > 0.2 && shortest_s < 0.8, "{shortest_s} s");
//! ```

mod bounds;
mod error;
mod minimum_jerk;
mod path;
mod quintic;
pub(crate) mod ramp;
mod range;
mod reference;
mod shape;
pub mod stream;
mod wave;
mod waypoints;

pub use bounds::{Bounds, Peak, Quantity};
pub use error::{Argument, Error};
pub use range::{DURATION_MAX_S, DURATION_MIN_S, FREQUENCY_MAX_HZ, WAYPOINTS_MAX};
pub use reference::Reference;
pub use shape::{Shape, Waypoint};

use self::bounds::PeakTracker;
use self::path::Path;
use self::range::{check_start, checked_duration, checked_frequency};
use self::wave::Wave;
use crate::check_word::checked;
use crate::real::Real;
use core::f64::consts::TAU;
use nalgebra::Vector2;

/// A shape made ready to run.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "snapshot", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "snapshot", serde(bound = "T: crate::snapshot::Number"))]
pub struct Trajectory<T> {
    path: Path<T>,
    wave: Option<Wave<T>>,
    duration_s: T,
}

checked!(Trajectory<T> { path, wave, duration_s });

impl<T: Real> Trajectory<T> {
    /// Rest at these angles for ever: what there is before anything is planned.
    pub fn hold(q: Vector2<T>) -> Self {
        Self {
            path: Path::resting(q),
            wave: None,
            duration_s: T::zero(),
        }
    }

    /// Joins a shape to the reference in force at its start.
    ///
    /// # Errors
    ///
    /// See [`Error`].
    pub fn plan(
        from: Reference<T>,
        shape: &Shape<T>,
        bounds: &Bounds<T>,
    ) -> Result<Self, Error<T>> {
        check_start(&from, bounds)?;
        if !shape.is_finite() {
            return Err(Error::NotFinite(Argument::Shape));
        }
        let trajectory = Self::build(&from, shape, bounds)?;
        let mut tightest = PeakTracker::new(bounds);
        trajectory.show(&mut tightest);
        tightest.verdict().map_err(Error::Exceeds)?;
        Ok(trajectory)
    }

    /// The reference at a time since the start; rest beyond the end.
    pub fn at(&self, t_s: T) -> Reference<T> {
        if t_s < self.duration_s {
            let t_s = if t_s > T::zero() { t_s } else { T::zero() };
            let mut reference = self.path.at(t_s);
            if let Some(wave) = &self.wave {
                wave.add(t_s, &mut reference);
            }
            reference
        } else {
            Reference::at_rest(self.path.rests_at())
        }
    }

    /// When the arm is asked to be at rest, in s since the start.
    pub fn duration_s(&self) -> T {
        self.duration_s
    }

    /// Where the arm is asked to be at rest in the end, in rad.
    pub fn end(&self) -> Vector2<T> {
        self.path.rests_at()
    }

    fn build(from: &Reference<T>, shape: &Shape<T>, bounds: &Bounds<T>) -> Result<Self, Error<T>> {
        match *shape {
            Shape::Hold { q } => Ok(Self::hold(q)),
            Shape::MinimumJerk { to, duration_s } => {
                let duration_s = match duration_s {
                    Some(duration_s) => checked_duration(duration_s)?,
                    None => minimum_jerk::shortest(from, &Reference::at_rest(to), bounds)
                        .map_err(Error::NoDuration)?,
                };
                Ok(Self::along(Path::straight(from, to, duration_s)))
            }
            Shape::Waypoints { ref points } => Path::through(from, points).map(Self::along),
            Shape::Sinusoid {
                centre,
                amplitude_rad,
                frequency_hz,
                phase_rad,
                ramp_s,
                duration_s,
            } => {
                let turns = phase_rad / T::lit(TAU);
                let wave = Wave {
                    amplitude_rad,
                    start_hz: frequency_hz,
                    sweep_hz_s: Vector2::zeros(),
                    phase_turns: turns.map(|turns| turns - turns.round()),
                    ramp_s,
                    duration_s,
                };
                checked_frequency(frequency_hz)?;
                Self::waving(from, centre, wave)
            }
            Shape::Chirp {
                centre,
                amplitude_rad,
                from_hz,
                to_hz,
                ramp_s,
                duration_s,
            } => {
                let wave = Wave {
                    amplitude_rad,
                    start_hz: from_hz,
                    sweep_hz_s: (to_hz - from_hz) / duration_s,
                    phase_turns: Vector2::zeros(),
                    ramp_s,
                    duration_s,
                };
                checked_frequency(from_hz)?;
                checked_frequency(to_hz)?;
                Self::waving(from, centre, wave)
            }
        }
    }

    fn along(path: Path<T>) -> Self {
        let duration_s = path.ends_s();
        Self {
            path,
            wave: None,
            duration_s,
        }
    }

    fn waving(from: &Reference<T>, centre: Vector2<T>, wave: Wave<T>) -> Result<Self, Error<T>> {
        let duration_s = checked_duration(wave.duration_s)?;
        let (value_s, half) = (wave.ramp_s, T::lit(0.5));
        if value_s < T::lit(DURATION_MIN_S) || value_s > duration_s * half {
            return Err(Error::Ramp { value_s });
        }
        Ok(Self {
            path: Path::straight(from, centre, wave.ramp_s),
            wave: Some(wave),
            duration_s,
        })
    }

    fn show(&self, tightest: &mut PeakTracker<T>) {
        match &self.wave {
            Some(wave) => wave.show(|t_s| self.path.at(t_s), tightest),
            None => self.path.show(tightest),
        }
    }
}

#[cfg(test)]
mod tests;
