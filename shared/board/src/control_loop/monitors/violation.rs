//! Violation: the finding of a monitor, with the value seen and the limit.

use armbridge_link::mode::Fault;

/// Fault found by a monitor, with its magnitude.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Violation {
    /// Fault.
    pub fault: Fault,
    /// Joint, counting from 0, if the fault concerns one.
    pub joint: Option<u8>,
    /// Observed value, in the unit of the limit.
    pub value: f32,
    /// Limit.
    pub limit: f32,
}

impl Violation {
    /// A violation without joint and values.
    pub const fn plain(fault: Fault) -> Self {
        Self {
            fault,
            joint: None,
            value: 0.0,
            limit: 0.0,
        }
    }
}
