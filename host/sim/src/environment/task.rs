//! Tasks: where an episode begins, what the policy sees of it, and what it is rewarded for.
//!
//! The reward of a step is `1 - tanh(distance / 0.1 rad) - 0.05 effort`, with the distance of the
//! estimated angles from the target, and the mean square of the torques, as shares of their limits,
//! as the effort. So it is 1 at the target without torque.

use armbridge_link::message::Limits;
use armbridge_servo::JOINTS;
use rand_distr::{Distribution, Uniform};
use rand_pcg::Pcg32;

use super::Observation;

/// Distance in rad at which the reward has fallen to a quarter.
const SCALE_RAD: f64 = 0.1;
/// Share of the effort in the reward.
const EFFORT: f64 = 0.05;
/// Angle from the start of which an arm has fallen, in rad: too far for most balancing policies.
const FALLEN_RAD: f64 = 0.6;
/// Largest initial angle of [`Task::Balance`] in rad.
const BALANCE_START_RAD: f64 = 0.2;
/// Largest initial angle, and largest target, of [`Task::Reach`], in rad.
const REACH_RAD: f64 = 0.5;

/// A task.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Task {
    /// Bring the arm upright from 0.2 rad at most, and keep it there; it ends when a joint is
    /// 0.6 rad off. Observed are angles and speeds.
    Balance,
    /// Bring the arm to a target, up to 0.5 rad from upright in each joint, from a posture in the
    /// same range. Observed are angles, speeds and target.
    Reach,
}

/// Posture and target of an episode, in rad.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Episode {
    pub(super) start_rad: [f64; JOINTS],
    pub(super) target_rad: [f64; JOINTS],
}

impl Task {
    /// Length of an observation.
    pub const fn vector_len(self) -> usize {
        match self {
            Self::Balance => 2 * JOINTS,
            Self::Reach => 3 * JOINTS,
        }
    }

    /// Draws an episode.
    pub(super) fn draw(self, random: &mut Pcg32) -> Episode {
        let mut within = |most: f64| {
            let range = Uniform::new_inclusive(-most, most).expect("a finite range");
            core::array::from_fn(|_| range.sample(random))
        };
        match self {
            Self::Balance => Episode {
                start_rad: within(BALANCE_START_RAD),
                target_rad: [0.0; JOINTS],
            },
            Self::Reach => Episode {
                start_rad: within(REACH_RAD),
                target_rad: within(REACH_RAD),
            },
        }
    }

    /// Writes the observation, [`vector_len`](Self::vector_len) numbers: angles in rad, speeds
    /// in rad/s, and the target in rad if the task has one.
    pub fn write_vector(
        self,
        observation: &Observation,
        target_rad: [f64; JOINTS],
        into: &mut [f32],
    ) {
        let target_rad = target_rad.map(|value| value as f32);
        let all = observation.angle_rad.into_iter();
        let all = all.chain(observation.speed_rad_s).chain(target_rad);
        for (place, value) in into.iter_mut().take(self.vector_len()).zip(all) {
            *place = value;
        }
    }

    /// Reward of a step with this last tick, and whether the task has ended.
    pub fn evaluate(
        self,
        observation: &Observation,
        target_rad: [f64; JOINTS],
        limits: &Limits,
    ) -> (f64, bool) {
        let angle_rad = observation.angle_rad.map(f64::from);
        let [a, b] = [0, 1].map(|joint| angle_rad[joint] - target_rad[joint]);
        let shares = [0, 1].map(|joint| {
            let share =
                f64::from(observation.torque_nm[joint]) / f64::from(limits.torque_nm[joint]);
            share * share
        });
        let effort = f64::midpoint(shares[0], shares[1]);
        let reward = 1.0 - (a.hypot(b) / SCALE_RAD).tanh() - EFFORT * effort;
        let has_fallen = angle_rad.iter().any(|angle| angle.abs() > FALLEN_RAD);
        (reward, self == Self::Balance && has_fallen)
    }
}
