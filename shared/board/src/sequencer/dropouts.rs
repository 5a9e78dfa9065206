//! Dropouts: consecutive missing samples of each joint, and the limit.

use armbridge_servo::JOINTS;

/// Consecutive missing samples, as counted by the monitors.
#[derive(Clone, Copy, Debug, Default)]
pub struct Dropouts {
    /// Count for each joint.
    pub in_row: [u32; JOINTS],
    /// Largest count without a fault.
    pub allowed: u32,
}
