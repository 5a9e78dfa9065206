//! One joint of a plant file.

use armbridge_control::actuator::{Direction, Joint};
use serde::{Deserialize, Serialize};

use crate::plant::{Friction, PlantConfig};

/// Its keys, as [`KEYS`](super::KEYS) explains them.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub(super) struct JointKeys {
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) initial_rad: Option<f64>,
    pub(super) initial_rad_s: f64,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) stops_rad: Option<[f64; 2]>,
    pub(super) coulomb_nm: f64,
    pub(super) static_nm: f64,
    pub(super) stribeck_rad_s: f64,
    pub(super) friction_load: f64,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) dead_zone_counts: Option<[u16; 2]>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) input_delay_us: Option<u32>,
    #[serde(with = "DirectionName")]
    pub(super) direction: Direction,
    pub(super) zero_count: f64,
    pub(super) rad_per_count: f64,
    pub(super) gain_counts_per_nm: f64,
    pub(super) offset_counts: f64,
}

#[derive(Serialize, Deserialize)]
#[serde(remote = "Direction", rename_all = "lowercase")]
enum DirectionName {
    Forward,
    Reverse,
}

impl Default for JointKeys {
    /// The joints differ in their stops, which are not given.
    fn default() -> Self {
        Self {
            initial_rad: None,
            stops_rad: None,
            dead_zone_counts: None,
            input_delay_us: None,
            ..Self::from_config(&PlantConfig::default(), 0)
        }
    }
}

impl JointKeys {
    pub(super) fn from_config(config: &PlantConfig, joint: usize) -> Self {
        let Joint {
            zero_count,
            rad_per_count,
            direction,
            gain_counts_per_nm,
            offset_counts,
        } = config.joints[joint];
        let Friction {
            coulomb_nm,
            static_nm,
            stribeck_rad_s,
            load,
        } = config.friction[joint];
        Self {
            initial_rad: Some(config.initial.q[joint]),
            initial_rad_s: config.initial.dq[joint],
            stops_rad: Some(config.stops_rad[joint]),
            coulomb_nm,
            static_nm,
            stribeck_rad_s,
            friction_load: load,
            dead_zone_counts: Some(config.dead_zone_counts[joint]),
            input_delay_us: Some((config.input_delay_ns[joint] / 1_000) as u32),
            direction,
            zero_count,
            rad_per_count,
            gain_counts_per_nm,
            offset_counts,
        }
    }

    pub(super) fn servo(&self) -> Joint<f64> {
        Joint {
            zero_count: self.zero_count,
            rad_per_count: self.rad_per_count,
            direction: self.direction,
            gain_counts_per_nm: self.gain_counts_per_nm,
            offset_counts: self.offset_counts,
        }
    }

    pub(super) fn friction(&self) -> Friction {
        Friction {
            coulomb_nm: self.coulomb_nm,
            static_nm: self.static_nm,
            stribeck_rad_s: self.stribeck_rad_s,
            load: self.friction_load,
        }
    }
}
