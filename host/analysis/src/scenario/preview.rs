//! Preview of a scenario before anything moves: reference, possible range and largest speed
//! of each joint.
//!
//! If a controller follows a reference, the board's own planner computes it.
//! If a motor is driven in open loop, in an experiment, the motion is unknown, but the
//! board ends the experiment when a joint leaves the envelope. The position before the
//! first step is unknown, and so is that of an arm that floats.

use std::ops::Range;

use armbridge_link::experiment::{Experiment, Role};
use armbridge_link::message::{Command, Settings};
use armbridge_servo::JOINTS;
use serde::Serialize;

use super::Scenario;
use super::file::Pair;
use super::mistake::KeyPath;
use super::reference::ReferenceSource;
use crate::plan_runner::plan::{Action, Point, Step};

/// Number of points of the reference over the run.
const POINTS: f64 = 4_000.0;
/// Smallest distance of the points, in s.
const MIN_SPACING_S: f64 = 2e-3;

/// Time in s since the run began, and reference of a joint in rad; NaN if there is none.
pub type ReferencePoint = (f64, f64);

/// Preview of a run.
#[derive(Clone, Debug, Serialize)]
pub struct Preview {
    /// Name of the scenario.
    pub name: String,
    /// Title of the scenario.
    pub title: String,
    /// Number of joints of the arm.
    pub joints: usize,
    /// Stages, one per step.
    pub stages: Vec<Stage>,
    /// Angles in rad above which the board switches off.
    pub limit_rad: Pair,
    /// Speeds in rad/s above which the board switches off.
    pub limit_rad_s: Pair,
    /// End of the run in s.
    pub end_s: f64,
}

/// Time between a step and the next.
#[derive(Clone, Debug, Serialize)]
pub struct Stage {
    /// Number of the step, from 1.
    pub step: usize,
    /// Time in s since the run began.
    pub time_s: Range<f64>,
    /// Description of the step's action.
    pub doing: String,
    /// Motion of each joint.
    pub joints: [JointPreview; JOINTS],
}

/// Possible motion of one joint in a stage.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct JointPreview {
    /// Smallest and largest angle in rad; `None` if only the board's limits apply.
    pub range_rad: Option<[f64; 2]>,
    /// The board ends the stage when the joint leaves this range.
    pub is_guarded: bool,
    /// Largest speed in rad/s; `None` if only the board's limit applies.
    pub speed_rad_s: Option<f64>,
    /// Reference of the joint.
    #[serde(skip)]
    pub reference: Vec<ReferencePoint>,
}

impl JointPreview {
    const UNKNOWN: Self = Self {
        range_rad: None,
        is_guarded: false,
        speed_rad_s: None,
        reference: Vec::new(),
    };

    fn include(&mut self, angle_rad: f64) {
        let [low, high] = self.range_rad.unwrap_or([angle_rad; 2]);
        self.range_rad = Some([low.min(angle_rad), high.max(angle_rad)]);
    }

    fn add_reference(&mut self, at_s: f64, angle_rad: f64) {
        self.include(angle_rad);
        self.reference.push((at_s, angle_rad));
    }

    /// Range of the final angle: the last reference, or the whole range.
    fn final_range(&self) -> Option<[f64; 2]> {
        let last = self.reference.last().map(|&(_, angle_rad)| angle_rad);
        last.filter(|angle_rad| angle_rad.is_finite())
            .map_or(self.range_rad, |angle_rad| Some([angle_rad; 2]))
    }
}

impl Scenario {
    /// Preview on a board with the settings for which the scenario was loaded.
    pub fn preview(&self) -> Preview {
        let steps = &self.plan.steps;
        let end_us = self.plan.stop.after_us;
        let initial_rad = self.bench.plant.initial.q.map(|q| q as f32);
        let mut walk = PreviewBuilder {
            settings: self.settings,
            source: ReferenceSource::unknown(initial_rad.into()),
            spacing_s: (end_us as f64 * 1e-6 / POINTS).max(MIN_SPACING_S),
            before: [None; JOINTS],
        };
        let stages = steps.iter().enumerate().map(|(index, step)| {
            let next_us = steps.get(index + 1).map_or(end_us, |next| next.at_us);
            let time_s = step.at_us as f64 * 1e-6..next_us.min(end_us) as f64 * 1e-6;
            let joints = walk.stage(step, &time_s);
            walk.before = joints.each_ref().map(JointPreview::final_range);
            Stage {
                step: index + 1,
                time_s,
                doing: step.action.in_words(),
                joints,
            }
        });
        Preview {
            name: self.name.clone(),
            title: self.title.clone(),
            joints: self.settings.setup.arm.joints(),
            stages: stages.collect(),
            limit_rad: self.settings.limits.angle_rad,
            limit_rad_s: self.settings.limits.speed_rad_s,
            end_s: end_us as f64 * 1e-6,
        }
    }
}

/// Motion through streamed points.
fn streamed(points: &[Point], time_s: &Range<f64>) -> [JointPreview; JOINTS] {
    core::array::from_fn(|joint| {
        let mut joint_preview = JointPreview::UNKNOWN;
        for point in points {
            let at_s = time_s.start + point.after_us as f64 * 1e-6;
            joint_preview.add_reference(at_s, point.angle_rad[joint].into());
        }
        // The joint stays at the last point.
        if let Some(last) = points.last() {
            joint_preview.add_reference(time_s.end, last.angle_rad[joint].into());
        }
        joint_preview
    })
}

/// State of the preview from step to step.
struct PreviewBuilder {
    settings: Settings,
    source: ReferenceSource,
    spacing_s: f64,
    /// Range of each joint's angle at the start of a stage.
    before: [Option<[f64; 2]>; JOINTS],
}

impl PreviewBuilder {
    fn stage(&mut self, step: &Step, time_s: &Range<f64>) -> [JointPreview; JOINTS] {
        let rest = self.source.rest(step.at_us);
        // The step was checked when the scenario was loaded.
        let applied = self.source.apply(step, &self.settings, &KeyPath::default());
        match &step.action {
            _ if applied.is_err() => [JointPreview::UNKNOWN; JOINTS],
            Action::Change(change) => {
                self.settings = change.apply(&self.settings).unwrap_or(self.settings);
                self.follow(time_s)
            }
            Action::Stream(points) => streamed(points, time_s),
            Action::Arm => [JointPreview::UNKNOWN; JOINTS],
            Action::Command(command) => match &**command {
                Command::Experiment(plan) => self.experiment(plan, rest, time_s),
                Command::Regulate(_) => self.jump(time_s),
                Command::Follow(_) => self.follow(time_s),
                Command::Idle | Command::Park => {
                    self.source.clear();
                    [JointPreview::UNKNOWN; JOINTS]
                }
                Command::Torque(_)
                | Command::Float
                | Command::Arm { .. }
                | Command::Stream { .. }
                | Command::Prepare
                | Command::Release
                | Command::ClearFault
                | Command::Configure(_)
                | Command::Limit(_)
                | Command::Save => [JointPreview::UNKNOWN; JOINTS],
            },
        }
    }

    fn times(&self, time_s: &Range<f64>) -> impl Iterator<Item = f64> + use<> {
        let (from_s, to_s) = (time_s.start, time_s.end);
        let count = ((to_s - from_s) / self.spacing_s).ceil().max(1.0);
        (0..=count as u32).map(move |k| from_s + (to_s - from_s) * f64::from(k) / count)
    }

    /// Motion along the planned reference.
    fn follow(&self, time_s: &Range<f64>) -> [JointPreview; JOINTS] {
        let mut joints = [JointPreview::UNKNOWN; JOINTS];
        let references: Vec<_> = self
            .times(time_s)
            .map(|at_s| {
                let at_us = (at_s * 1e6).round() as u64;
                (at_s, self.source.at(at_us), self.source.is_over(at_us))
            })
            .collect();
        for (joint, joint_preview) in joints.iter_mut().enumerate() {
            // From an unknown angle in a range, only the end of the motion is known.
            let is_known = self.before[joint].is_some_and(|[low, high]| low >= high);
            let mut fastest = 0.0_f64;
            for (at_s, reference, is_over) in &references {
                fastest = fastest.max(f64::from(reference.dq[joint].abs()));
                if is_known || *is_over {
                    joint_preview.add_reference(*at_s, reference.q[joint].into());
                } else {
                    joint_preview.include(reference.q[joint].into());
                }
            }
            joint_preview.speed_rad_s = is_known.then_some(fastest);
            self.before[joint]
                .into_iter()
                .flatten()
                .for_each(|angle_rad| joint_preview.include(angle_rad));
        }
        joints
    }

    /// Step to another setpoint, whose speed depends on the controller.
    fn jump(&self, time_s: &Range<f64>) -> [JointPreview; JOINTS] {
        let to = self.source.at((time_s.start * 1e6).round() as u64).q;
        core::array::from_fn(|joint| {
            let mut joint_preview = JointPreview::UNKNOWN;
            joint_preview.add_reference(time_s.start, to[joint].into());
            joint_preview.add_reference(time_s.end, to[joint].into());
            let before = self.before[joint];
            before
                .into_iter()
                .flatten()
                .for_each(|angle_rad| joint_preview.include(angle_rad));
            joint_preview
        })
    }

    /// Motion within the envelope of an experiment; held joints have a reference.
    fn experiment(
        &self,
        plan: &Experiment,
        rest: Option<Pair>,
        time_s: &Range<f64>,
    ) -> [JointPreview; JOINTS] {
        core::array::from_fn(|joint| {
            let role = &plan.roles[joint];
            let reference = rest
                .filter(|_| role.is_held())
                .map_or_else(Vec::new, |rest| {
                    let point = |at_s: f64| {
                        let since_s = (at_s - time_s.start) as f32;
                        let offset = match role {
                            Role::Angle(signal) => signal.at(since_s, plan.duration_s).value,
                            Role::Off
                            | Role::Hold
                            | Role::Pwm(_)
                            | Role::Bias(_)
                            | Role::Torque(_) => 0.0,
                        };
                        (at_s, f64::from(rest[joint] + offset))
                    };
                    self.times(time_s).map(point).collect()
                });
            JointPreview {
                range_rad: Some(plan.angle_rad[joint].map(f64::from)),
                is_guarded: true,
                speed_rad_s: Some(plan.speed_rad_s[joint].into()),
                reference,
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

    /// Of a motion after a float only the end is known.
    #[test]
    fn an_arm_that_floats_may_be_anywhere() {
        let text = PLAN.replacen("regulate_rad = [0.1, 0]", "float = true", 1);
        let overrides = Overrides {
            duration_s: Some(3.0),
            ..Overrides::default()
        };
        let preview = Scenario::parse(Path::new("mine.toml"), &text, &overrides).unwrap();
        let [float, go] = &preview.preview().stages[..] else {
            panic!("{preview:?}")
        };
        assert_eq!(float.joints, [JointPreview::UNKNOWN; JOINTS]);
        let [first, _] = &go.joints;
        let is_end =
            |(at_s, angle_rad): &ReferencePoint| *at_s >= 2.0 && (angle_rad - 0.5).abs() < 1e-6;
        assert!(
            !first.reference.is_empty() && first.reference.iter().all(is_end),
            "{first:?}"
        );
    }

    #[test]
    fn each_stage_has_its_range_speed_and_reference() {
        let scenario =
            Scenario::parse(Path::new("mine.toml"), PLAN, &Overrides::default()).unwrap();
        let preview = scenario.preview();
        assert_eq!((preview.stages.len(), preview.end_s), (4, 9.0));
        let [hold, go, driven, back] = &preview.stages[..] else {
            panic!("{preview:?}")
        };
        let near = |a: f64, b: f64| (a - b).abs() < 1e-6;
        let has_range = |joint_preview: &JointPreview, low: f64, high: f64| {
            joint_preview
                .range_rad
                .is_some_and(|[a, b]| near(a, low) && near(b, high))
        };
        assert!(has_range(&hold.joints[0], 0.1, 0.1) && hold.joints[0].speed_rad_s.is_none());
        // 15/8 of the mean speed.
        assert!(has_range(&go.joints[0], 0.1, 0.5) && has_range(&go.joints[1], 0.0, 0.2));
        assert!((go.joints[0].speed_rad_s.unwrap() - 0.75).abs() < 1e-3);
        // The envelope; an open-loop joint has no reference.
        assert!(has_range(&driven.joints[1], -0.4, 0.6) && driven.joints[1].is_guarded);
        assert!(driven.joints[1].reference.is_empty());
        assert!(
            driven.joints[0]
                .reference
                .iter()
                .all(|(_, q)| near(*q, 0.5))
        );
        // Only the end of joint 2's motion back is known.
        assert!(has_range(&back.joints[0], 0.0, 0.5) && has_range(&back.joints[1], -0.4, 0.6));
        assert!(back.joints[1].speed_rad_s.is_none());
        assert!(
            back.joints[1]
                .reference
                .iter()
                .all(|(at_s, q)| *at_s >= 7.0 && *q == 0.0)
        );
    }
}
