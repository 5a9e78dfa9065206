//! Park: the board's own motion to the pose of
//! [`park`](armbridge_link::limits::Limits::park), and the lowering of the arm there.
//!
//! ```text
//! brake --at rest--> move to the pose --at rest--> lower joint 0 --rests--> lower joint 1 --rests--> off
//!                         '-- from beyond the bounds of a motion --^
//! ```
//!
//! | phase | reference                          | torque                                        |
//! |-------|------------------------------------|-----------------------------------------------|
//! | brake | to rest within the bounds of a motion | of the controller                          |
//! | move  | rest to rest, at [`MOVE_RAD_S`] at most | of the controller                        |
//! | lower | down with gravity at 0.16 rad/s | of the controller, but never with gravity, of the joints that are lowered or have been |
//!
//! A joint rests when it has stood for 0.15 s without torque: friction, a stop or the table
//! carries it, or it hangs. The second joint is held until the first one rests, for its gravity
//! depends on the first. The motor of a lowered joint only carries it, so it may pass its angle
//! limit down to the table or a stop, and neither soft stop, stall nor external torque are
//! monitored; its innovation is.
//!
//! It ends after [`PARK_US`] at the latest. The host's silence does not end it; any fault does.

use super::config::LoopConfig;
use super::control_loop::ControlLoop;
use super::estimation::Estimated;
use super::limits::PARK_US;
use super::lowering::{Lowering, Rest};
use super::reference::ReferenceSource;
use armbridge_control::trajectory::Reference;
use armbridge_control::trajectory::stream::Point;
use armbridge_link::message::Drive;
use armbridge_link::record::Fallback;
use armbridge_servo::JOINTS;
use nalgebra::Vector2;

/// Speed in rad/s of the motion to the pose: a fifth of what a motion may have.
const MOVE_RAD_S: f32 = 0.8;
/// Peak speed of a quintic from rest to rest, as a multiple of its mean.
const QUINTIC_PEAK: f32 = 1.875;
/// Shortest duration in s of the motion to the pose.
const MOVE_MIN_S: f32 = 0.3;
/// Distance in rad at which the arm is in the pose: two encoder counts.
const POSE_RAD: f32 = 0.01;

impl ControlLoop {
    /// Begins to park the arm: brakes it, without a step in the torque.
    fn begin_park(&mut self, config: &LoopConfig, acts_us: u64) {
        let from = match self.drive() {
            Drive::Torque | Drive::Float => Some(Reference {
                q: self.state.q,
                dq: self.state.dq,
                ddq: Vector2::zeros(),
            }),
            Drive::Experiment => Some(Reference {
                ddq: Vector2::zeros(),
                ..self.reference
            }),
            Drive::Regulate | Drive::Track | Drive::Hold | Drive::Park => None,
        };
        self.source.command = self.source.command.continued(Drive::Park, acts_us);
        self.source.rest = None;
        match from {
            Some(from) => {
                let source = ReferenceSource::braking(&from, acts_us);
                self.source.reference.replace(&source);
                let reference = self.source.reference.at(acts_us);
                self.fade_from(config, self.command.total_nm(), &reference);
            }
            None => self.source.reference.brake(acts_us),
        }
    }

    /// Begins the park, or advances it; its next reference is that at `acts_us`. Returns its end.
    #[inline(never)]
    pub(super) fn advance_park(
        &mut self,
        config: &LoopConfig,
        estimated: &Estimated,
        acts_us: u64,
    ) -> Option<Fallback> {
        if self.drive() != Drive::Park {
            self.begin_park(config, acts_us);
        }
        if self.source.command.age_us(acts_us) > PARK_US {
            return Some(Fallback::Parked);
        }
        let Some(joint) = self.source.reference.lowered_joint() else {
            if self.source.reference.is_at_rest(acts_us) {
                self.leave_rest(config, estimated, acts_us);
            }
            return None;
        };
        let (torque_nm, angle_rad) = (self.command.total_nm()[joint], estimated.state.q[joint]);
        let noise_rad2 = self.monitors.noise_rad2(&config.control.joints)[joint];
        let before = self.source.rest;
        self.source.rest = Rest::next(before, torque_nm, angle_rad, noise_rad2, acts_us);
        if !self.source.rest.is_some_and(|rest| rest.is_long(acts_us)) {
            return None;
        }
        if joint + 1 >= config.joints().min(JOINTS) {
            return Some(Fallback::Parked);
        }
        self.lower(joint + 1, estimated, acts_us);
        None
    }

    /// The reference is at rest: begins the motion to the pose or, in it, to lower the arm.
    fn leave_rest(&mut self, config: &LoopConfig, estimated: &Estimated, acts_us: u64) {
        let here = self.source.reference.at(acts_us).q;
        let mut pose = config.limits().park_rad().map_or(here, Vector2::from);
        if config.joints() < JOINTS {
            pose.y = here.y;
        }
        let distance_rad = (pose - here).amax();
        let is_moving = distance_rad > POSE_RAD && {
            let move_s = (QUINTIC_PEAK * distance_rad / MOVE_RAD_S).max(MOVE_MIN_S);
            let point = Point {
                at_us: acts_us + (move_s * 1e6) as u64,
                q: pose,
                dq: Some(Vector2::zeros()),
            };
            self.source.reference.push(acts_us, point).is_ok()
        };
        if !is_moving {
            self.lower(0, estimated, acts_us);
        }
    }

    /// Begins to lower this joint, in the direction of its gravity.
    fn lower(&mut self, joint: usize, estimated: &Estimated, acts_us: u64) {
        let from = self.source.reference.at(acts_us).q;
        let lowering = Lowering::new(from, joint, estimated.gravity_nm[joint], acts_us);
        let source = ReferenceSource::lowering(lowering);
        self.source.reference.replace(&source);
        self.source.rest = None;
    }
}
