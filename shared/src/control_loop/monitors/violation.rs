//! Violation: the finding of a monitor, with the value seen and the limit.

use crate::link::mode::Fault;

/// What is wrong, and by how much.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Violation {
    /// What.
    pub fault: Fault,
    /// Which joint, counting from 0, if it is one.
    pub joint: Option<u8>,
    /// What was seen, in the unit of the limit.
    pub value: f32,
    /// What would have been allowed.
    pub limit: f32,
}

impl Violation {
    /// Of no joint, and without numbers.
    pub const fn plain(fault: Fault) -> Self {
        Self {
            fault,
            joint: None,
            value: 0.0,
            limit: 0.0,
        }
    }
}
