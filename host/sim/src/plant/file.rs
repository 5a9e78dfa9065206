//! A virtual arm described in a file, `host/plants/default.toml` and its like.
//!
//! Every field of [`PlantConfig`] is a key of [`KEYS`], which has its range and meaning. A
//! missing key has its default. Errors are one line with file, line and column.

mod builtin;
mod joint;
mod keys;
#[cfg(test)]
mod tests;
mod x_servo;

pub use builtin::{BuiltinPlant, PLANTS};
pub use keys::KEYS;

use std::path::Path;

use armbridge_client::toml_file::{Document, DocumentError};
use armbridge_client::{params, toml_file};
use armbridge_control::arm::{Mounting, Parameters, State};
use armbridge_servo::JOINTS;
use armbridge_servo::protocol2::model::Model;
use nalgebra::Vector2;
use serde::{Deserialize, Serialize};

use self::joint::JointKeys;
use super::PlantConfig;

/// Angles in rad at which a simulated arm is held until a motor drives it, unless others are given.
pub const INITIAL_RAD: [f64; JOINTS] = [0.30, -0.25];

/// An arm as in a file, with the keys of [`KEYS`].
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct PlantFile {
    friction: bool,
    /// The paper's dead zone, or none, for both joints.
    #[serde(skip_serializing_if = "Option::is_none")]
    dead_zone: Option<bool>,
    held: bool,
    inertia_scale: f64,
    gravity_scale: f64,
    torque_gain: f64,
    pwm_offset_counts: f64,
    torque_limit_nm: f64,
    #[serde(with = "x_servo")]
    x_servo: &'static Model,
    /// Delay of both joints.
    #[serde(skip_serializing_if = "Option::is_none")]
    input_delay_us: Option<u32>,
    noise_lsb_rms: f64,
    #[serde(with = "ArmKeys")]
    arm: Parameters<f64>,
    joint1: JointKeys,
    joint2: JointKeys,
}

/// Failure to load a virtual arm.
#[derive(Debug, thiserror::Error)]
pub enum PlantError {
    /// There is neither a file nor a virtual arm that ships with this name.
    #[error(
        "there is no virtual arm `{name}`{}: `armbridge plants` lists those that ship; name a \
         file of your own by its path",
        nearest.map_or_else(String::new, |name| format!("; is it `{name}`?"))
    )]
    Unknown {
        /// Requested name.
        name: String,
        /// The nearest name of one that ships.
        nearest: Option<&'static str>,
    },
    /// The file cannot be read or contains a mistake.
    #[error(transparent)]
    File(#[from] DocumentError),
}

/// Keys of a file that contradict each other.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct KeyConflict {
    /// The key to change.
    pub key: String,
    /// Description of the conflict.
    pub message: String,
}

/// Keys of [`Parameters`].
#[derive(Serialize, Deserialize)]
#[serde(
    remote = "Parameters<f64>",
    deny_unknown_fields,
    default = "Parameters::paper"
)]
struct ArmKeys {
    l1: f64,
    l2: f64,
    m1: f64,
    m2: f64,
    g: f64,
    i1x: f64,
    i1y: f64,
    i1z: f64,
    i2x: f64,
    i2y: f64,
    i2z: f64,
    b1: f64,
    b2: f64,
    #[serde(with = "MountingName")]
    mounting: Mounting,
}

#[derive(Serialize, Deserialize)]
#[serde(remote = "Mounting", rename_all = "lowercase")]
enum MountingName {
    Upright,
    Hanging,
}

impl Default for PlantFile {
    /// [`PlantConfig::default`]; without keys whose default depends on other keys, such
    /// as the initial position.
    fn default() -> Self {
        let config = PlantConfig::default();
        let joint = |joint| JointKeys {
            stops_rad: Some(config.stops_rad[joint]),
            ..JointKeys::default()
        };
        Self {
            joint1: joint(0),
            joint2: joint(1),
            ..Self::from_config(&config)
        }
    }
}

impl PlantFile {
    /// Reads a file.
    ///
    /// # Errors
    ///
    /// See [`DocumentError`].
    pub fn read(path: &Path) -> Result<Self, DocumentError> {
        let text = toml_file::read_file(path, toml_file::TEXT_MAX)?;
        if text
            .parse::<toml::Table>()
            .is_ok_and(|keys| keys.is_empty())
        {
            let message = "sets no key, as `armbridge plants --explain` lists them; the paper's \
                           arm needs no file";
            return Err(DocumentError::Wrong {
                place: toml_file::Place::from_offset(path, &text, 0),
                message: message.into(),
            });
        }
        Self::parse(path, text)
    }

    /// Reads the file with this path, or the virtual arm that ships with this name.
    ///
    /// # Errors
    /// If there is neither, or the file has a mistake.
    pub fn load(name: &str) -> Result<Self, PlantError> {
        let path = Path::new(name);
        let is_path = path
            .extension()
            .is_some_and(|extension| extension == "toml")
            || path.components().count() > 1;
        match BuiltinPlant::find(name) {
            Some(plant) if !is_path => Ok(Self::parse(&plant.file(), plant.text.into())?),
            None if !is_path && !path.exists() => Err(PlantError::Unknown {
                name: name.into(),
                nearest: params::nearest(name, PLANTS.iter().map(|plant| plant.name)),
            }),
            Some(_) | None => Ok(Self::read(path)?),
        }
    }

    /// Parses a text as the contents of this file.
    fn parse(path: &Path, text: String) -> Result<Self, DocumentError> {
        let wrong = |at: usize, message| DocumentError::Wrong {
            place: toml_file::Place::from_offset(path, &text, at),
            message,
        };
        toml_file::keys::check(&text, &[KEYS])
            .map_err(|error| wrong(error.at.start, error.message))?;
        let file: Self =
            toml::from_str(&text).map_err(|error| toml_file::not_toml(path, &text, &error))?;
        match file.conflict() {
            Some(KeyConflict { key, message }) => {
                Err(Document::parse(path, text)?.wrong_key(&key, message))
            }
            None => Ok(file),
        }
    }

    /// Conflict of a key for both joints with the same key of one joint, or of two stops.
    pub fn conflict(&self) -> Option<KeyConflict> {
        let conflict_of =
            |key: &str, is_set: bool, [is_set_1, is_set_2]: [bool; JOINTS], own: &str| {
                (is_set && (is_set_1 || is_set_2)).then(|| KeyConflict {
                    key: String::from(key),
                    message: format!(
                        "`{key}` is that of both joints, and `joint{}.{own}` repeats it; keep \
                     one of the two",
                        if is_set_1 { 1 } else { 2 },
                    ),
                })
            };
        let joints = [&self.joint1, &self.joint2];
        let has_zone = joints.map(|joint| joint.dead_zone_counts.is_some());
        let has_delay = joints.map(|joint| joint.input_delay_us.is_some());
        let (zone, delay) = (self.dead_zone.is_some(), self.input_delay_us.is_some());
        let is_crossed = |joint: &&JointKeys| joint.stops_rad.is_some_and(|[a, b]| a >= b);
        let crossed = joints.iter().position(is_crossed);
        let crossed = crossed.map(|joint| KeyConflict {
            key: format!("joint{}.stops_rad", joint + 1),
            message: "`stops_rad` is the smallest angle, then the largest".into(),
        });
        conflict_of("dead_zone", zone, has_zone, "dead_zone_counts")
            .or_else(|| conflict_of("input_delay_us", delay, has_delay, "input_delay_us"))
            .or(crossed)
    }

    /// All keys of a file for this arm.
    pub fn from_config(config: &PlantConfig) -> Self {
        Self {
            friction: config.friction_on,
            dead_zone: None,
            held: config.held,
            inertia_scale: config.inertia_scale,
            gravity_scale: config.gravity_scale,
            torque_gain: config.torque_gain,
            pwm_offset_counts: config.pwm_offset_counts,
            torque_limit_nm: config.torque_limit_nm,
            x_servo: config.x_servo,
            input_delay_us: None,
            noise_lsb_rms: config.noise_lsb_rms,
            arm: config.arm,
            joint1: JointKeys::from_config(config, 0),
            joint2: JointKeys::from_config(config, 1),
        }
    }

    /// The same without a position: it is where a scenario has it.
    #[must_use]
    pub fn without_position(mut self) -> Self {
        for joint in [&mut self.joint1, &mut self.joint2] {
            (joint.initial_rad, joint.initial_rad_s) = (None, 0.0);
        }
        self
    }

    /// The arm of a file, or of a plant that ships; without a name the default one. It is at
    /// `initial_rad`, else where the file has it, else at [`INITIAL_RAD`].
    ///
    /// # Errors
    /// As [`load`](Self::load).
    pub fn arm(
        name: Option<&str>,
        initial_rad: Option<[f64; JOINTS]>,
    ) -> Result<PlantConfig, PlantError> {
        let mut arm = match name {
            Some(name) => Self::load(name)?.config(INITIAL_RAD),
            None => PlantConfig {
                initial: State::at_rest(INITIAL_RAD.into()),
                ..PlantConfig::default()
            },
        };
        if let Some(initial_rad) = initial_rad {
            arm.initial.q = initial_rad.into();
        }
        Ok(arm)
    }

    /// The arm. It is at `initial_rad` unless the file has a position.
    pub fn config(&self, initial_rad: [f64; JOINTS]) -> PlantConfig {
        let keys = [&self.joint1, &self.joint2];
        let default = PlantConfig::default();
        let dead_zone = if self.dead_zone == Some(true) {
            PlantConfig::PAPER_DEAD_ZONE_COUNTS
        } else {
            [0; 2]
        };
        PlantConfig {
            arm: self.arm,
            inertia_scale: self.inertia_scale,
            gravity_scale: self.gravity_scale,
            joints: keys.map(JointKeys::servo),
            friction_on: self.friction,
            friction: keys.map(JointKeys::friction),
            dead_zone_counts: keys.map(|joint| joint.dead_zone_counts.unwrap_or(dead_zone)),
            input_delay_ns: keys.map(|joint| {
                let delay_us = joint.input_delay_us.or(self.input_delay_us);
                u64::from(delay_us.unwrap_or(0)) * 1_000
            }),
            torque_gain: self.torque_gain,
            pwm_offset_counts: self.pwm_offset_counts,
            torque_limit_nm: self.torque_limit_nm,
            x_servo: self.x_servo,
            stops_rad: [0, 1].map(|j| keys[j].stops_rad.unwrap_or(default.stops_rad[j])),
            noise_lsb_rms: self.noise_lsb_rms,
            initial: State {
                q: Vector2::from_fn(|j, _| keys[j].initial_rad.unwrap_or(initial_rad[j])),
                dq: Vector2::from_fn(|j, _| keys[j].initial_rad_s),
            },
            held: self.held,
        }
    }
}
