//! Time of a request between two ticks, and the status of a tick under way.

use armbridge_link::record::{Permission, Violation};

/// Time at which a request is taken, between two ticks.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Instant {
    /// Present time, in µs.
    pub us: u64,
    /// Time in µs at which the next command acts: the planned beginning of the next tick.
    pub acts_us: u64,
    /// Whether motors have been driven until now.
    pub is_driven: bool,
}

/// Permission and first fault of the tick so far.
pub(super) struct TickStatus {
    pub(super) permission: Permission,
    pub(super) fault: Option<Violation>,
}

impl TickStatus {
    pub(super) fn new(permission: Permission) -> Self {
        Self {
            permission,
            fault: None,
        }
    }

    pub(super) fn is_armed(&self) -> bool {
        self.permission.is_armed()
    }

    /// Whether a motor may be on in the next tick.
    pub(super) fn drives_motors(&self) -> bool {
        self.permission.drives_motors()
    }

    /// Whether the source of the drive command, or the park, may drive the motors.
    pub(super) fn is_drive_permitted(&self) -> bool {
        self.permission.is_driven()
    }

    /// Switches motors off; the first cause is kept, because later ones often follow from it.
    pub(super) fn trip(&mut self, violation: Violation) {
        self.fault.get_or_insert(violation);
        if self.permission != Permission::Search {
            self.permission = Permission::Off;
        }
    }

    /// Switches motors off if this check failed.
    pub(super) fn require(&mut self, check: Result<(), Violation>) {
        if let Err(violation) = check {
            self.trip(violation);
        }
    }
}
