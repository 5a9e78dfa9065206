//! Discovery: finds the servos, their speed and their firmware.
//!
//! ```text
//! at each of BAUD_RATES: stop -> ping joint 1 (Morpheus, stock) -> ping joint 2 -> ..
//!   all found, one firmware  -> line up (Morpheus), read the settings (stock)
//!   none found               -> the next speed
//!   otherwise                -> a notice to the host; a pause; from the beginning
//! ```
//!
//! The stop sequence precedes any request at a speed.

use crate::JOINTS;
use crate::link::message::{Missing, Sample};
use crate::servo::Firmware;
use crate::servo::port::BAUD_RATES;

/// Progress of the search.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Discovery {
    /// Index of the baud rate at which servos are looked for.
    rate: usize,
    found: [Option<Firmware>; JOINTS],
    /// Why a servo's sample is missing, for those that did not answer.
    heard: [Option<Missing>; JOINTS],
}

/// Result of a ping.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Next {
    /// Another ping.
    Ping { joint: usize, firmware: Firmware },
    /// The same from the stop on, at the next speed.
    OtherSpeed,
    /// All servos answer, and run this.
    Found(Firmware),
    /// They run different firmwares.
    Mixed([Firmware; JOINTS]),
    /// This joint's servo does not answer.
    Absent(usize, Missing),
}

impl Discovery {
    /// Pings begin with Morpheus: the stop sequence ends with its packets.
    pub(super) const FIRST: Next = Next::Ping {
        joint: 0,
        firmware: Firmware::Morpheus,
    };

    /// Begins at the likeliest speed.
    pub(super) fn rewind(&mut self) {
        *self = Self::default();
    }

    /// The present speed; `None` beyond the last.
    pub(super) fn baud(&self) -> Option<u32> {
        BAUD_RATES.get(self.rate).copied()
    }

    /// Begins the search at the present speed again.
    pub(super) fn begin(&mut self) {
        self.found = [None; JOINTS];
        self.heard = [None; JOINTS];
    }

    /// Takes the outcome of a ping of this joint in this firmware's protocol.
    pub(super) fn pinged(
        &mut self,
        joint: usize,
        firmware: Firmware,
        sample: Option<Sample>,
    ) -> Next {
        let is_found = match sample {
            Some(Sample::Counts(_)) => {
                if let Some(slot) = self.found.get_mut(joint) {
                    *slot = Some(firmware);
                }
                true
            }
            Some(Sample::Missing(missing)) => {
                // Damage is more specific than silence.
                let says_more = !matches!(missing, Missing::Silence | Missing::EchoOnly);
                if let Some(slot) = self.heard.get_mut(joint)
                    && (slot.is_none() || says_more)
                {
                    *slot = Some(missing);
                }
                false
            }
            None => false,
        };
        match firmware {
            Firmware::Morpheus if !is_found => Next::Ping {
                joint,
                firmware: Firmware::Stock,
            },
            Firmware::Morpheus | Firmware::Stock if joint + 1 < JOINTS => Next::Ping {
                joint: joint + 1,
                firmware: Firmware::Morpheus,
            },
            Firmware::Morpheus | Firmware::Stock => self.all_pinged(),
        }
    }

    /// Every servo has been asked at this speed.
    fn all_pinged(&mut self) -> Next {
        let absent = self.found.iter().position(Option::is_none);
        match (self.found, absent) {
            ([Some(first), rest @ ..], None) => {
                if rest.iter().all(|other| *other == Some(first)) {
                    return Next::Found(first);
                }
                Next::Mixed(self.found.map(|found| found.unwrap_or(first)))
            }
            // None at this speed: the next.
            (found, _) if found == [None; JOINTS] && self.rate + 1 < BAUD_RATES.len() => {
                self.rate += 1;
                Next::OtherSpeed
            }
            (found, absent) => {
                if found == [None; JOINTS] {
                    self.rate = 0;
                }
                let joint = absent.unwrap_or(0);
                let missing = self.heard.get(joint).copied().flatten();
                Next::Absent(joint, missing.unwrap_or(Missing::Silence))
            }
        }
    }
}
