//! Which program runs on a servo, and so which protocol it speaks.

use postcard::experimental::max_size::MaxSize;
use postcard_schema::Schema;
use serde::{Deserialize, Serialize};

/// What runs on a servo. All servos of a bus must run the same.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize, Schema, MaxSize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Firmware {
    /// The open firmware that takes PWM ([`super::morpheus`]).
    Morpheus,
    /// What an AX-12A comes with ([`super::protocol1`]).
    Stock,
}

impl Firmware {
    /// All there are, in the order in which they are looked for.
    pub const ALL: [Self; 2] = [Self::Morpheus, Self::Stock];
}

impl core::fmt::Display for Firmware {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str(match self {
            Self::Morpheus => "Morpheus",
            Self::Stock => "AX-12A",
        })
    }
}
