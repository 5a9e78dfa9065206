//! A model of the X series in a file, by its name.

use armbridge_servo::protocol2::model::{MODELS, Model};
use serde::de::Error;
use serde::{Deserialize, Deserializer, Serialize, Serializer};

#[expect(
    clippy::trivially_copy_pass_by_ref,
    reason = "serde hands over a reference"
)]
pub(super) fn serialize<S: Serializer>(
    model: &&'static Model,
    serializer: S,
) -> Result<S::Ok, S::Error> {
    model.name.serialize(serializer)
}

pub(super) fn deserialize<'de, D: Deserializer<'de>>(
    deserializer: D,
) -> Result<&'static Model, D::Error> {
    let name = String::deserialize(deserializer)?;
    let model = MODELS.iter().find(|model| model.name == name);
    model.ok_or_else(|| D::Error::custom("not a model of the X series"))
}
