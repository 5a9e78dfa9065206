//! The board's latest messages, for a host that joins while another one commands.
//!
//! A board describes itself, its settings, its servos and a latched fault in answer to a
//! hello. The hello of a watcher does not reach the board, so the server repeats the
//! messages.

use std::mem::{Discriminant, discriminant};

use armbridge_link::message::{Mode, ToHost};
use armbridge_link::schema;

/// Latest message of each kind that outlasts its tick, oldest first.
#[derive(Debug, Default)]
pub(super) struct Latest(Vec<ToHost>);

impl Latest {
    /// Takes a message of the board.
    pub(super) fn take(&mut self, message: &ToHost) {
        match message {
            // For one host only, or for one tick.
            ToHost::Ack { .. }
            | ToHost::Departs { .. }
            | ToHost::Began(_)
            | ToHost::Concluded(_) => {}
            // Everything is reported again after it.
            ToHost::Hello(_) => self.0 = vec![*message],
            ToHost::Record(record) => self.0.retain(|old| match old {
                ToHost::Tripped(_) | ToHost::Off(_) => matches!(record.mode, Mode::Fault(_)),
                ToHost::Passthrough => false,
                _ => true,
            }),
            _ => {
                let kind = kind(message);
                self.0.retain(|old| self::kind(old) != kind);
                self.0.push(*message);
            }
        }
    }

    /// The answer to the hello of a watcher.
    pub(super) fn answer(&self) -> impl Iterator<Item = ToHost> {
        let hello = match self.0.first() {
            Some(ToHost::Hello(_)) => None,
            _ => Some(ToHost::Hello(schema::HELLO)),
        };
        hello.into_iter().chain(self.0.iter().copied())
    }
}

/// Kind of a message; all results of the search for servos are one, `None`.
fn kind(message: &ToHost) -> (Option<Discriminant<ToHost>>, u8) {
    match *message {
        ToHost::Found { .. }
        | ToHost::Mixed(_)
        | ToHost::Absent { .. }
        | ToHost::Unprepared { .. } => (None, 0),
        ToHost::Temperature { joint, .. } => (Some(discriminant(message)), joint),
        _ => (Some(discriminant(message)), 0),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use armbridge_link::message::Record;
    use armbridge_link::message::{Fault, StopSource, Trip};
    use armbridge_servo::{Firmware, Missing};

    #[test]
    fn a_watcher_is_told_what_is_so_now() {
        let mut latest = Latest::default();
        let hello = ToHost::Hello(schema::HELLO);
        assert_eq!(latest.answer().collect::<Vec<_>>(), [hello]);
        let absent = ToHost::Absent {
            joint: 0,
            missing: Missing::Silence,
        };
        let found = ToHost::Found {
            firmware: Firmware::Morpheus,
            baud: 1_000_000,
            is_ready: true,
        };
        let tripped = ToHost::Tripped(Trip {
            fault: Fault::EmergencyStop(StopSource::Host),
            joint: None,
            tick: 1,
            at_us: 2,
            value: 0.0,
            limit: 0.0,
        });
        for message in [absent, hello, absent, found, tripped] {
            latest.take(&message);
        }
        assert_eq!(latest.answer().collect::<Vec<_>>(), [hello, found, tripped]);
        // The fault was cleared.
        latest.take(&ToHost::Record(Record::NONE));
        assert_eq!(latest.answer().collect::<Vec<_>>(), [hello, found]);
    }
}
