//! Which program runs on a servo, and so which protocol it speaks.

use super::morpheus::ServoId;
use super::protocol1::BROADCAST;
use super::table::{AX12A, MORPHEUS, Table};
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

    /// Whether a servo can have this id.
    pub const fn has_id(self, id: u8) -> bool {
        match self {
            Self::Morpheus => ServoId::new(id).is_some(),
            Self::Stock => id < BROADCAST,
        }
    }

    /// Its registers.
    pub const fn table(self) -> &'static Table {
        match self {
            Self::Morpheus => &MORPHEUS,
            Self::Stock => &AX12A,
        }
    }
}

impl core::fmt::Display for Firmware {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str(self.table().firmware)
    }
}
