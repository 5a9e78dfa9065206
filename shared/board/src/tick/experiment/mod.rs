//! Experiments, tick by tick: the signal of each joint, and the end.
//!
//! ```text
//! admit -> begin -> tick: in the envelope? -> reference, PWM, torque -> limits -> ...
//!                               | no, or time over, or the host is silent
//!                               +-> braked to rest, and held
//! ```
//!
//! Time is that of the planned beginnings of ticks, from the first one on whose command
//! is the experiment's, so a skipped tick is not made up for.
//!
//! A joint in open loop has no reference: its reference is the predicted state, so that
//! the controller of the other joint sees no error in it, and the record shows no
//! difference between reference and angle.

mod admission;

pub(super) use admission::admit;
pub use admission::permits;

use super::monitors::Debounce;
use super::torque_control::Demand;
use armbridge_control::actuator::Joint;
use armbridge_control::arm::State;
use armbridge_control::experiment::Signal;
use armbridge_control::trajectory::Reference;
use armbridge_link::experiment::{Experiment, ExperimentEnd, HELD_S, Role};
use armbridge_servo::{JOINTS, Pwm};

/// The experiment under way, or the last one.
#[derive(Clone, Debug)]
#[cfg_attr(feature = "snapshot", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct ActiveExperiment {
    pub(super) plan: Experiment,
    /// Time at which its first tick begins to act; `None` until it is decided.
    starts_us: Option<u64>,
    /// Time of the present tick, in s since then.
    elapsed_s: f32,
    fast: [Debounce; JOINTS],
    /// PWM in counts from off that held each joint, summed over the counted ticks.
    held_counts: [f32; JOINTS],
    held_ticks: f32,
    /// Whether the host has been silent for too long.
    is_host_silent: bool,
}

impl Default for ActiveExperiment {
    fn default() -> Self {
        Self::new(Experiment::NONE)
    }
}

impl ActiveExperiment {
    pub(super) fn new(plan: Experiment) -> Self {
        Self {
            plan,
            starts_us: None,
            elapsed_s: 0.0,
            fast: Default::default(),
            held_counts: [0.0; JOINTS],
            held_ticks: 0.0,
            is_host_silent: false,
        }
    }

    /// Whether a tick has used the experiment.
    pub(super) fn is_started(&self) -> bool {
        self.starts_us.is_some()
    }

    /// Runs one tick: overrides `reference`, that of the source at `acts_us`, for an arm that
    /// is at `state` and will be at `ahead` then, after `pwm` was decided in the previous
    /// tick. `Some` when the experiment has ended.
    #[inline(never)]
    pub(super) fn tick(
        &mut self,
        pwm: [Pwm; JOINTS],
        state: &State<f32>,
        ahead: &State<f32>,
        acts_us: u64,
        fast_ticks: u32,
        reference: &mut Reference<f32>,
    ) -> Option<ExperimentEnd> {
        self.note_pwm(pwm);
        self.set_elapsed(acts_us);
        self.apply(ahead, reference);
        self.end(state, fast_ticks)
    }

    /// Ends the experiment: the host has been silent for too long.
    pub(super) fn note_host_silence(&mut self) {
        self.is_host_silent = true;
    }

    fn set_elapsed(&mut self, acts_us: u64) {
        let starts_us = *self.starts_us.get_or_insert(acts_us);
        // Ten minutes in µs are 32 bits.
        let elapsed_us = u32::try_from(acts_us.saturating_sub(starts_us)).unwrap_or(u32::MAX);
        self.elapsed_s = elapsed_us as f32 * 1e-6;
    }

    /// Whether joints are still held before their PWM is frozen.
    fn is_freezing(&self) -> bool {
        self.elapsed_s < HELD_S
    }

    /// Adds the PWM of the previous tick to the mean of the held joints.
    fn note_pwm(&mut self, pwm: [Pwm; JOINTS]) {
        if self.is_freezing() {
            for (sum, pwm) in self.held_counts.iter_mut().zip(pwm) {
                *sum += f32::from(pwm.counts()) - f32::from(Pwm::OFF.counts());
            }
            self.held_ticks += 1.0;
        }
    }

    /// Overrides the reference per joint; open-loop joints track `ahead`, where the arm
    /// will be.
    fn apply(&self, ahead: &State<f32>, reference: &mut Reference<f32>) {
        for (joint, role) in self.plan.roles.iter().enumerate() {
            match role {
                Role::Hold => {}
                Role::Bias(_) if self.is_freezing() => {}
                Role::Angle(signal) => {
                    let sample = signal.at(self.elapsed_s, self.plan.duration_s);
                    reference.q[joint] += sample.value;
                    reference.dq[joint] += sample.first;
                    reference.ddq[joint] += sample.second;
                }
                Role::Off | Role::Pwm(_) | Role::Bias(_) | Role::Torque(_) => {
                    reference.q[joint] = ahead.q[joint];
                    reference.dq[joint] = ahead.dq[joint];
                    reference.ddq[joint] = 0.0;
                }
            }
        }
    }

    /// The end of the experiment, if the state or the time ends it.
    fn end(&mut self, state: &State<f32>, fast_ticks: u32) -> Option<ExperimentEnd> {
        let envelope = self.plan.angle_rad.into_iter().zip(self.plan.speed_rad_s);
        let states = state.q.iter().zip(state.dq.iter());
        let mut end = None;
        for (((joint, fast), ([low, high], speed_limit)), (q, dq)) in
            (0..).zip(&mut self.fast).zip(envelope).zip(states)
        {
            let is_fast = fast.count(dq.abs() > speed_limit, fast_ticks);
            if !(low..=high).contains(q) {
                let value_rad = *q;
                end = end.or(Some(ExperimentEnd::Angle { joint, value_rad }));
            } else if is_fast {
                let value_rad_s = *dq;
                end = end.or(Some(ExperimentEnd::Speed { joint, value_rad_s }));
            }
        }
        let is_finished = self.elapsed_s >= self.plan.duration_s;
        end.or(is_finished.then_some(ExperimentEnd::Finished))
            .or(self.is_host_silent.then_some(ExperimentEnd::HostQuiet))
    }

    /// Overrides the controller's demand per joint, with a PWM or a torque.
    #[inline(never)]
    pub(super) fn override_torque(&self, joints: &[Joint<f32>; JOINTS], demand: &mut Demand) {
        for ((joint, actuator), role) in joints.iter().enumerate().zip(&self.plan.roles) {
            let sample = |signal: &Signal<f32>| signal.at(self.elapsed_s, self.plan.duration_s);
            let pwm = match role {
                Role::Hold | Role::Angle(_) => continue,
                Role::Torque(signal) => {
                    demand.torque_nm[joint] = sample(signal).value;
                    demand.friction_nm[joint] = 0.0;
                    continue;
                }
                Role::Pwm(signal) => Pwm::from_off(sample(signal).value),
                Role::Bias(_) if self.is_freezing() => continue,
                Role::Bias(signal) => {
                    let held = self.held_counts[joint] / self.held_ticks;
                    let since_s = self.elapsed_s - HELD_S;
                    Pwm::from_off(held + signal.at(since_s, self.plan.duration_s).value)
                }
                Role::Off => Pwm::OFF,
            };
            demand.torque_nm[joint] = actuator.torque(pwm);
            demand.friction_nm[joint] = 0.0;
            demand.exact_pwm[joint] = Some(pwm);
        }
    }
}
