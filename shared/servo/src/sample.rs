//! Position samples: one per servo and tick, or the reason why there is none.
//!
//! A missing sample is never a number. Both types are part of the link's telemetry
//! (`armbridge_link::message` re-exports them), so their names, variants and order are wire
//! format: the link's schema hash covers them.

#[cfg(feature = "postcard")]
use postcard::experimental::max_size::MaxSize;
#[cfg(feature = "postcard")]
use postcard_schema::Schema;
#[cfg(feature = "postcard")]
use serde::{Deserialize, Serialize};

/// A servo's answer to the request for its position.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "postcard", derive(Serialize, Deserialize, Schema, MaxSize))]
pub enum Sample {
    /// Position in encoder counts, 0..=1023.
    Counts(u16),
    /// No usable answer, and the reason.
    Missing(Missing),
}

impl Sample {
    /// The position, if there is one.
    pub fn counts(self) -> Option<u16> {
        match self {
            Self::Counts(counts) => Some(counts),
            Self::Missing(_) => None,
        }
    }

    /// The reason, if there is no position.
    pub fn missing(self) -> Option<Missing> {
        match self {
            Self::Counts(_) => None,
            Self::Missing(missing) => Some(missing),
        }
    }

    /// The same for a servo that was asked: an arm with fewer joints has no other.
    pub fn lost(self) -> Option<Missing> {
        self.missing()
            .filter(|missing| *missing != Missing::NotAsked)
    }
}

/// Reason for a missing position.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "postcard", derive(Serialize, Deserialize, Schema, MaxSize))]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Missing {
    /// The servo was not asked: the arm has no such joint, or no exchange has begun.
    NotAsked,
    /// No byte was received.
    Silence,
    /// Only the echo of the request was received.
    EchoOnly,
    /// A reply with a wrong checksum.
    BadChecksum,
    /// A reply from another servo.
    WrongId,
    /// A reply ended early.
    Short,
    /// The receiver reported framing, noise or overrun.
    Line,
}
