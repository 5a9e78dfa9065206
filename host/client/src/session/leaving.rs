//! End of a session: the arm is parked or disarmed, then a goodbye is sent.
//!
//! | state       | ends by                                      | then      |
//! |-------------|----------------------------------------------|-----------|
//! | `Disarming` | the board's answer, or its timeout           | `Parking` if the board parks the arm, else `Goodbye` |
//! | `Parking`   | a record of motors that are off, or its timeout | `Goodbye` |
//! | `Goodbye`   | the goodbye being sent                       | `Gone`    |
//!
//! A connection that breaks ends it: the board switches off when its host is silent.

use super::{LEAVE_TIMEOUT_US, PARK_TIMEOUT_US};

/// Progress of the end of a session.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) enum Leaving {
    #[default]
    No,
    /// The board is asked to park the arm, or to disarm; with the timeout.
    Disarming(u64),
    /// The board parks the arm; with the timeout.
    Parking(u64),
    /// The goodbye is the next message.
    Goodbye,
    /// The goodbye has been sent.
    Gone,
}

impl Leaving {
    /// The board is asked to park the arm, or to disarm.
    pub(super) fn begin(now_us: u64) -> Self {
        Self::Disarming(now_us + LEAVE_TIMEOUT_US)
    }

    /// Ends what has taken too long. Returns whether the goodbye is to be sent now.
    pub(super) fn advance(&mut self, now_us: u64) -> bool {
        if let Self::Disarming(until_us) | Self::Parking(until_us) = *self
            && now_us >= until_us
        {
            *self = Self::Goodbye;
        }
        let says_goodbye = *self == Self::Goodbye;
        if says_goodbye {
            *self = Self::Gone;
        }
        says_goodbye
    }

    /// The board has answered, and parks the arm or does not.
    pub(super) fn answered(&mut self, now_us: u64, parks: bool) {
        if let Self::Disarming(_) = self {
            *self = if parks {
                Self::Parking(now_us + PARK_TIMEOUT_US)
            } else {
                Self::Goodbye
            };
        }
    }

    /// The motors are off.
    pub(super) fn switched_off(&mut self) {
        if let Self::Parking(_) = self {
            *self = Self::Goodbye;
        }
    }

    /// The connection broke, by which no goodbye can be sent.
    pub(super) fn disconnected(&mut self) {
        if *self != Self::No {
            *self = Self::Gone;
        }
    }

    /// Time of the next call of [`advance`](Self::advance).
    pub(super) fn wake_at_us(self) -> u64 {
        match self {
            Self::No => u64::MAX,
            Self::Disarming(until_us) | Self::Parking(until_us) => until_us,
            Self::Goodbye | Self::Gone => 0,
        }
    }
}
