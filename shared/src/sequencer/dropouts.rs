//! Dropouts: how many samples of each joint are missing in a row, and may be.

use crate::JOINTS;

/// Samples missing in a row, as the monitors count them.
#[derive(Clone, Copy, Debug, Default)]
pub struct Dropouts {
    /// Joint by joint.
    pub in_row: [u32; JOINTS],
    /// How many may be.
    pub allowed: u32,
}
