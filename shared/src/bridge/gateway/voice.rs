//! Answers to the client, in the name of the servo it spoke to.

use crate::servo::morpheus::{self, ServoId};
use crate::servo::protocol1::{self, Alarms, Status};
use crate::servo::table::AX12A;
use heapless::Vec;

/// The longest that is said to client or bus: a stock servo's whole table.
pub const BYTES_MAX: usize = protocol1::frame::OVERHEAD + AX12A.size as usize;

/// A packet for the client or for the bus. Empty: silence.
pub type Bytes = Vec<u8, BYTES_MAX>;

/// Payload by which a Morpheus servo refuses (`Serial.h` of the firmware).
const NOK: u8 = 0x08;

/// Whom the client spoke to, and so in whose name it is answered. What goes to
/// all servos, or to an id that none can have, is answered with silence.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Voice {
    /// A stock servo.
    Stock {
        /// Its id.
        id: u8,
    },
    /// A Morpheus servo.
    Morpheus {
        /// Its id.
        id: u8,
        /// The client's own address.
        client: u8,
    },
}

impl Voice {
    /// Whom the client spoke to.
    pub(super) const fn id(self) -> u8 {
        match self {
            Self::Stock { id } | Self::Morpheus { id, .. } => id,
        }
    }

    /// An answer. Morpheus has no word for alarms.
    pub(super) fn says(self, alarms: Alarms, data: &[u8]) -> Bytes {
        let packet = match self {
            Self::Stock { id } if id < protocol1::BROADCAST => Status {
                id,
                alarms,
                parameters: data,
            }
            .encode(),
            Self::Morpheus { id, client } if ServoId::new(id).is_some() => morpheus::Frame {
                destination: client,
                source: id,
                data,
            }
            .encode(),
            Self::Stock { .. } | Self::Morpheus { .. } => None,
        };
        packet.unwrap_or_default()
    }

    /// "I will not", as to an instruction that the servo does not know.
    pub(super) fn refuses(self) -> Bytes {
        self.says(Alarms::INSTRUCTION, self.refusal_data())
    }

    /// What an answer carries that is no data.
    pub(super) const fn refusal_data(self) -> &'static [u8] {
        match self {
            Self::Stock { .. } => &[],
            Self::Morpheus { .. } => &[NOK],
        }
    }
}
