//! Prediction of the reference by the board's planner.

use armbridge_client::refusal_text;
use armbridge_shared::bridge::limits::MOTION;
use armbridge_shared::bridge::permits;
use armbridge_shared::control::Reference;
use armbridge_shared::control::trajectory::stream::{self, Point, Stream};
use armbridge_shared::control::trajectory::{
    DURATION_MAX_S, DURATION_MIN_S, Error, FREQUENCY_MAX_HZ, Peak, Trajectory,
};
use armbridge_shared::link::experiment::{Experiment, Measure, Objection};
use armbridge_shared::link::limits::Limits;
use armbridge_shared::link::message::{Command, Settings};

use super::experiment;
use super::file::Pair;
use super::mistake::{KeyPath, Mistake};
use crate::plan_runner::plan;
use crate::plan_runner::plan::{Action, STREAM_AHEAD, Step};

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
    /// A stream; later steps begin where it comes to rest.
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
                self.stream(step.at_us, points, settings.setup.period_us, place)?;
            }
            Action::Arm | Action::Change(_) => {}
        }
        Ok(())
    }

    /// Checks all points by the board's own stream, and rests where it ends.
    fn stream(
        &mut self,
        at_us: u64,
        points: &[plan::Point],
        period_us: u32,
        place: &KeyPath,
    ) -> Result<(), Mistake> {
        if points.is_empty() {
            return Err(Mistake::new(
                place.clone(),
                "a stream has at least one point",
            ));
        }
        let schedule = StreamSchedule {
            from: self.at(at_us),
            at_us,
            points,
            period_us,
        };
        let mut stream = schedule
            .check(0)
            .map_err(|(number, error)| schedule.mistake(place, number, &error))?;
        let rest = stream.advance(u64::MAX);
        self.source = Source::Streamed(rest.q.into());
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
            && stream.points() < STREAM_AHEAD
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

/// Points of a stream with the runner's schedule: a few ahead of time.
struct StreamSchedule<'a> {
    /// Reference at the step.
    from: Reference<f32>,
    at_us: u64,
    points: &'a [plan::Point],
    period_us: u32,
}

impl StreamSchedule<'_> {
    /// The stream on the board with all points, `delay_us` later than they are written.
    ///
    /// # Errors
    /// The index of the first point that the board would refuse, and the reason.
    fn check(&self, delay_us: u64) -> Result<Stream<f32>, (usize, StreamError)> {
        /// Time of a command to the board and into its next tick, beside the tick's period.
        const LINK_US: u64 = 2_000;
        let latency_us = LINK_US + u64::from(self.period_us);
        let mut stream =
            Stream::new(&self.from, self.at_us, &MOTION).map_err(|error| (0, error.into()))?;
        for (number, point) in self.points.iter().enumerate() {
            let room = number
                .checked_sub(STREAM_AHEAD)
                .and_then(|k| self.points.get(k));
            let room_us = room.map_or(0, |room| room.after_us + delay_us);
            let pushed = stream.push(
                self.at_us + room_us + latency_us,
                Point {
                    at_us: self.at_us + point.after_us + delay_us,
                    q: point.angle_rad.into(),
                    dq: point.speed_rad_s.map(Into::into),
                },
            );
            pushed.map_err(|error| (number, error.into()))?;
        }
        Ok(stream)
    }

    /// The shortest time in s after the step at which the arm can reach the first point.
    fn soonest_s(&self) -> Option<f64> {
        /// Longest delay that is tried, in ms.
        const LONGEST_MS: u64 = 10_000;
        let is_reached = |delay_ms: u64| {
            let first = Self {
                points: self.points.get(..1).unwrap_or_default(),
                ..*self
            };
            first.check(delay_ms * 1_000).is_ok()
        };
        let delay_ms = (1..=LONGEST_MS).find(|delay_ms| is_reached(*delay_ms))?;
        let first = self.points.first()?;
        Some((first.after_us + delay_ms * 1_000) as f64 * 1e-6)
    }

    /// The mistake of a point that the board would refuse.
    fn mistake(&self, place: &KeyPath, number: usize, error: &StreamError) -> Mistake {
        let point = place.nth(number);
        let soonest = || {
            let soonest_s = self.soonest_s().filter(|_| number == 0);
            soonest_s.map_or_else(String::new, |soonest_s| {
                format!(
                    "; the arm can be there {soonest_s:.3} s after the step: give this point an \
                     `after_s` of {soonest_s:.3} or more, and move the others with it"
                )
            })
        };
        match error {
            StreamError::Start(error) => mistake(place, error),
            StreamError::Point(stream::Error::NotFinite) => {
                Mistake::new(point, "a number in it is not finite")
            }
            StreamError::Point(stream::Error::Full) => {
                Mistake::new(point, "too many points at once")
            }
            StreamError::Point(stream::Error::Late { by_us }) => {
                let by_ms = *by_us as f64 * 1e-3;
                let message = if number == 0 {
                    format!(
                        "the point is {by_ms:.1} ms too soon after the step: the board has it one \
                         period and 2 ms later, and a point is 1 ms ahead{}",
                        soonest()
                    )
                } else {
                    format!(
                        "the point is {by_ms:.1} ms too soon after the one before it: the least \
                         distance is 1 ms"
                    )
                };
                Mistake::new(point.at("after_s"), message)
            }
            StreamError::Point(stream::Error::Exceeds(peak)) => {
                let message = format!(
                    "on the way to this point, or to rest after it, {}{}",
                    peak_text(peak),
                    soonest()
                );
                Mistake::new(point, message)
            }
        }
    }
}

/// Reason for which the board would refuse a stream.
enum StreamError {
    Start(Error<f32>),
    Point(stream::Error<f32>),
}

impl From<Error<f32>> for StreamError {
    fn from(error: Error<f32>) -> Self {
        Self::Start(error)
    }
}

impl From<stream::Error<f32>> for StreamError {
    fn from(error: stream::Error<f32>) -> Self {
        Self::Point(error)
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
        Error::Exceeds(peak) => (
            place.clone(),
            format!("{} after {:.3} s", peak_text(peak), peak.at_s),
        ),
        Error::NoDuration(peak) => (
            place.clone(),
            format!("no duration is long enough: {}", peak_text(peak)),
        ),
    };
    Mistake { place, message }
}

fn peak_text(peak: &Peak<f32>) -> String {
    refusal_text::beyond(peak.joint, peak.quantity, peak.value, peak.limit)
}
