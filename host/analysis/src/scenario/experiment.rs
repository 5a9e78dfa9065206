//! Where in a step an experiment is wrong.

use armbridge_client::experiment_text;
use armbridge_shared::link::experiment::{Measure, Objection};

use super::location::{Place, Wrong};

/// What the board would object to, at the key of the step that it is about.
pub(super) fn wrong(at: &Place, objection: Objection) -> Wrong {
    let of = |key: &str, joint: u8| at.at(key).nth(joint.into());
    let place = match objection {
        Objection::Duration { .. } => at.at("duration_s"),
        Objection::Envelope { joint }
        | Objection::Edge { joint, .. }
        | Objection::Outside { joint, .. } => of("angle_rad", joint),
        Objection::Moving { joint, .. }
        | Objection::Beyond {
            joint,
            measure: Measure::Speed,
            ..
        } => of("speed_rad_s", joint),
        Objection::Signal { joint, .. }
        | Objection::Rough { joint }
        | Objection::Beyond { joint, .. } => of("roles", joint),
    };
    Wrong::new(place, experiment_text::objection(objection))
}
