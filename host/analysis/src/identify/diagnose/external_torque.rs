//! External torque, which neither the motor nor the arm explains: a hand, a stop, a cable.
//!
//! With the estimates, the inertial torque of a joint over a segment of a quarter of a second
//! is compared with motor, gravity and friction. At rest or at a reversal, dry friction may
//! have any value up to its maximum.

use super::super::arm::{JointModel, KnownParameters};
use super::super::dataset::{LINEAR_PWM_COUNTS, NEUTRAL, Trace};
use super::super::fit_result::FitResult;
use super::super::quantity::Quantity;
use super::bump::Bump;

/// Half the length of a segment, and distance between segments, in ticks.
const HALF: usize = 120;
const STRIDE: usize = 30;
/// Speed in rad/s above which the direction of sliding is certain.
const SLIDES_RAD_S: f64 = 0.17;
/// Unexplained torque above this is external, in N m: 5 standard deviations with
/// noise of a count and the inertia of the paper's arm.
const THRESHOLD_NM: f64 = 0.15;
/// Largest ratio of dry friction at rest to that in motion.
const STATIC_RATIO: f64 = 2.5;
/// PWM counts about a dead zone's edge in which the motor torque is uncertain.
const EDGE_COUNTS: f64 = 6.0;
/// Uncertainty of the torque there in N m.
const EDGE_NM: f64 = 0.03;
/// Shortest episode in ticks.
const EPISODE_MIN: usize = 300;
/// Longest gap in ticks within an episode.
const MERGE_TICKS: usize = 1_000;

/// An episode of external torque on a joint.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct ExternalTorque {
    /// Index of the trace.
    pub trace: usize,
    /// Joint, from 0.
    pub joint: usize,
    /// First tick.
    pub first: usize,
    /// Length in ticks.
    pub len: usize,
    /// Largest unexplained torque, with its sign.
    pub torque_nm: f64,
}

/// All episodes in smoothed traces.
pub(super) fn episodes(
    traces: &[Trace],
    known: &KnownParameters,
    fit: &FitResult,
) -> Vec<ExternalTorque> {
    let bump = Bump::new(HALF);
    let mut episodes = Vec::new();
    for joint in 0..known.joints {
        let model = Model::new(known, fit, joint);
        for (index, trace) in traces.iter().enumerate() {
            let mut episode: Option<ExternalTorque> = None;
            let firsts = (0..trace.states.len().saturating_sub(bump.len())).step_by(STRIDE);
            for first in firsts {
                let torque_nm = model.unexplained(trace, first, &bump);
                if torque_nm == 0.0 {
                    close_episode(&mut episode, &mut episodes);
                    continue;
                }
                let middle = first + HALF;
                let episode = episode.get_or_insert(ExternalTorque {
                    trace: index,
                    joint,
                    first: middle,
                    len: 0,
                    torque_nm,
                });
                episode.len = middle + STRIDE - episode.first;
                if torque_nm.abs() > episode.torque_nm.abs() {
                    episode.torque_nm = torque_nm;
                }
            }
            close_episode(&mut episode, &mut episodes);
        }
    }
    episodes
}

/// Ends an episode: merges it with the one before if it began soon after.
fn close_episode(episode: &mut Option<ExternalTorque>, episodes: &mut Vec<ExternalTorque>) {
    let Some(episode) = episode.take().filter(|episode| episode.len >= EPISODE_MIN) else {
        return;
    };
    match episodes.last_mut() {
        Some(before)
            if (before.trace, before.joint) == (episode.trace, episode.joint)
                && episode.first <= before.first + before.len + MERGE_TICKS =>
        {
            before.len = episode.first + episode.len - before.first;
            if episode.torque_nm.abs() > before.torque_nm.abs() {
                before.torque_nm = episode.torque_nm;
            }
        }
        Some(_) | None => episodes.push(episode),
    }
}

/// Model of a joint with the estimates.
struct Model<'a> {
    joint: usize,
    known: &'a KnownParameters,
    arm: JointModel<f64>,
    delay_ticks: i64,
    /// Dead zone in PWM counts below and above neutral.
    dead: [f64; 2],
}

impl<'a> Model<'a> {
    fn new(known: &'a KnownParameters, fit: &FitResult, joint: usize) -> Self {
        let estimate = |quantity: Quantity| fit.estimate(joint, quantity).0;
        let arm = JointModel::from_coordinates(known, &fit.coordinates, joint);
        Self {
            joint,
            known,
            delay_ticks: arm.delay_ticks(known).round() as i64,
            arm,
            dead: [estimate(Quantity::DeadBelow), estimate(Quantity::DeadAbove)],
        }
    }

    /// Unexplained torque over a segment in N m, beyond its uncertainty; 0 if explained.
    fn unexplained(&self, trace: &Trace, first: usize, bump: &Bump) -> f64 {
        let joint = self.joint;
        // Single samples may be lost; a segment without half of them is not tested.
        let has_sample = |tick: &usize| !trace.counts[*tick].contains(&None);
        if 2 * (first..first + bump.len()).filter(has_sample).count() < bump.len() {
            return 0.0;
        }
        let state = |tick: usize| trace.states[tick][joint];
        let passive = |tick: usize| {
            let [q, v] = state(tick);
            self.arm
                .passive_dynamics(q, v, trace.states[tick][1 - joint])
        };
        let motor = |tick: usize| {
            let pwm = trace.pwm_at(tick as i64 - self.delay_ticks, joint);
            let torque = self.arm.motor_torque(pwm);
            let counts = f64::from(pwm) - 1_000.0;
            let edge = self.dead[usize::from(counts > 0.0)];
            let is_at_edge = counts != 0.0 && (counts.abs() - edge).abs() < EDGE_COUNTS;
            // The torque of nearly full PWM is uncertain.
            let linear = pwm.clamp(NEUTRAL - LINEAR_PWM_COUNTS, NEUTRAL + LINEAR_PWM_COUNTS);
            let beyond = (torque - self.arm.motor_torque(linear)).abs();
            (torque, beyond + if is_at_edge { EDGE_NM } else { 0.0 })
        };
        let dry = |tick: usize| {
            let [q, v] = state(tick);
            let other = trace.states[tick][1 - joint];
            let load_nm = self.arm.load_friction(q, v, other, motor(tick).0);
            if v.abs() > SLIDES_RAD_S {
                ((self.arm.dry_friction(v) + load_nm) * v.signum(), 0.0)
            } else {
                let sliding_nm = self.arm.dry_friction(f64::INFINITY);
                (0.0, STATIC_RATIO * sliding_nm + load_nm)
            }
        };
        let inertia = passive(first + bump.len() / 2).1;
        let inertial = inertia * bump.rate(first, |tick| state(tick)[1]) / self.known.period_s;
        let explained = bump.mean(first, |tick| passive(tick).0 + motor(tick).0 - dry(tick).0);
        let uncertainty = bump.mean(first, |tick| motor(tick).1 + dry(tick).1);
        let residual = inertial - explained;
        if residual.abs() > THRESHOLD_NM + uncertainty {
            residual - uncertainty.copysign(residual)
        } else {
            0.0
        }
    }
}
