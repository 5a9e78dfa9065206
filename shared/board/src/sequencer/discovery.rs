//! Discovery: search for the servos, their speed and their firmware.
//!
//! ```text
//! at each baud rate: stop -> ping joint 1 (Morpheus, stock, X) -> ping joint 2 -> ..
//!   all found, one firmware  -> position chain (Morpheus), read the settings (stock, X)
//!   none found               -> the next speed
//!   otherwise                -> a notification to the host; a pause; from the beginning
//! ```
//!
//! The stop sequence precedes any request at a speed. Above 1 Mbaud, which the X series alone has,
//! there are no pings of the others; and the search ends at the fastest rate of the port.

use armbridge_link::message::{Missing, Sample};
use armbridge_servo::port::AX12A_BAUD_MAX;
use armbridge_servo::{Firmware, JOINTS};

/// Progress of the search.
#[derive(Clone, Copy, Debug)]
pub(super) struct Discovery {
    /// Baud rates of the search, the likeliest first.
    rates: &'static [u32],
    /// Index of the present one.
    rate: usize,
    /// Number of servos.
    servos: usize,
    found: [Option<Firmware>; JOINTS],
    /// Reason for the missing reply of each servo that did not answer.
    faults: [Option<Missing>; JOINTS],
}

/// Result of a ping.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Next {
    /// Ping this joint next, in this protocol.
    Ping { joint: usize, firmware: Firmware },
    /// Search at the next speed, from the stop on.
    OtherSpeed,
    /// All servos answer, with this firmware.
    Found(Firmware),
    /// The servos run different firmwares.
    Mixed([Firmware; JOINTS]),
    /// This joint's servo does not answer.
    Absent(usize, Missing),
}

impl Discovery {
    /// A search for this number of servos at these baud rates, the likeliest first.
    pub(super) fn new(rates: &'static [u32], servos: usize) -> Self {
        Self {
            rates,
            rate: 0,
            servos,
            found: [None; JOINTS],
            faults: [None; JOINTS],
        }
    }

    /// Firmware of the first ping of a servo: Morpheus, with whose packets the stop sequence ends,
    /// where the speed permits.
    pub(super) fn first_firmware(&self) -> Firmware {
        match self.baud() {
            Some(baud) if baud > AX12A_BAUD_MAX => Firmware::XSeries,
            _ => Firmware::Morpheus,
        }
    }

    /// The present speed of the search; `None` beyond the last.
    pub(super) fn baud(&self) -> Option<u32> {
        self.rates.get(self.rate).copied()
    }

    /// Begins the search at the present speed again.
    pub(super) fn begin(&mut self) {
        self.found = [None; JOINTS];
        self.faults = [None; JOINTS];
    }

    /// Takes the outcome of a ping of this joint in this firmware's protocol.
    pub(super) fn note_ping(
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
                let is_specific = !matches!(missing, Missing::Silence | Missing::EchoOnly);
                if let Some(slot) = self.faults.get_mut(joint)
                    && (slot.is_none() || is_specific)
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
            Firmware::Stock if !is_found => Next::Ping {
                joint,
                firmware: Firmware::XSeries,
            },
            Firmware::Morpheus | Firmware::Stock | Firmware::XSeries if joint + 1 < self.servos => {
                Next::Ping {
                    joint: joint + 1,
                    firmware: self.first_firmware(),
                }
            }
            Firmware::Morpheus | Firmware::Stock | Firmware::XSeries => self.conclude_speed(),
        }
    }

    /// Concludes the search at this speed, after the last ping.
    fn conclude_speed(&mut self) -> Next {
        let mut searched = self.found.iter().take(self.servos);
        let absent = searched.position(Option::is_none);
        match (self.found, absent) {
            ([Some(first), rest @ ..], None) => {
                let mut others = rest.iter().flatten();
                if others.all(|other| *other == first) {
                    return Next::Found(first);
                }
                Next::Mixed(self.found.map(|found| found.unwrap_or(first)))
            }
            // None found at this speed.
            (found, _) if found == [None; JOINTS] && self.rate + 1 < self.rates.len() => {
                self.rate += 1;
                Next::OtherSpeed
            }
            (found, absent) => {
                if found == [None; JOINTS] {
                    self.rate = 0;
                }
                let joint = absent.unwrap_or(0);
                let missing = self.faults.get(joint).copied().flatten();
                Next::Absent(joint, missing.unwrap_or(Missing::Silence))
            }
        }
    }
}
