//! Prediction of the reference by the board's planner.

use armbridge_client::number_text::beside_limit;
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
use super::mistake::{KeyPath, Mistake};
use crate::plan_runner::plan;
use crate::plan_runner::plan::{Action, Step};

/// Time from a motion's command to its beginning, in µs: the board's planning time.
const LEAD_US: u64 = 50_000;

/// Source of the reference at a step.
#[derive(Debug)]
pub(super) struct ReferenceSource {
    guess_rad: Pair,
    source: Source,
}

#[derive(Debug)]
enum Source {
    /// Motors off, or constant torque: there is no reference.
    Unknown,
    Planned {
        trajectory: Box<Trajectory<f32>>,
        since_us: u64,
    },
    /// A stream; later steps begin at rest at its last point.
    Streamed(Pair),
}

impl ReferenceSource {
    /// No reference yet; the arm is approximately at `guess_rad`.
    pub(super) fn unknown(guess_rad: Pair) -> Self {
        Self {
            guess_rad,
            source: Source::Unknown,
        }
    }

    /// Ends the reference.
    pub(super) fn clear(&mut self) {
        self.source = Source::Unknown;
    }

    /// Reference at a time.
    pub(super) fn at(&self, at_us: u64) -> Reference<f32> {
        match &self.source {
            // The best available estimate.
            Source::Unknown => Reference::at_rest(self.guess_rad.into()),
            Source::Planned {
                trajectory,
                since_us,
            } => trajectory.at(at_us.saturating_sub(*since_us) as f32 * 1e-6),
            Source::Streamed(end) => Reference::at_rest((*end).into()),
        }
    }

    /// Whether the reference has reached its end at a time.
    pub(super) fn is_over(&self, at_us: u64) -> bool {
        match &self.source {
            Source::Unknown => false,
            Source::Planned {
                trajectory,
                since_us,
            } => at_us as f64 >= *since_us as f64 + 1e6 * f64::from(trajectory.duration_s()),
            Source::Streamed(_) => true,
        }
    }

    /// Setpoint at which the arm rests at a time, if known.
    pub(super) fn rest(&self, at_us: u64) -> Option<Pair> {
        let reference = match &self.source {
            Source::Unknown => return None,
            Source::Planned { .. } | Source::Streamed(_) => self.at(at_us),
        };
        (reference.dq == nalgebra::Vector2::zeros()).then(|| reference.q.into())
    }

    /// Applies a step, if the board would accept it.
    pub(super) fn apply(
        &mut self,
        step: &Step,
        settings: &Settings,
        place: &KeyPath,
    ) -> Result<(), Mistake> {
        let since_us = step.at_us + LEAD_US;
        match &step.action {
            Action::Command(command) => match **command {
                Command::Regulate(q) => {
                    self.source = Source::Planned {
                        trajectory: Box::new(Trajectory::hold(q.into())),
                        since_us: step.at_us,
                    };
                }
                Command::Follow(motion) => {
                    let shape = motion.shape();
                    let trajectory = Trajectory::plan(self.at(since_us), &shape, &MOTION)
                        .map_err(|error| mistake(place, &error))?;
                    self.source = Source::Planned {
                        trajectory: Box::new(trajectory),
                        since_us,
                    };
                }
                Command::Torque(_) => self.clear(),
                Command::Experiment(ref plan) => {
                    let rest = self.rest(step.at_us);
                    check_experiment(settings, plan, rest)
                        .map_err(|objection| experiment::mistake(place, objection))?;
                    *self = Self::unknown(rest.unwrap_or(self.guess_rad));
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
            Action::Stream(points) => {
                self.stream(step.at_us, points, place)?;
            }
            Action::Arm | Action::Change(_) => {}
        }
        Ok(())
    }

    /// Checks all points with the runner's schedule: a few ahead of time.
    fn stream(
        &mut self,
        at_us: u64,
        points: &[plan::Point],
        place: &KeyPath,
    ) -> Result<(), Mistake> {
        let Some(end) = points.last() else {
            return Err(Mistake::new(
                place.clone(),
                "a stream has at least one point",
            ));
        };
        let mut stream =
            Stream::new(&self.at(at_us), at_us, &MOTION).map_err(|error| mistake(place, &error))?;
        for (number, point) in points.iter().enumerate() {
            let room = number.checked_sub(AHEAD).and_then(|k| points.get(k));
            let now_us = at_us + room.map_or(0, |room| room.after_us);
            let point = Point {
                at_us: at_us + point.after_us,
                q: point.angle_rad.into(),
                dq: point.speed_rad_s.map(Into::into),
            };
            let pushed = stream.push(now_us, point);
            pushed.map_err(|error| point_mistake(&place.nth(number), &error))?;
            stream.advance(now_us);
            if stream.skipped() > 0 {
                let message = "the first point is too soon after the step for the arm to reach \
                               it; give it a larger `after_s`";
                return Err(Mistake::new(place.nth(0).at("after_s"), message));
            }
        }
        self.source = Source::Streamed(end.angle_rad);
        Ok(())
    }

    /// Checks that the reference ends within the board's limits.
    pub(super) fn check_limits(&self, limits: &Limits, place: &KeyPath) -> Result<(), Mistake> {
        let end = match &self.source {
            Source::Unknown => return Ok(()),
            Source::Planned { trajectory, .. } => trajectory.end().into(),
            Source::Streamed(end) => *end,
        };
        let beyond = (end.iter().zip(limits.angle_rad)).position(|(q, limit)| q.abs() >= limit);
        beyond.map_or(Ok(()), |joint| {
            let message = format!(
                "joint {} would be at {} rad, beyond its `limits.angle_rad` of {} rad",
                joint + 1,
                end[joint],
                limits.angle_rad[joint]
            );
            Err(Mistake::new(place.clone(), message))
        })
    }
}

/// Computes the reference that the board makes of a stream's points, from rest at `start`,
/// every `step_us` until its end. Points are accepted: they have been checked.
pub(super) fn follow_stream(
    start: &Reference<f32>,
    points: &[plan::Point],
    step_us: u64,
    see: &mut impl FnMut(u64, &Reference<f32>),
) {
    let (Ok(mut stream), Some(end)) = (Stream::new(start, 0, &MOTION), points.last()) else {
        return;
    };
    let mut points = points.iter().peekable();
    for now_us in (0..=end.after_us).step_by(step_us as usize) {
        while let Some(point) = points.peek()
            && stream.points() < AHEAD
        {
            let point = Point {
                at_us: point.after_us,
                q: point.angle_rad.into(),
                dq: point.speed_rad_s.map(Into::into),
            };
            if stream.push(now_us, point).is_err() {
                return;
            }
            points.next();
        }
        see(now_us, &stream.advance(now_us));
    }
}

/// Number of points that the runner keeps on the board.
const AHEAD: usize = 5;

/// Checks whether the board would accept an experiment. If the arm's angles are unknown, the
/// check uses the middle of the envelope, and leaves the range of the reference to the
/// board.
fn check_experiment(
    settings: &Settings,
    plan: &Experiment,
    rest: Option<Pair>,
) -> Result<(), Objection> {
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

fn mistake(place: &KeyPath, error: &Error<f32>) -> Mistake {
    let (place, message) = match error {
        Error::NotFinite(_) | Error::NoRoom(_) => {
            (place.clone(), "a number in it is not finite".into())
        }
        Error::Duration { value_s } => (
            place.at("duration_s"),
            format!("a motion takes from {DURATION_MIN_S} to {DURATION_MAX_S} s, not {value_s} s"),
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
            "no smooth path leads through these waypoints: their times are too uneven".into(),
        ),
        Error::Exceeds(peak) => (place.clone(), peak_text(peak)),
        Error::NoDuration(peak) => (
            place.clone(),
            format!("no duration is long enough: {}", peak_text(peak)),
        ),
    };
    Mistake { place, message }
}

fn peak_text(peak: &Peak<f32>) -> String {
    let [value, limit] = beside_limit(peak.value, peak.limit, 3);
    format!(
        "joint {} would reach {value} {unit} after {:.3} s, more than the board allows: {limit} \
         {unit}",
        peak.joint + 1,
        peak.at_s,
        unit = unit(peak.quantity),
    )
}

fn point_mistake(place: &KeyPath, error: &stream::Error<f32>) -> Mistake {
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
        } => {
            let [value, limit] = beside_limit(*value, MOTION.of(*quantity), 3);
            let (joint, unit) = (joint + 1, unit(*quantity));
            let message = format!(
                "joint {joint} would reach {value} {unit}, more than the board allows: {limit} \
                 {unit}"
            );
            (place.clone(), message)
        }
    };
    Mistake { place, message }
}
