//! Where the reference will be, by the planner of the board.

use armbridge_shared::bridge::limits::MOTION;
use armbridge_shared::bridge::permits;
use armbridge_shared::control::Reference;
use armbridge_shared::control::trajectory::stream::{self, Point, Stream};
use armbridge_shared::control::trajectory::{
    DURATION_MAX_S, DURATION_MIN_S, Error, FREQUENCY_MAX_HZ, Peak, Quantity, Trajectory,
};
use armbridge_shared::link::experiment::{Experiment, Measure, Objection};
use armbridge_shared::link::limits::Limits;
use armbridge_shared::link::message::{Command, Settings};

use super::experiment;
use super::file::Pair;
use super::location::{Place, Wrong};
use crate::plan_runner::plan;
use crate::plan_runner::plan::{Act, Step};

/// From a motion's command to its beginning, in µs: as long as the board takes to plan.
const LEAD_US: u64 = 50_000;

/// What the arm is asked to follow.
#[derive(Debug)]
pub(super) struct Course {
    guess_rad: Pair,
    way: Way,
}

#[derive(Debug)]
enum Way {
    /// Motors off, or constant torque: the arm is where it is.
    Unknown,
    Planned {
        trajectory: Box<Trajectory<f32>>,
        since_us: u64,
    },
    /// At rest at the end, as far as a step after it is concerned.
    Streamed(Pair),
}

impl Course {
    /// Nothing is followed yet; the arm is about here.
    pub(super) fn unknown(guess_rad: Pair) -> Self {
        Self {
            guess_rad,
            way: Way::Unknown,
        }
    }

    /// Nothing is followed any more.
    pub(super) fn lose(&mut self) {
        self.way = Way::Unknown;
    }

    /// Nothing is followed any more; the arm is about here.
    fn guess(&mut self, guess_rad: Pair) {
        *self = Self::unknown(guess_rad);
    }

    /// What is asked of the arm at this time.
    pub(super) fn at(&self, at_us: u64) -> Reference<f32> {
        match &self.way {
            // The best guess there is.
            Way::Unknown => Reference::at_rest(self.guess_rad.into()),
            Way::Planned {
                trajectory,
                since_us,
            } => trajectory.at(at_us.saturating_sub(*since_us) as f32 * 1e-6),
            Way::Streamed(end) => Reference::at_rest((*end).into()),
        }
    }

    /// Whether what is followed has come to its end by this time.
    pub(super) fn is_over(&self, at_us: u64) -> bool {
        match &self.way {
            Way::Unknown => false,
            Way::Planned {
                trajectory,
                since_us,
            } => at_us as f64 >= *since_us as f64 + 1e6 * f64::from(trajectory.duration_s()),
            Way::Streamed(_) => true,
        }
    }

    /// Where the arm rests at this time, if that is known.
    pub(super) fn rest(&self, at_us: u64) -> Option<Pair> {
        let reference = match &self.way {
            Way::Unknown => return None,
            Way::Planned { .. } | Way::Streamed(_) => self.at(at_us),
        };
        (reference.dq == nalgebra::Vector2::zeros()).then(|| reference.q.into())
    }

    /// Follows a step, if the board would.
    pub(super) fn take(
        &mut self,
        step: &Step,
        settings: &Settings,
        place: &Place,
    ) -> Result<(), Wrong> {
        let since_us = step.at_us + LEAD_US;
        match &step.act {
            Act::Tell(command) => match **command {
                Command::Regulate(q) => {
                    self.way = Way::Planned {
                        trajectory: Box::new(Trajectory::hold(q.into())),
                        since_us: step.at_us,
                    };
                }
                Command::Follow(motion) => {
                    let shape = motion.shape();
                    let trajectory = Trajectory::plan(self.at(since_us), &shape, &MOTION)
                        .map_err(|error| wrong(place, &error))?;
                    self.way = Way::Planned {
                        trajectory: Box::new(trajectory),
                        since_us,
                    };
                }
                Command::Torque(_) => self.lose(),
                Command::Experiment(ref plan) => {
                    let rest = self.rest(step.at_us);
                    permitted(settings, plan, rest)
                        .map_err(|objection| experiment::wrong(place, objection))?;
                    self.guess(rest.unwrap_or(self.guess_rad));
                }
                Command::Idle
                | Command::Arm { .. }
                | Command::Stream { .. }
                | Command::Prepare
                | Command::Release
                | Command::ClearFault
                | Command::Configure(_)
                | Command::Limit(_)
                | Command::Save => {}
            },
            Act::Stream(points) => {
                self.stream(step.at_us, points, place)?;
            }
            Act::Arm | Act::Change(_) => {}
        }
        Ok(())
    }

    /// Sends all points as the player will: a few ahead of time.
    fn stream(&mut self, at_us: u64, points: &[plan::Point], place: &Place) -> Result<(), Wrong> {
        /// As many as the player keeps on the board.
        const AHEAD: usize = 5;
        let Some(end) = points.last() else {
            return Err(Wrong::new(place.clone(), "a stream has at least one point"));
        };
        let mut stream =
            Stream::new(&self.at(at_us), at_us, &MOTION).map_err(|error| wrong(place, &error))?;
        for (number, point) in points.iter().enumerate() {
            let room = number.checked_sub(AHEAD).and_then(|k| points.get(k));
            let now_us = at_us + room.map_or(0, |room| room.after_us);
            let point = Point {
                at_us: at_us + point.after_us,
                q: point.angle_rad.into(),
                dq: point.speed_rad_s.map(Into::into),
            };
            let pushed = stream.push(now_us, point);
            pushed.map_err(|error| wrong_point(&place.nth(number), &error))?;
            stream.advance(now_us);
            if stream.skipped() > 0 {
                let message = "the first point comes too soon after the step: the arm cannot be \
                            there by then; give it a larger `after_s`";
                return Err(Wrong::new(place.nth(0).at("after_s"), message));
            }
        }
        self.way = Way::Streamed(end.angle_rad);
        Ok(())
    }

    /// Whether it ends where the board's limits let it be.
    pub(super) fn check_limits(&self, limits: &Limits, place: &Place) -> Result<(), Wrong> {
        let end = match &self.way {
            Way::Unknown => return Ok(()),
            Way::Planned { trajectory, .. } => trajectory.end().into(),
            Way::Streamed(end) => *end,
        };
        let beyond = (end.iter().zip(limits.angle_rad)).position(|(q, limit)| q.abs() >= limit);
        beyond.map_or(Ok(()), |joint| {
            let message = format!(
                "joint {} would be at {} rad, beyond its `limits.angle_rad` of {} rad",
                joint + 1,
                end[joint],
                limits.angle_rad[joint]
            );
            Err(Wrong::new(place.clone(), message))
        })
    }
}

/// Whether the board would begin this experiment. Where the arm's rest is not known
/// then, it is asked for the middle of the envelope, and where joints may swing to is left
/// to the board.
fn permitted(settings: &Settings, plan: &Experiment, rest: Option<Pair>) -> Result<(), Objection> {
    if let Some(rest) = rest {
        return permits(settings, plan, rest);
    }
    let middle = plan.angle_rad.map(|[low, high]| f32::midpoint(low, high));
    match permits(settings, plan, middle) {
        Err(Objection::Beyond {
            measure: Measure::Angle,
            ..
        }) => Ok(()),
        other => other,
    }
}

fn unit(quantity: Quantity) -> &'static str {
    match quantity {
        Quantity::Angle => "rad",
        Quantity::Speed => "rad/s",
        Quantity::Acceleration => "rad/s²",
    }
}

fn wrong(place: &Place, error: &Error<f32>) -> Wrong {
    let (place, message) = match error {
        Error::NotFinite(_) | Error::NoRoom(_) => {
            (place.clone(), "a number in it is not finite".into())
        }
        Error::Duration { value_s } => (
            place.at("duration_s"),
            format!("a motion takes from {DURATION_MIN_S} to {DURATION_MAX_S} s, not {value_s}"),
        ),
        Error::Ramp { value_s } => (
            place.at("ramp_s"),
            format!(
                "a ramp takes from {DURATION_MIN_S} s to half of `duration_s`, not {value_s} s"
            ),
        ),
        Error::Frequency { joint, value_hz } => (
            place.clone(),
            format!(
                "{value_hz} Hz for joint {}: expected a frequency from 0 to {FREQUENCY_MAX_HZ} Hz",
                joint + 1
            ),
        ),
        Error::NoWaypoints => (place.clone(), "expected at least one waypoint".into()),
        Error::WaypointTime { waypoint } => (
            place.nth(*waypoint).at("after_s"),
            format!(
                "a waypoint is at least {DURATION_MIN_S} s after the one before it, or the start"
            ),
        ),
        Error::Uneven => (
            place.clone(),
            "no smooth way leads through these: their times are too uneven".into(),
        ),
        Error::Exceeds(peak) => (place.clone(), beyond(peak)),
        Error::NoDuration(peak) => (
            place.clone(),
            format!("no duration is long enough: {}", beyond(peak)),
        ),
    };
    Wrong { place, message }
}

fn beyond(peak: &Peak<f32>) -> String {
    format!(
        "joint {} would come to {:.3} {unit} after {:.3} s, more than the board allows: {} {unit}",
        peak.joint + 1,
        peak.value,
        peak.at_s,
        peak.limit,
        unit = unit(peak.quantity),
    )
}

fn wrong_point(place: &Place, error: &stream::Error<f32>) -> Wrong {
    let (place, message) = match error {
        stream::Error::NotFinite => (place.clone(), "a number in it is not finite".into()),
        stream::Error::Late => (
            place.at("after_s"),
            "a point is at least 0.001 s after the step".into(),
        ),
        stream::Error::Order => (
            place.at("after_s"),
            "a point is at least 0.001 s after the one before it".into(),
        ),
        stream::Error::Full => (place.clone(), "too many points at once".into()),
        stream::Error::Exceeds {
            joint,
            quantity,
            value,
        } => (
            place.clone(),
            format!(
                "joint {} would come to {value:.3} {unit}, more than the board allows: {} {unit}",
                joint + 1,
                MOTION.of(*quantity),
                unit = unit(*quantity)
            ),
        ),
    };
    Wrong { place, message }
}
