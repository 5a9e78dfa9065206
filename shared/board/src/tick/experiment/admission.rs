//! Admission of experiments: checks that one may begin from the present state of the arm.
//!
//! Its envelope must lie where no monitor interferes with an arm that stays in it,
//! the arm must be in it, and the demands on the joints must be within the limits in
//! force. Its own consistency has been [checked](Experiment::check) before.

use nalgebra::Vector2;

use super::super::limits::MOTION;
use super::super::monitors::MonitorConfig;
use armbridge_control::arm::State;
use armbridge_link::experiment::{Experiment, Measure, Objection, Role};
use armbridge_link::message::Settings;

/// Whether a board with these settings would begin this experiment, with the arm at rest
/// at these angles.
///
/// # Errors
/// The reason for the refusal.
pub fn permits(
    settings: &Settings,
    plan: &Experiment,
    angle_rad: [f32; armbridge_servo::JOINTS],
) -> Result<(), Objection> {
    plan.check()?;
    let setup = &settings.setup;
    let monitors = MonitorConfig::new(settings.limits, &setup.joints, setup.period_us);
    let rest = angle_rad.into();
    let state = State {
        q: rest,
        dq: Vector2::zeros(),
    };
    admit(plan, &monitors, &state, rest)
}

/// Checks that an experiment may begin with the arm at `state`, whose reference will be at
/// rest at `rest`.
pub(in crate::tick) fn admit(
    plan: &Experiment,
    monitors: &MonitorConfig,
    state: &State<f32>,
    rest: Vector2<f32>,
) -> Result<(), Objection> {
    let limits = monitors.limits();
    for (index, (joint, role)) in (0..).zip(&plan.roles).enumerate() {
        let beyond = |measure, value: f32, limit: f32| {
            // NaN is beyond every limit.
            let is_within = value.abs() <= limit;
            let objection = Objection::Beyond {
                joint,
                measure,
                value,
                limit,
            };
            if is_within { Ok(()) } else { Err(objection) }
        };
        let ([low, high], speed_limit) = (plan.angle_rad[index], plan.speed_rad_s[index]);
        beyond(Measure::Speed, speed_limit, limits.speed_rad_s[index])?;
        let farthest = monitors.farthest_rad(index, speed_limit);
        if let Some(edge_rad) = [low, high].into_iter().find(|edge| edge.abs() > farthest) {
            return Err(Objection::Edge {
                joint,
                edge_rad,
                speed_rad_s: speed_limit,
                farthest_rad: farthest,
            });
        }
        let (angle_rad, speed_rad_s) = (state.q[index], state.dq[index]);
        if !(low..=high).contains(&angle_rad) {
            return Err(Objection::Outside {
                joint,
                angle_rad,
                within_rad: [low, high],
            });
        }
        let is_slow = speed_rad_s.abs() <= speed_limit;
        if !is_slow {
            return Err(Objection::Moving {
                joint,
                speed_rad_s,
                limit_rad_s: speed_limit,
            });
        }
        let bounds = role.signal().map(|signal| signal.bounds(plan.duration_s));
        match (role, bounds) {
            (Role::Pwm(_) | Role::Bias(_), Some(bounds)) => {
                let limit = f32::from(limits.pwm_counts);
                beyond(Measure::Pwm, bounds.farthest(), limit)?;
            }
            (Role::Torque(_), Some(bounds)) => {
                beyond(Measure::Torque, bounds.farthest(), limits.torque_nm[index])?;
            }
            (Role::Hold | Role::Angle(_), bounds) => {
                let [least, greatest] = bounds.map_or([0.0; 2], |bounds| [bounds.low, bounds.high]);
                let [speed, acceleration] = bounds
                    .and_then(|bounds| bounds.derivatives)
                    .unwrap_or([0.0; 2]);
                for reached in [rest[index] + least, rest[index] + greatest] {
                    if !(low..=high).contains(&reached) {
                        return Err(Objection::Beyond {
                            joint,
                            measure: Measure::Angle,
                            value: reached,
                            limit: if reached < low { low } else { high },
                        });
                    }
                    beyond(Measure::Angle, reached, MOTION.angle_rad)?;
                }
                beyond(Measure::Speed, speed, speed_limit.min(MOTION.speed_rad_s))?;
                beyond(
                    Measure::Acceleration,
                    acceleration,
                    MOTION.acceleration_rad_s2,
                )?;
            }
            (Role::Off | Role::Pwm(_) | Role::Bias(_) | Role::Torque(_), _) => {}
        }
    }
    Ok(())
}
