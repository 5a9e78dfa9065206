//! Prediction of the reference by the board's planner.

mod stream;

use armbridge_board::bridge::limits::MOTION;
use armbridge_board::bridge::permits;
use armbridge_client::refusal_text;
use armbridge_control::controller::float;
use armbridge_control::trajectory::{
    DURATION_MAX_S, DURATION_MIN_S, Error, FREQUENCY_MAX_HZ, Peak, Reference, Trajectory,
};
use armbridge_link::experiment::{Experiment, Measure, Objection};
use armbridge_link::limits::Limits;
use armbridge_link::message::{Command, Settings};

use super::experiment;
use super::file::Pair;
use super::mistake::{KeyPath, Mistake};
use crate::plan_runner::plan;
use crate::plan_runner::plan::{Action, Step};
use stream::StreamSchedule;
pub(super) use stream::follow_stream;

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
    /// Motors off, constant torque, or an arm that floats: there is no reference.
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
                Command::Float => {
                    check_float(settings, place)?;
                    self.clear();
                }
                Command::Experiment(ref plan) => {
                    let rest = self.rest(step.at_us);
                    check_experiment(settings, plan, rest)
                        .map_err(|objection| experiment::mistake(place, objection))?;
                    *self = Self::unknown(rest.unwrap_or(self.guess_rad));
                }
                Command::Idle
                | Command::Park
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

/// Checks whether the board's ticks are frequent enough for an arm that floats.
fn check_float(settings: &Settings, place: &KeyPath) -> Result<(), Mistake> {
    let (period_us, most_us) = (settings.setup.period_us, float::PERIOD_MAX_US);
    if period_us <= most_us {
        return Ok(());
    }
    let message = format!(
        "an arm floats at periods of at most {most_us} µs, and this board has {period_us} µs: put a \
         `setup.period_us` of at most {most_us} into `[set]`"
    );
    Err(Mistake::new(place.clone(), message))
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
    match permits(settings, plan, middle(plan)) {
        Err(Objection::Beyond {
            measure: Measure::Angle,
            ..
        }) => Ok(()),
        other => other,
    }
}

/// Middle of an experiment's envelope, in rad.
pub(super) fn middle(plan: &Experiment) -> Pair {
    plan.angle_rad.map(|[low, high]| f32::midpoint(low, high))
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
