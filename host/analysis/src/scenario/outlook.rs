//! What a scenario will ask of an arm, known before anything moves: where each joint is
//! to be, where it may be, and how fast.
//!
//! Where a controller follows a reference, that is computed by the board's own planner.
//! Where a motor is driven open-loop, in an experiment, the arm's way is not known; but the
//! board ends the experiment when it leaves the envelope. Before its first step the arm is
//! wherever it is held.

use std::ops::Range;

use armbridge_shared::JOINTS;
use armbridge_shared::link::experiment::{Experiment, Role};
use armbridge_shared::link::message::{Command, Settings};
use serde::Serialize;

use super::Scenario;
use super::file::Pair;
use super::location::Place;
use super::reference::Course;
use crate::plan_runner::plan::{Act, Point, Step};

/// Points at which references are computed, over all of the run.
const POINTS: f64 = 4_000.0;
/// No closer together than this, in s.
const CLOSEST_S: f64 = 2e-3;

/// Seconds since the run began, and what is asked of a joint then, in rad; NaN where
/// nothing is asked or known.
pub type Asked = (f64, f64);

/// What is to come.
#[derive(Clone, Debug, Serialize)]
pub struct Outlook {
    /// Of the scenario.
    pub name: String,
    /// In a few words.
    pub title: String,
    /// From one step to the next.
    pub stages: Vec<Stage>,
    /// Beyond these angles the board switches off, in rad.
    pub limit_rad: Pair,
    /// Above these speeds it does so too, in rad/s.
    pub limit_rad_s: Pair,
    /// When the run is over, in s.
    pub end_s: f64,
}

/// What is done between a step and the next.
#[derive(Clone, Debug, Serialize)]
pub struct Stage {
    /// Of the steps of the run, from 1.
    pub step: usize,
    /// In s since the run began.
    pub time_s: Range<f64>,
    /// In words.
    pub doing: String,
    /// Joint by joint.
    pub joints: [Swept; JOINTS],
}

/// What one joint does in a stage.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Swept {
    /// Least and most angle in rad; `None` where only the board's limits are sure.
    pub range_rad: Option<[f64; 2]>,
    /// The board ends the stage when the joint leaves this range.
    pub is_guarded: bool,
    /// Greatest speed in rad/s; `None` where only the board's limits are sure.
    pub speed_rad_s: Option<f64>,
    /// What is asked of it.
    #[serde(skip)]
    pub asked: Vec<Asked>,
}

impl Swept {
    const UNKNOWN: Self = Self {
        range_rad: None,
        is_guarded: false,
        speed_rad_s: None,
        asked: Vec::new(),
    };

    fn include(&mut self, angle_rad: f64) {
        let [low, high] = self.range_rad.unwrap_or([angle_rad; 2]);
        self.range_rad = Some([low.min(angle_rad), high.max(angle_rad)]);
    }

    fn ask(&mut self, at_s: f64, angle_rad: f64) {
        self.include(angle_rad);
        self.asked.push((at_s, angle_rad));
    }

    /// Where it is in the end: where it was asked to be, or anywhere in its range.
    fn rests_in(&self) -> Option<[f64; 2]> {
        let last = self.asked.last().map(|&(_, angle_rad)| angle_rad);
        last.filter(|angle_rad| angle_rad.is_finite())
            .map_or(self.range_rad, |angle_rad| Some([angle_rad; 2]))
    }
}

impl Scenario {
    /// What it will do on a board with the settings that it was loaded for.
    pub fn outlook(&self) -> Outlook {
        let steps = &self.plan.steps;
        let end_us = self.plan.stop.after_us;
        let initial_rad = self.bench.plant.initial.q.map(|q| q as f32);
        let mut walk = Walk {
            settings: self.settings,
            course: Course::unknown(initial_rad.into()),
            spacing_s: (end_us as f64 * 1e-6 / POINTS).max(CLOSEST_S),
            before: [None; JOINTS],
        };
        let stages = steps.iter().enumerate().map(|(index, step)| {
            let next_us = steps.get(index + 1).map_or(end_us, |next| next.at_us);
            let time_s = step.at_us as f64 * 1e-6..next_us.min(end_us) as f64 * 1e-6;
            let joints = walk.stage(step, &time_s);
            walk.before = joints.each_ref().map(Swept::rests_in);
            Stage {
                step: index + 1,
                time_s,
                doing: step.act.in_words(),
                joints,
            }
        });
        Outlook {
            name: self.name.clone(),
            title: self.title.clone(),
            stages: stages.collect(),
            limit_rad: self.settings.limits.angle_rad,
            limit_rad_s: self.settings.limits.speed_rad_s,
            end_s: end_us as f64 * 1e-6,
        }
    }
}

/// Through points.
fn streamed(points: &[Point], time_s: &Range<f64>) -> [Swept; JOINTS] {
    core::array::from_fn(|joint| {
        let mut swept = Swept::UNKNOWN;
        for point in points {
            let at_s = time_s.start + point.after_us as f64 * 1e-6;
            swept.ask(at_s, point.angle_rad[joint].into());
        }
        // At the last of them it stays.
        if let Some(last) = points.last() {
            swept.ask(time_s.end, last.angle_rad[joint].into());
        }
        swept
    })
}

/// From step to step.
struct Walk {
    settings: Settings,
    course: Course,
    spacing_s: f64,
    /// Where each joint is when a stage begins.
    before: [Option<[f64; 2]>; JOINTS],
}

impl Walk {
    fn stage(&mut self, step: &Step, time_s: &Range<f64>) -> [Swept; JOINTS] {
        let rest = self.course.rest(step.at_us);
        // That the board takes it was seen when the scenario was loaded.
        let taken = self.course.take(step, &self.settings, &Place::default());
        match &step.act {
            _ if taken.is_err() => [Swept::UNKNOWN; JOINTS],
            Act::Change(change) => {
                self.settings = change.apply(&self.settings).unwrap_or(self.settings);
                self.follow(time_s)
            }
            Act::Stream(points) => streamed(points, time_s),
            Act::Arm => [Swept::UNKNOWN; JOINTS],
            Act::Tell(command) => match &**command {
                Command::Experiment(plan) => self.experiment(plan, rest, time_s),
                Command::Regulate(_) => self.jump(time_s),
                Command::Follow(_) => self.follow(time_s),
                Command::Idle => {
                    self.course.lose();
                    [Swept::UNKNOWN; JOINTS]
                }
                Command::Torque(_)
                | Command::Arm { .. }
                | Command::Stream { .. }
                | Command::Prepare
                | Command::Release
                | Command::ClearFault
                | Command::Configure(_)
                | Command::Limit(_)
                | Command::Save => [Swept::UNKNOWN; JOINTS],
            },
        }
    }

    fn times(&self, time_s: &Range<f64>) -> impl Iterator<Item = f64> + use<> {
        let (from_s, to_s) = (time_s.start, time_s.end);
        let count = ((to_s - from_s) / self.spacing_s).ceil().max(1.0);
        (0..=count as u32).map(move |k| from_s + (to_s - from_s) * f64::from(k) / count)
    }

    /// Along what is planned.
    fn follow(&self, time_s: &Range<f64>) -> [Swept; JOINTS] {
        let mut joints = [Swept::UNKNOWN; JOINTS];
        let references: Vec<_> = self
            .times(time_s)
            .map(|at_s| {
                let at_us = (at_s * 1e6).round() as u64;
                (at_s, self.course.at(at_us), self.course.is_over(at_us))
            })
            .collect();
        for (joint, swept) in joints.iter_mut().enumerate() {
            // From somewhere in a range: only the end is known.
            let is_sure = self.before[joint].is_some_and(|[low, high]| low >= high);
            let mut fastest = 0.0_f64;
            for (at_s, reference, is_over) in &references {
                fastest = fastest.max(f64::from(reference.dq[joint].abs()));
                if is_sure || *is_over {
                    swept.ask(*at_s, reference.q[joint].into());
                } else {
                    swept.include(reference.q[joint].into());
                }
            }
            swept.speed_rad_s = is_sure.then_some(fastest);
            self.before[joint]
                .into_iter()
                .flatten()
                .for_each(|angle_rad| swept.include(angle_rad));
        }
        joints
    }

    /// At once to another setpoint: how fast is the controller's affair.
    fn jump(&self, time_s: &Range<f64>) -> [Swept; JOINTS] {
        let to = self.course.at((time_s.start * 1e6).round() as u64).q;
        core::array::from_fn(|joint| {
            let mut swept = Swept::UNKNOWN;
            swept.ask(time_s.start, to[joint].into());
            swept.ask(time_s.end, to[joint].into());
            let before = self.before[joint];
            before
                .into_iter()
                .flatten()
                .for_each(|angle_rad| swept.include(angle_rad));
            swept
        })
    }

    /// In its envelope; where joints are held, as they are asked.
    fn experiment(
        &self,
        plan: &Experiment,
        rest: Option<Pair>,
        time_s: &Range<f64>,
    ) -> [Swept; JOINTS] {
        core::array::from_fn(|joint| {
            let role = &plan.roles[joint];
            let asked = rest
                .filter(|_| role.is_held())
                .map_or_else(Vec::new, |rest| {
                    let asked = |at_s: f64| {
                        let since_s = (at_s - time_s.start) as f32;
                        let swing = match role {
                            Role::Angle(signal) => signal.at(since_s, plan.duration_s).value,
                            Role::Off
                            | Role::Hold
                            | Role::Pwm(_)
                            | Role::Bias(_)
                            | Role::Torque(_) => 0.0,
                        };
                        (at_s, f64::from(rest[joint] + swing))
                    };
                    self.times(time_s).map(asked).collect()
                });
            Swept {
                range_rad: Some(plan.angle_rad[joint].map(f64::from)),
                is_guarded: true,
                speed_rad_s: Some(plan.speed_rad_s[joint].into()),
                asked,
            }
        })
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use crate::scenario::Overrides;

    const PLAN: &str = "title = \"t\"
[[step]]
at_s = 0
regulate_rad = [0.1, 0]
[[step]]
at_s = 1
minimum_jerk = { to_rad = [0.5, 0.2], duration_s = 1.0 }
[[step]]
at_s = 3
[step.experiment]
duration_s = 2
angle_rad = [[0.3, 0.7], [-0.4, 0.6]]
speed_rad_s = [1, 2]
roles = [\"hold\", { pwm = { constant = 60 } }]
[[step]]
at_s = 6
minimum_jerk = { to_rad = [0, 0], duration_s = 1.0 }
[stop]
after_s = 9
";

    #[test]
    fn what_is_known_of_each_stage_is_told() {
        let scenario =
            Scenario::parse(Path::new("mine.toml"), PLAN, &Overrides::default()).unwrap();
        let outlook = scenario.outlook();
        assert_eq!((outlook.stages.len(), outlook.end_s), (4, 9.0));
        let [hold, go, driven, back] = &outlook.stages[..] else {
            panic!("{outlook:?}")
        };
        let near = |a: f64, b: f64| (a - b).abs() < 1e-6;
        let is = |swept: &Swept, low: f64, high: f64| {
            swept
                .range_rad
                .is_some_and(|[a, b]| near(a, low) && near(b, high))
        };
        assert!(is(&hold.joints[0], 0.1, 0.1) && hold.joints[0].speed_rad_s.is_none());
        // 15/8 of the mean speed.
        assert!(is(&go.joints[0], 0.1, 0.5) && is(&go.joints[1], 0.0, 0.2));
        assert!((go.joints[0].speed_rad_s.unwrap() - 0.75).abs() < 1e-3);
        // The envelope; a motor that is driven blindly is asked for no angle.
        assert!(is(&driven.joints[1], -0.4, 0.6) && driven.joints[1].is_guarded);
        assert!(driven.joints[1].asked.is_empty());
        assert!(driven.joints[0].asked.iter().all(|(_, q)| near(*q, 0.5)));
        // Back from wherever it got to: only where it ends is known of joint 2.
        assert!(is(&back.joints[0], 0.0, 0.5) && is(&back.joints[1], -0.4, 0.6));
        assert!(back.joints[1].speed_rad_s.is_none());
        assert!(
            back.joints[1]
                .asked
                .iter()
                .all(|(at_s, q)| *at_s >= 7.0 && *q == 0.0)
        );
    }
}
