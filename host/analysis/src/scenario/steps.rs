//! Conversion of written steps to a timeline.

use armbridge_client::params;
use armbridge_control::trajectory::WAYPOINTS_MAX;
use armbridge_link::message::{Command, Settings};
use armbridge_link::motion::{Motion, Via};
use armbridge_servo::JOINTS;
use toml::Table;

use super::experiment;
use super::file::{Pair, StepKeys, ViaKeys};
use super::mistake::{KeyPath, Mistake};
use super::reference::ReferenceSource;
use crate::plan_runner::plan::{Action, Base, Change, Point, Step};

/// Largest number of steps of a run, with repetitions: more is a mistake.
const STEPS_MAX: usize = 20_000;

/// A step on the timeline with its place in the file.
struct Planned {
    step: Step,
    /// Number of the step in the file, from 1.
    number: usize,
    place: KeyPath,
    /// Place of the step's action.
    action_place: KeyPath,
}

/// Converts seconds, not negative, to µs.
pub(super) fn microseconds(place: &KeyPath, seconds: f64) -> Result<u64, Mistake> {
    /// Largest time in s, a day: more is a mistake.
    const MAX_S: f64 = 86_400.0;
    if (0.0..=MAX_S).contains(&seconds) {
        return Ok((seconds * 1e6).round() as u64);
    }
    let message = format!("expected a time from 0 to {MAX_S} s, not {seconds}");
    Err(Mistake::new(place.clone(), message))
}

/// All times from `at_us` on, `every_s` apart if given, until the run ends.
pub(super) fn times(
    place: &KeyPath,
    at_us: u64,
    every_s: Option<f64>,
    end_us: u64,
) -> Result<Vec<u64>, Mistake> {
    let at = place.at("at_s");
    if at_us >= end_us {
        let message = format!(
            "this is after the end: the run ends after {} s (`after_s` in `[stop]`)",
            end_us as f64 * 1e-6
        );
        return Err(Mistake::new(at, message));
    }
    let Some(every_s) = every_s else {
        return Ok(vec![at_us]);
    };
    let every = place.at("every_s");
    let every_us = microseconds(&every, every_s)?;
    if every_us < 1_000 {
        return Err(Mistake::new(every, "expected 0.001 s or more"));
    }
    if (end_us - at_us) / every_us > STEPS_MAX as u64 {
        let message = format!("this repeats more than {STEPS_MAX} times");
        return Err(Mistake::new(every, message));
    }
    Ok((at_us..end_us).step_by(every_us as usize).collect())
}

/// Steps in order of time, checked for a board that begins with `settings` and an arm at
/// `initial_rad`.
pub(super) fn steps(
    keys: &[StepKeys],
    end_us: u64,
    settings: &Settings,
    initial_rad: Pair,
) -> Result<Vec<Step>, Mistake> {
    let mut planned: Vec<Planned> = Vec::new();
    let mut before_us = 0;
    let kept = keys.iter().enumerate().filter(|(_, key)| !key.is_left_out);
    for (number, key) in kept {
        let place = KeyPath::top("step").nth(number);
        let at_us = microseconds(&place.at("at_s"), key.at_s)?;
        if at_us < before_us {
            let message = "steps are in order of time, and this is before the one above it";
            return Err(Mistake::new(place.at("at_s"), message));
        }
        before_us = at_us;
        let (action, action_place) = key.action(&place)?;
        for at_us in times(&place, at_us, key.every_s, end_us)? {
            let step = Step {
                at_us,
                action: action.clone(),
            };
            planned.push(Planned {
                step,
                number: number + 1,
                place: place.clone(),
                action_place: action_place.clone(),
            });
        }
        if planned.len() > STEPS_MAX {
            let message = format!("with all repetitions, these are more than {STEPS_MAX} steps");
            return Err(Mistake::new(place, message));
        }
    }
    planned.sort_by_key(|planned| planned.step.at_us);
    dry_run(&planned, settings, initial_rad)?;
    Ok(planned.into_iter().map(|planned| planned.step).collect())
}

/// Checks all steps in the order in which the board performs them.
fn dry_run(planned: &[Planned], settings: &Settings, initial_rad: Pair) -> Result<(), Mistake> {
    let mut dry_run = DryRun {
        settings: *settings,
        reference: ReferenceSource::unknown(initial_rad),
        idle_since_s: None,
    };
    planned.iter().try_for_each(|planned| {
        dry_run
            .check(planned)
            .map_err(|Mistake { place, message }| {
                let at_s = planned.step.at_us as f64 * 1e-6;
                let message = format!("step {} at {at_s} s: {message}", planned.number);
                Mistake { place, message }
            })
    })
}

/// Expected state of the board and the reference.
struct DryRun {
    settings: Settings,
    reference: ReferenceSource,
    idle_since_s: Option<f64>,
}

impl DryRun {
    fn check(&mut self, planned: &Planned) -> Result<(), Mistake> {
        let Planned {
            step,
            place,
            action_place,
            ..
        } = planned;
        match &step.action {
            Action::Command(command) if matches!(**command, Command::Idle | Command::Park) => {
                self.idle_since_s = Some(step.at_us as f64 * 1e-6);
                self.reference.clear();
            }
            Action::Arm => self.idle_since_s = None,
            Action::Change(change) => {
                self.settings = change
                    .apply(&self.settings)
                    .map_err(|error| Mistake::new(action_place.key(error.key()), &error))?;
                params::check(&self.settings)
                    .map_err(|error| Mistake::new(action_place.clone(), error))?;
            }
            Action::Command(_) | Action::Stream(_) => {
                if let Some(since_s) = self.idle_since_s {
                    let message = format!(
                        "the arm has been idle since the step at {since_s} s; put a step with \
                         `arm = true` before this one"
                    );
                    return Err(Mistake::new(place.clone(), message));
                }
                self.check_joints(&step.action, action_place)?;
                self.reference.apply(step, &self.settings, action_place)?;
                self.reference
                    .check_limits(&self.settings.limits, action_place)?;
            }
        }
        Ok(())
    }

    /// Checks that nothing is asked of a joint that the arm does not have.
    fn check_joints(&self, action: &Action, place: &KeyPath) -> Result<(), Mistake> {
        let is_asked = |joint: usize| match action {
            Action::Command(command) => command.demand_of(joint).is_some(),
            Action::Stream(points) => points.iter().any(|point| {
                let speed_rad_s = point.speed_rad_s.map_or(0.0, |speeds| speeds[joint]);
                point.angle_rad[joint] != 0.0 || speed_rad_s != 0.0
            }),
            Action::Arm | Action::Change(_) => false,
        };
        let mut absent = self.settings.setup.arm.joints()..JOINTS;
        absent
            .find(|joint| is_asked(*joint))
            .map_or(Ok(()), |joint| {
                let message = format!(
                    "the board's arm has no joint {}: its `arm.l2_m` and `arm.m2_kg` are 0",
                    joint + 1
                );
                Err(Mistake::new(place.clone(), message))
            })
    }
}

impl StepKeys {
    /// The step's action and its place in the file.
    fn action(&self, place: &KeyPath) -> Result<(Action, KeyPath), Mistake> {
        let actions = [
            ("regulate_rad", self.regulate_rad.is_some()),
            ("torque_nm", self.torque_nm.is_some()),
            ("minimum_jerk", self.minimum_jerk.is_some()),
            ("waypoints", self.waypoints.is_some()),
            ("sinusoid", self.sinusoid.is_some()),
            ("chirp", self.chirp.is_some()),
            ("stream", self.stream.is_some()),
            ("experiment", self.experiment.is_some()),
            ("float", self.float.is_some()),
            ("set", self.set.is_some()),
            ("park", self.park.is_some()),
            ("idle", self.idle.is_some()),
            ("arm", self.arm.is_some()),
        ];
        let mut given = actions.iter().filter(|(_, is_given)| *is_given);
        let ((name, _), None) = (
            given.next().ok_or_else(|| {
                let names = actions.map(|(name, _)| name).join(", ");
                Mistake::new(
                    place.clone(),
                    format!("this step does nothing; give it one of {names}"),
                )
            })?,
            given.next(),
        ) else {
            let message = "a step has one action; put the second into a step of its own with the \
                           same `at_s`";
            return Err(Mistake::new(place.clone(), message));
        };
        let place = place.at(name);
        let action = self.parse_action(&place)?;
        Ok((action, place))
    }

    fn parse_action(&self, at: &KeyPath) -> Result<Action, Mistake> {
        let follow = |motion| Action::Command(Box::new(Command::Follow(motion)));
        if let Some(angles) = self.regulate_rad {
            return Ok(Action::Command(Box::new(Command::Regulate(angles))));
        }
        if let Some(torques) = self.torque_nm {
            return Ok(Action::Command(Box::new(Command::Torque(torques))));
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
            return points(at, keys).map(Action::Stream);
        }
        if let Some(plan) = self.experiment {
            plan.check()
                .map_err(|objection| experiment::mistake(at, objection))?;
            return Ok(Action::Command(Box::new(Command::Experiment(plan))));
        }
        if let Some(table) = &self.set {
            return change_under_torque(at, table).map(Action::Change);
        }
        match (self.float, self.park, self.idle, self.arm) {
            (Some(true), ..) => Ok(Action::Command(Box::new(Command::Float))),
            (_, Some(true), ..) => Ok(Action::Command(Box::new(Command::Park))),
            (_, _, Some(true), _) => Ok(Action::Command(Box::new(Command::Idle))),
            (.., Some(true)) => Ok(Action::Arm),
            _ => Err(Mistake::new(
                at.clone(),
                "expected true; otherwise leave this key out",
            )),
        }
    }
}

fn waypoints(at: &KeyPath, keys: &[ViaKeys]) -> Result<Motion, Mistake> {
    let mut vias = [None; WAYPOINTS_MAX];
    if keys.len() > WAYPOINTS_MAX {
        let message = format!("at most {WAYPOINTS_MAX} waypoints; continue in another step");
        return Err(Mistake::new(at.nth(WAYPOINTS_MAX), message));
    }
    for (number, (via, key)) in vias.iter_mut().zip(keys).enumerate() {
        if key.speed_rad_s.is_some() {
            let message = "the planner chooses speeds at waypoints; use `stream` to set them";
            return Err(Mistake::new(at.nth(number).at("speed_rad_s"), message));
        }
        *via = Some(Via {
            at_s: key.after_s as f32,
            angle_rad: key.angle_rad,
        });
    }
    Ok(Motion::Waypoints(vias))
}

fn points(at: &KeyPath, keys: &[ViaKeys]) -> Result<Vec<Point>, Mistake> {
    let points = keys.iter().enumerate().map(|(number, key)| {
        Ok(Point {
            after_us: microseconds(&at.nth(number).at("after_s"), key.after_s)?,
            angle_rad: key.angle_rad,
            speed_rad_s: key.speed_rad_s,
        })
    });
    points.collect()
}

fn change_under_torque(at: &KeyPath, table: &Table) -> Result<Change, Mistake> {
    let set = pairs(table);
    let is_fixed = |key: &str| {
        key.starts_with("limits.") || key.starts_with("park.") || key == "setup.period_us"
    };
    if let Some((key, _)) = set.iter().find(|(key, _)| is_fixed(key)) {
        let message = "this can be set only while the arm is idle: put it into `[set]`";
        return Err(Mistake::new(at.key(key), message));
    }
    Ok(Change {
        base: Base::Board,
        groups: vec![set],
    })
}

/// Flattens a table of parameters such as `controller.q = ..` to pairs of key and value.
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
