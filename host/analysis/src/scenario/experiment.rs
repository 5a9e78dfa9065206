//! Places of mistakes in an experiment.

use armbridge_client::experiment_text;
use armbridge_link::experiment::{Measure, Objection};

use super::mistake::{KeyPath, Mistake};

/// Converts the board's objection to a mistake at the key that it concerns.
pub(super) fn mistake(at: &KeyPath, objection: Objection) -> Mistake {
    let joint_key = |key: &str, joint: u8| at.at(key).nth(joint.into());
    let place = match objection {
        Objection::Duration { .. } => at.at("duration_s"),
        Objection::Envelope { joint }
        | Objection::Edge { joint, .. }
        | Objection::Outside { joint, .. } => joint_key("angle_rad", joint),
        Objection::Moving { joint, .. }
        | Objection::Beyond {
            joint,
            measure: Measure::Speed,
            ..
        } => joint_key("speed_rad_s", joint),
        Objection::Signal { joint, .. }
        | Objection::Rough { joint }
        | Objection::Beyond { joint, .. } => joint_key("roles", joint),
    };
    Mistake::new(place, experiment_text::objection(objection))
}
