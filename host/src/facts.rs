//! What one has to know about a run to read its records.
//!
//! Known before the first tick and constant from then on. Written into the
//! MCAP file as metadata, into plot titles and into the summary.

use armbridge_shared::JOINTS;
use armbridge_shared::link::message::Setup;
use serde::Serialize;

/// PWM value at which a servo is off; the register runs from 0 to
/// [`PWM_MAX`] and turns the other way below this.
pub const PWM_OFF: u16 = 1000;

/// Largest PWM value a servo takes.
pub const PWM_MAX: u16 = 2000;

/// Facts of one run.
#[derive(Clone, Debug, Serialize)]
pub struct RunFacts {
    /// Command that made the run: `demo`, `emulate`.
    pub name: String,
    /// Where control code and arm are: `simulated: bench`.
    pub world: String,
    /// Version of this program.
    pub version: String,
    /// Seed of everything random; none where nothing repeats.
    pub seed: Option<u64>,
    /// Tick period in µs.
    pub period_us: u32,
    /// Set-up of the bridge.
    pub setup: Setup,
    /// Joint angle per encoder count in rad, negative where a servo is
    /// mounted the other way round.
    pub rad_per_count: [f64; JOINTS],
    /// Encoder count at joint angle zero.
    pub zero_count: [f64; JOINTS],
    /// Lowest and highest torque in N m that each servo can be told.
    pub torque_limits_nm: [[f64; 2]; JOINTS],
    /// Static friction of each joint in N m where it is simulated.
    pub static_friction_nm: Option<[f64; JOINTS]>,
    /// Largest angle in mrad by which that friction can hold each joint away
    /// from its setpoint: friction divided by the net stiffness of the loop.
    pub stiction_offset_mrad: Option<[f64; JOINTS]>,
}

impl RunFacts {
    /// Joint angle in rad that an encoder count stands for.
    pub fn angle_rad(&self, joint: usize, count: u16) -> f64 {
        (f64::from(count) - self.zero_count[joint]) * self.rad_per_count[joint]
    }

    /// World, seed and period, for titles.
    pub fn describe(&self) -> String {
        let seed = self
            .seed
            .map_or_else(String::new, |seed| format!(" · seed {seed}"));
        format!("{}{seed} · period {} µs", self.world, self.period_us)
    }

    /// Size of one encoder count of a joint in mrad.
    pub fn count_mrad(&self, joint: usize) -> f64 {
        self.rad_per_count[joint].abs() * 1e3
    }
}
