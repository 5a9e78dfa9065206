//! Steps as they are written, put on one timeline.

use armbridge_client::params;
use armbridge_shared::JOINTS;
use armbridge_shared::bridge::limits::REFERENCE_MAX_RAD;
use armbridge_shared::control::trajectory::WAYPOINTS_MAX;
use armbridge_shared::link::limits::hard;
use armbridge_shared::link::message::{Command, Settings};
use armbridge_shared::link::motion::{Motion, Via};
use toml::Table;

use super::experiment;
use super::file::{Pair, StepKeys, ViaKeys};
use super::location::{Place, Wrong};
use super::reference::Course;
use crate::plan_runner::plan::{Act, Base, Change, Point, Step};

/// Steps of a run, repetitions counted: more is a scenario that was not meant.
const STEPS_MAX: usize = 20_000;

/// A step on the timeline, and where it is written.
struct Planned {
    step: Step,
    /// Of the file's steps, from 1.
    number: usize,
    place: Place,
    /// Of what is done.
    act: Place,
}

/// Seconds from 0 up, as µs.
pub(super) fn microseconds(place: &Place, seconds: f64) -> Result<u64, Wrong> {
    /// A day: a mistake, and far from what µs can count.
    const MOST_S: f64 = 86_400.0;
    if (0.0..=MOST_S).contains(&seconds) {
        return Ok((seconds * 1e6).round() as u64);
    }
    let message = format!("expected a time from 0 to {MOST_S} s, not {seconds}");
    Err(Wrong::new(place.clone(), message))
}

/// All times from `at_us` on, `every_s` apart if given, until the run ends.
pub(super) fn times(
    place: &Place,
    at_us: u64,
    every_s: Option<f64>,
    end_us: u64,
) -> Result<Vec<u64>, Wrong> {
    let at = place.at("at_s");
    if at_us >= end_us {
        let message = format!(
            "this is after the end: the run is over after {} s (`after_s` in `[stop]`)",
            end_us as f64 * 1e-6
        );
        return Err(Wrong::new(at, message));
    }
    let Some(every_s) = every_s else {
        return Ok(vec![at_us]);
    };
    let every = place.at("every_s");
    let every_us = microseconds(&every, every_s)?;
    if every_us < 1_000 {
        return Err(Wrong::new(every, "expected 0.001 s or more"));
    }
    if (end_us - at_us) / every_us > STEPS_MAX as u64 {
        let message = format!("so often is more than {STEPS_MAX} times");
        return Err(Wrong::new(every, message));
    }
    Ok((at_us..end_us).step_by(every_us as usize).collect())
}

/// The steps in order of time, each of which a board that begins with `settings` and
/// an arm that is at `initial_rad` will do.
pub(super) fn steps(
    keys: &[StepKeys],
    end_us: u64,
    settings: &Settings,
    initial_rad: Pair,
) -> Result<Vec<Step>, Wrong> {
    let mut planned: Vec<Planned> = Vec::new();
    let mut before_us = 0;
    for (number, key) in keys.iter().enumerate() {
        let place = Place::top("step").nth(number);
        let at_us = microseconds(&place.at("at_s"), key.at_s)?;
        if at_us < before_us {
            let message = "steps are in order of time, and this is before the one above it";
            return Err(Wrong::new(place.at("at_s"), message));
        }
        before_us = at_us;
        let (act, at) = key.act(&place)?;
        for at_us in times(&place, at_us, key.every_s, end_us)? {
            let step = Step {
                at_us,
                act: act.clone(),
            };
            planned.push(Planned {
                step,
                number: number + 1,
                place: place.clone(),
                act: at.clone(),
            });
        }
        if planned.len() > STEPS_MAX {
            let message = format!("with all repetitions, these are more than {STEPS_MAX} steps");
            return Err(Wrong::new(place, message));
        }
    }
    planned.sort_by_key(|planned| planned.step.at_us);
    rehearse(&planned, settings, initial_rad)?;
    Ok(planned.into_iter().map(|planned| planned.step).collect())
}

/// Goes through all steps as the board will.
fn rehearse(planned: &[Planned], settings: &Settings, initial_rad: Pair) -> Result<(), Wrong> {
    let mut rehearsal = Rehearsal {
        settings: *settings,
        course: Course::unknown(initial_rad),
        idle_since_s: None,
    };
    planned.iter().try_for_each(|planned| {
        rehearsal.take(planned).map_err(|Wrong { place, message }| {
            let at_s = planned.step.at_us as f64 * 1e-6;
            let message = format!("step {} at {at_s} s: {message}", planned.number);
            Wrong { place, message }
        })
    })
}

/// What a board would have come to.
struct Rehearsal {
    settings: Settings,
    course: Course,
    idle_since_s: Option<f64>,
}

impl Rehearsal {
    fn take(&mut self, planned: &Planned) -> Result<(), Wrong> {
        let Planned {
            step, place, act, ..
        } = planned;
        match &step.act {
            Act::Tell(command) if **command == Command::Idle => {
                self.idle_since_s = Some(step.at_us as f64 * 1e-6);
                self.course.lose();
            }
            Act::Arm => self.idle_since_s = None,
            Act::Change(change) => {
                self.settings = change
                    .apply(&self.settings)
                    .map_err(|error| Wrong::new(act.key(error.key()), &error))?;
                params::check(&self.settings).map_err(|unfit| Wrong::new(act.clone(), unfit))?;
            }
            Act::Tell(_) | Act::Stream(_) => {
                if let Some(since_s) = self.idle_since_s {
                    let message = format!(
                        "the arm is idle since the step at {since_s} s; put a step with \
                         `arm = true` before this one"
                    );
                    return Err(Wrong::new(place.clone(), message));
                }
                self.course.take(step, &self.settings, act)?;
                self.course.check_limits(&self.settings.limits, act)?;
            }
        }
        Ok(())
    }
}

impl StepKeys {
    /// The one thing that the step does, and where it is written.
    fn act(&self, place: &Place) -> Result<(Act, Place), Wrong> {
        let acts = [
            ("regulate_rad", self.regulate_rad.is_some()),
            ("torque_nm", self.torque_nm.is_some()),
            ("minimum_jerk", self.minimum_jerk.is_some()),
            ("waypoints", self.waypoints.is_some()),
            ("sinusoid", self.sinusoid.is_some()),
            ("chirp", self.chirp.is_some()),
            ("stream", self.stream.is_some()),
            ("experiment", self.experiment.is_some()),
            ("set", self.set.is_some()),
            ("idle", self.idle.is_some()),
            ("arm", self.arm.is_some()),
        ];
        let mut given = acts.iter().filter(|(_, is_given)| *is_given);
        let ((name, _), None) = (
            given.next().ok_or_else(|| {
                let names = acts.map(|(name, _)| name).join(", ");
                Wrong::new(
                    place.clone(),
                    format!("this step does nothing; give it one of {names}"),
                )
            })?,
            given.next(),
        ) else {
            let message = "a step does one thing; put the second into a step of its own, with the \
                        same `at_s`";
            return Err(Wrong::new(place.clone(), message));
        };
        let at = place.at(name);
        let act = self.command(&at)?;
        Ok((act, at))
    }

    fn command(&self, at: &Place) -> Result<Act, Wrong> {
        let follow = |motion| Act::Tell(Box::new(Command::Follow(motion)));
        if let Some(angles) = self.regulate_rad {
            within(at, angles, REFERENCE_MAX_RAD, "rad")?;
            return Ok(Act::Tell(Box::new(Command::Regulate(angles))));
        }
        if let Some(torques) = self.torque_nm {
            within(at, torques, hard::TORQUE_NM, "N m")?;
            return Ok(Act::Tell(Box::new(Command::Torque(torques))));
        }
        if let Some(keys) = &self.minimum_jerk {
            return Ok(follow(Motion::MinimumJerk {
                to_rad: keys.to_rad,
                duration_s: keys.duration_s,
            }));
        }
        if let Some(keys) = &self.waypoints {
            return waypoints(at, keys).map(follow);
        }
        if let Some(keys) = &self.sinusoid {
            return Ok(follow(Motion::Sinusoid {
                centre_rad: keys.centre_rad,
                amplitude_rad: keys.amplitude_rad,
                frequency_hz: keys.frequency_hz,
                phase_rad: keys.phase_rad,
                ramp_s: keys.ramp_s,
                duration_s: keys.duration_s,
            }));
        }
        if let Some(keys) = &self.chirp {
            return Ok(follow(Motion::Chirp {
                centre_rad: keys.centre_rad,
                amplitude_rad: keys.amplitude_rad,
                from_hz: keys.from_hz,
                to_hz: keys.to_hz,
                ramp_s: keys.ramp_s,
                duration_s: keys.duration_s,
            }));
        }
        if let Some(keys) = &self.stream {
            return points(at, keys).map(Act::Stream);
        }
        if let Some(plan) = self.experiment {
            plan.check()
                .map_err(|objection| experiment::wrong(at, objection))?;
            return Ok(Act::Tell(Box::new(Command::Experiment(plan))));
        }
        if let Some(table) = &self.set {
            return change_under_torque(at, table).map(Act::Change);
        }
        match (self.idle, self.arm) {
            (Some(true), _) => Ok(Act::Tell(Box::new(Command::Idle))),
            (_, Some(true)) => Ok(Act::Arm),
            _ => Err(Wrong::new(
                at.clone(),
                "expected true, or no such key at all",
            )),
        }
    }
}

fn within(at: &Place, values: [f32; JOINTS], most: f32, unit: &str) -> Result<(), Wrong> {
    let beyond = values
        .iter()
        .position(|value| value.is_nan() || value.abs() > most);
    beyond.map_or(Ok(()), |joint| {
        let message = format!(
            "{} {unit} for joint {} is more than the board takes: from -{most} to {most}",
            values[joint],
            joint + 1
        );
        Err(Wrong::new(at.nth(joint), message))
    })
}

fn waypoints(at: &Place, keys: &[ViaKeys]) -> Result<Motion, Wrong> {
    let mut vias = [None; WAYPOINTS_MAX];
    if keys.len() > WAYPOINTS_MAX {
        let message = format!("at most {WAYPOINTS_MAX} waypoints; go on in another step");
        return Err(Wrong::new(at.nth(WAYPOINTS_MAX), message));
    }
    for (number, (via, key)) in vias.iter_mut().zip(keys).enumerate() {
        if key.speed_rad_s.is_some() {
            let message = "waypoints are passed as smoothly as can be; speeds are for `stream`";
            return Err(Wrong::new(at.nth(number).at("speed_rad_s"), message));
        }
        *via = Some(Via {
            at_s: key.after_s as f32,
            angle_rad: key.angle_rad,
        });
    }
    Ok(Motion::Waypoints(vias))
}

fn points(at: &Place, keys: &[ViaKeys]) -> Result<Vec<Point>, Wrong> {
    let points = keys.iter().enumerate().map(|(number, key)| {
        Ok(Point {
            after_us: microseconds(&at.nth(number).at("after_s"), key.after_s)?,
            angle_rad: key.angle_rad,
            speed_rad_s: key.speed_rad_s,
        })
    });
    points.collect()
}

fn change_under_torque(at: &Place, table: &Table) -> Result<Change, Wrong> {
    let set = pairs(table);
    let is_fixed = |key: &str| key.starts_with("limits.") || key == "setup.period_us";
    if let Some((key, _)) = set.iter().find(|(key, _)| is_fixed(key)) {
        let message = "this can only be set while the arm is idle: put it into `[set]`";
        return Err(Wrong::new(at.key(key), message));
    }
    Ok(Change {
        base: Base::Board,
        set,
    })
}

/// A table of parameters, `controller.q = ..` and the like, as pairs.
pub(super) fn pairs(table: &Table) -> Vec<(String, toml::Value)> {
    let mut pairs = Vec::new();
    for (name, value) in table {
        if let toml::Value::Table(group) = value {
            let inner = self::pairs(group).into_iter();
            pairs.extend(inner.map(|(key, value)| (format!("{name}.{key}"), value)));
        } else {
            pairs.push((name.clone(), value.clone()));
        }
    }
    pairs
}
