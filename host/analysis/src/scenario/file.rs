//! Keys of a scenario file.

use armbridge_link::experiment::Experiment;
use armbridge_servo::JOINTS;
use armbridge_sim::plant::PlantFile;
use serde::Deserialize;
use toml::Table;

use crate::plan_runner::plan::Base;

/// Top level of a file.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct File {
    pub(super) title: String,
    #[serde(default)]
    pub(super) about: String,
    #[serde(default)]
    pub(super) control: Control,
    /// Control of a second run on the same simulated arm, for comparison.
    pub(super) baseline: Option<Control>,
    /// Parameters by name, set before the arm is armed.
    #[serde(default)]
    pub(super) set: Table,
    #[serde(default)]
    pub(super) bench: BenchKeys,
    /// Whether the steps' angles are scaled down to what the board permits.
    #[serde(default, rename = "narrow")]
    pub(super) is_narrowed: bool,
    #[serde(default)]
    pub(super) step: Vec<StepKeys>,
    pub(super) stop: StopKeys,
    #[serde(default)]
    pub(super) expect: Expect,
}

/// Control settings before those set by name.
#[derive(Clone, Copy, Debug, Default, Deserialize)]
#[serde(rename_all = "lowercase")]
pub(super) enum Control {
    #[default]
    Board,
    Paper,
    Compensated,
}

impl From<Control> for Base {
    fn from(control: Control) -> Self {
        match control {
            Control::Board => Self::Board,
            Control::Paper => Self::Paper,
            Control::Compensated => Self::Compensated,
        }
    }
}

/// The virtual arm.
#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub(super) struct BenchKeys {
    pub(super) seed: Option<u64>,
    pub(super) initial_rad: Option<[f64; JOINTS]>,
    pub(super) friction: Option<bool>,
    /// File in the scenario's folder.
    pub(super) plant_file: Option<String>,
    pub(super) plant: Option<PlantFile>,
    pub(super) servos: Option<[ServoName; JOINTS]>,
    pub(super) baud: Option<u32>,
    pub(super) push: Vec<PushKeys>,
    pub(super) hand: Vec<HandKeys>,
}

/// A servo's firmware.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(rename_all = "lowercase")]
pub(super) enum ServoName {
    Morpheus,
    Stock,
    X,
}

/// A push on the virtual arm.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct PushKeys {
    pub(super) at_s: f64,
    pub(super) every_s: Option<f64>,
    pub(super) joint: usize,
    pub(super) torque_nm: f64,
    pub(super) duration_s: f64,
}

/// A hand that leads the virtual arm.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct HandKeys {
    pub(super) at_s: f64,
    pub(super) every_s: Option<f64>,
    /// Counting from 1.
    pub(super) link: Option<usize>,
    pub(super) path: Vec<HandPointKeys>,
    pub(super) release_s: Option<f64>,
    pub(super) stiffness_n_m: Option<f64>,
    pub(super) damping_n_s_m: Option<f64>,
}

/// A point of a hand's path.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct HandPointKeys {
    pub(super) after_s: f64,
    pub(super) angle_rad: [f64; JOINTS],
}

/// A step: a time and one action.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct StepKeys {
    pub(super) at_s: f64,
    pub(super) every_s: Option<f64>,
    pub(super) regulate_rad: Option<Pair>,
    pub(super) torque_nm: Option<Pair>,
    pub(super) minimum_jerk: Option<MinimumJerkKeys>,
    pub(super) waypoints: Option<Vec<ViaKeys>>,
    pub(super) sinusoid: Option<SinusoidKeys>,
    pub(super) chirp: Option<ChirpKeys>,
    pub(super) stream: Option<Vec<ViaKeys>>,
    pub(super) experiment: Option<Experiment>,
    pub(super) float: Option<bool>,
    pub(super) set: Option<Table>,
    pub(super) park: Option<bool>,
    pub(super) idle: Option<bool>,
    pub(super) arm: Option<bool>,
    /// Of a joint that the arm does not have.
    #[serde(skip)]
    pub(super) is_left_out: bool,
}

/// One number for each joint.
pub(super) type Pair = [f32; JOINTS];

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct MinimumJerkKeys {
    pub(super) to_rad: Pair,
    pub(super) duration_s: Option<f32>,
}

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct ViaKeys {
    pub(super) after_s: f64,
    pub(super) angle_rad: Pair,
    pub(super) speed_rad_s: Option<Pair>,
}

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct SinusoidKeys {
    #[serde(default)]
    pub(super) centre_rad: Pair,
    pub(super) amplitude_rad: Pair,
    pub(super) frequency_hz: Pair,
    #[serde(default)]
    pub(super) phase_rad: Pair,
    pub(super) ramp_s: f32,
    pub(super) duration_s: f32,
}

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct ChirpKeys {
    #[serde(default)]
    pub(super) centre_rad: Pair,
    pub(super) amplitude_rad: Pair,
    pub(super) from_hz: Pair,
    pub(super) to_hz: Pair,
    pub(super) ramp_s: f32,
    pub(super) duration_s: f32,
}

/// Stop conditions.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct StopKeys {
    pub(super) after_s: f64,
    pub(super) angle_beyond_rad: Option<Pair>,
    pub(super) error_beyond_rad: Option<Pair>,
    #[serde(default)]
    pub(super) error_for_s: f64,
    /// Ends that count as success; all others are failures.
    pub(super) success: Option<Vec<String>>,
}

/// Name of the end of an experiment.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum EndName {
    /// Its duration elapsed.
    Finished,
    /// A joint left the envelope.
    Angle,
    /// A joint was faster than the envelope allows.
    Speed,
}

/// Expectations of the arm; a run that misses one has failed.
#[derive(Clone, Copy, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Expect {
    /// After this time both joints stay within 20 mrad of each setpoint until it changes.
    pub settles_within_s: Option<f64>,
    /// Mean error of either joint over the last 0.5 s at every setpoint.
    pub rests_within_rad: Option<f64>,
    /// Rms error of either joint while the reference moves.
    pub tracks_within_rad: Option<f64>,
    /// After every push, both joints are within 20 mrad of the reference for good, or
    /// until the next push.
    pub recovers_within_s: Option<f64>,
    /// After every hand has let go, both joints stay within this of where it left them, until the
    /// next hand, or for as long as the arm floats.
    pub stays_within_rad: Option<f64>,
    /// Time from the beginning of every park, of which there is at least one, to motors off
    /// without a fault.
    pub parks_within_s: Option<f64>,
    /// Largest torque of either joint.
    pub torque_within_nm: Option<f64>,
    /// End of every experiment, of which there is at least one.
    pub experiments_end: Option<EndName>,
}
