//! Narrowing of a plan to what the board permits: the angles of a joint scaled down, all by one factor,
//! and the steps of a joint that the arm does not have left out.
//!
//! An experiment's envelope ends where the board does not brake yet at the envelope's speed. That is
//! the nearer the farther a servo's zero is from the middle of its counts, or the lower the angle
//! limit is.

use armbridge_board::bridge::permits;
use armbridge_link::experiment::{Experiment, Objection, Role};
use armbridge_link::message::Settings;
use armbridge_servo::JOINTS;

use super::file::{Pair, StepKeys};
use super::reference::middle;

/// Share of the permitted angle that is used: rounding must not make it too large.
const USED: f32 = 0.999;

/// Narrows these steps for a board with these settings; the factor of each joint.
pub(super) fn narrow(steps: &mut [StepKeys], settings: &Settings) -> Pair {
    let mut factors = [1.0; JOINTS];
    for plan in steps.iter().filter_map(|step| step.experiment) {
        while let Some((joint, factor)) = too_wide(&scaled(plan, factors), settings) {
            factors[joint] *= USED * factor;
        }
    }
    for step in steps {
        step.scale(factors);
    }
    factors
}

/// Leaves out joint 2, which the arm does not have: experiments with it alone, whose time the steps after
/// them take, and its angles in all others. Returns the time saved in s, of a run until `end_s`.
pub(super) fn leave_out_joint_2(steps: &mut [StepKeys], end_s: f64) -> f64 {
    let next = steps.iter().skip(1).map(|step| step.at_s);
    let ends: Vec<f64> = next.chain([end_s]).collect();
    let mut saved_s = 0.0;
    for (step, end_s) in steps.iter_mut().zip(ends) {
        let lasts_s = end_s - step.at_s;
        step.at_s -= saved_s;
        step.is_left_out = step
            .experiment
            .is_some_and(|plan| plan.roles[0] == Role::Hold);
        if step.is_left_out {
            saved_s += lasts_s;
        }
        let envelope = step.experiment.map(|plan| plan.angle_rad[1]);
        step.scale([1.0, 0.0]);
        if let (Some(plan), Some(envelope)) = (&mut step.experiment, envelope) {
            plan.roles[1] = Role::Hold;
            plan.angle_rad[1] = envelope;
        }
    }
    saved_s
}

/// The joint whose envelope is too wide, and the factor that makes it narrow enough.
fn too_wide(plan: &Experiment, settings: &Settings) -> Option<(usize, f32)> {
    match permits(settings, plan, middle(plan)) {
        Err(Objection::Edge {
            joint,
            edge_rad,
            farthest_rad,
            ..
        }) if farthest_rad > 0.0 => Some((joint.into(), farthest_rad / edge_rad.abs())),
        Ok(()) | Err(_) => None,
    }
}

/// The same experiment with scaled angles.
fn scaled(mut plan: Experiment, factors: Pair) -> Experiment {
    for ((role, angles), factor) in plan.roles.iter_mut().zip(&mut plan.angle_rad).zip(factors) {
        *angles = angles.map(|angle| angle * factor);
        if let Role::Angle(signal) = role {
            *signal = signal.scaled(factor);
        }
    }
    plan
}

impl StepKeys {
    /// Scales the angles of every action.
    fn scale(&mut self, factors: Pair) {
        let scale = |angles: &mut Pair| {
            for (angle, factor) in angles.iter_mut().zip(factors) {
                *angle *= factor;
            }
        };
        let setpoint = self.regulate_rad.iter_mut();
        let motion = self.minimum_jerk.iter_mut().map(|keys| &mut keys.to_rad);
        let sinusoid = self.sinusoid.iter_mut();
        let sinusoid = sinusoid.flat_map(|keys| [&mut keys.centre_rad, &mut keys.amplitude_rad]);
        let chirp = self.chirp.iter_mut();
        let chirp = chirp.flat_map(|keys| [&mut keys.centre_rad, &mut keys.amplitude_rad]);
        let points = [&mut self.waypoints, &mut self.stream];
        let points = points.into_iter().flatten().flatten();
        let points =
            points.flat_map(|point| [Some(&mut point.angle_rad), point.speed_rad_s.as_mut()]);
        (setpoint.chain(motion).chain(sinusoid).chain(chirp))
            .chain(points.flatten())
            .for_each(scale);
        self.experiment = self.experiment.map(|plan| scaled(plan, factors));
    }
}

#[cfg(test)]
mod tests {
    use armbridge_link::message::Command;

    use super::super::{Overrides, Scenario};
    use super::*;
    use crate::plan_runner::plan::Action;

    /// The plan that ships, for a board whose second servo has this zero.
    fn shipped(zero_count: f32) -> Scenario {
        let mut board = Settings::default();
        board.setup.joints[1].zero_count = zero_count;
        let overrides = Overrides {
            board: Some(board),
            ..Overrides::default()
        };
        Scenario::load("identify", &overrides).unwrap()
    }

    /// The farthest edges of the plan's envelopes, in rad.
    fn edges_rad(scenario: &Scenario) -> Pair {
        let mut edges_rad = [0.0; JOINTS];
        for step in &scenario.plan.steps {
            let Action::Command(command) = &step.action else {
                continue;
            };
            if let Command::Experiment(plan) = **command {
                for (edge_rad, [low, high]) in edges_rad.iter_mut().zip(plan.angle_rad) {
                    *edge_rad = high.max(-low).max(*edge_rad);
                }
            }
        }
        edges_rad
    }

    #[test]
    fn the_plan_that_ships_fits_wherever_a_zero_may_be() {
        let as_written = shipped(512.0);
        assert_eq!(as_written.notes, [""; 0]);
        let [first, second] = edges_rad(&as_written);
        for (zero_count, percent) in [(524.0, 99.3), (482.0, 90.5), (612.0, 53.8)] {
            let narrowed = shipped(zero_count);
            let [one, two] = edges_rad(&narrowed);
            assert!(
                (one - first).abs() < 1e-6,
                "{zero_count}: {one} instead of {first}"
            );
            assert!(
                (two / second * 100.0 - percent).abs() < 1.0,
                "{zero_count}: {}",
                two / second
            );
            let note = format!("its angles are {:.0} % of the plan's", two / second * 100.0);
            assert!(
                narrowed.notes.len() == 1 && narrowed.notes[0].contains(&note),
                "{:?}",
                narrowed.notes
            );
        }
    }

    #[test]
    fn a_plan_that_does_not_ask_for_it_is_left_as_it_is() {
        let text = "title = 't'\n[[step]]\nat_s = 0\nregulate_rad = [0, 0]\n[[step]]\nat_s = 1\n\
                    [step.experiment]\nroles = ['hold', 'hold']\nduration_s = 1.0\n\
                    angle_rad = [[-0.5, 0.5], [-1.3, 1.3]]\nspeed_rad_s = [1.0, 1.0]\n\
                    [stop]\nafter_s = 3\n";
        let file = std::path::Path::new("wide.toml");
        let load = |text: &str| Scenario::parse(file, text, &Overrides::default());
        let refused = load(text).unwrap_err().to_string();
        assert!(refused.contains("would be braked"), "{refused}");
        let narrowed = load(&format!("narrow = true\n{text}")).unwrap();
        let [first, second] = edges_rad(&narrowed);
        assert!(
            (first - 0.5).abs() < 1e-6 && (1.1..1.3).contains(&second),
            "{second}"
        );
    }
}
