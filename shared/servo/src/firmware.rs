//! Firmware of the servos, which determines their protocol.

#[cfg(feature = "postcard")]
use postcard::experimental::max_size::MaxSize;
#[cfg(feature = "postcard")]
use postcard_schema::Schema;
#[cfg(feature = "postcard")]
use serde::{Deserialize, Serialize};

/// Firmware of a servo. All servos of a bus must run the same.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "postcard", derive(Serialize, Deserialize, Schema, MaxSize))]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Firmware {
    /// The open firmware with a PWM command ([`super::morpheus`]).
    Morpheus,
    /// The factory firmware of an AX-12A ([`super::protocol1`]).
    Stock,
    /// The factory firmware of the X series ([`super::protocol2`]).
    XSeries,
}

impl Firmware {
    /// All variants, in the order in which discovery tries them.
    pub const ALL: [Self; 3] = [Self::Morpheus, Self::Stock, Self::XSeries];
}

impl core::fmt::Display for Firmware {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str(match self {
            Self::Morpheus => "Morpheus",
            Self::Stock => "AX-12A",
            Self::XSeries => "X series",
        })
    }
}
