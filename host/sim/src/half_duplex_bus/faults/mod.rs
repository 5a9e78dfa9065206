//! What can be wrong with a bus and with the electronics of its servos.
//!
//! | fault              | who notices                                           |
//! |--------------------|-------------------------------------------------------|
//! | [`ByteFault`]      | the servos, or the master                             |
//! | [`Wire::hold_low`] | everybody: one byte of zeros with a wrong stop bit, then nothing |
//! | [`Wire::hold_high`]| everybody: nothing                                    |
//! | [`Wire::echo`]     | the master: it hears what it sends                    |
//! | [`Wire::mute`]     | everybody: the servo obeys, and says nothing          |
//! | [`Wire::deafen`]   | the servo: it hears nothing, and goes on as it was    |

mod bytes;

pub use bytes::{ByteFault, Damage, Way};

use std::collections::VecDeque;
use std::ops::Range;

use super::line::{Ears, Frame, MASTER};
use super::{Heard, Wire};
use bytes::Channel;

/// Whoever holds the line down, as a sender.
pub(super) const INTRUDER: usize = MASTER - 1;

/// What is wrong.
#[derive(Clone, Debug, Default)]
pub(super) struct Faults {
    to_servos: Channel,
    to_master: Channel,
    /// Bytes on their way to the master, earliest first.
    late: VecDeque<Heard>,
    /// The line is held high.
    high_ns: Range<u64>,
    muted: Vec<usize>,
    deaf: Vec<usize>,
}

impl Faults {
    /// When the next late byte is there.
    pub(super) fn next_ns(&self) -> u64 {
        self.late.front().map_or(u64::MAX, |heard| heard.end_ns)
    }

    /// Whether what this sender begins now never shows on the line.
    pub(super) fn keep_off(&self, sender: usize, now_ns: u64) -> bool {
        sender != INTRUDER && (self.high_ns.contains(&now_ns) || self.muted.contains(&sender))
    }

    /// Whether this servo hears nothing.
    pub(super) fn is_deaf(&self, servo: usize) -> bool {
        self.deaf.contains(&servo)
    }
}

impl Wire {
    /// Does harm to bytes between the master and the bus.
    pub fn harm(&mut self, fault: ByteFault) {
        match fault.way {
            Way::ToServos => self.faults.to_servos.add(fault),
            Way::ToMaster => self.faults.to_master.add(fault),
        }
    }

    /// No byte comes to harm any more; those that are late still come.
    pub fn unharm(&mut self) {
        self.faults.to_servos.clear();
        self.faults.to_master.clear();
    }

    /// Something pulls the line down from now on, for so long.
    pub fn hold_low(&mut self, duration_ns: u64) {
        // A byte of zeros is low for nine bits.
        self.enqueue(Frame {
            sender: INTRUDER,
            byte: 0,
            start_ns: self.now_ns,
            bit_ns: (duration_ns / 9).max(1),
        });
    }

    /// Something keeps the line from going down, for so long from now on.
    pub fn hold_high(&mut self, duration_ns: u64) {
        self.faults.high_ns = self.now_ns..self.now_ns.saturating_add(duration_ns);
    }

    /// Whether the master hears what it sends.
    pub fn echo(&mut self, on: bool) {
        let ears = if on { Ears::All } else { Ears::Servos };
        self.master.set_ears(ears, self.now_ns, &self.frames);
    }

    /// Whether a servo says nothing, though it hears and obeys.
    pub fn mute(&mut self, servo: usize, is_mute: bool) {
        set(&mut self.faults.muted, servo, is_mute);
    }

    /// Whether a servo hears nothing, and so goes on as it was told last.
    pub fn deafen(&mut self, servo: usize, is_deaf: bool) {
        set(&mut self.faults.deaf, servo, is_deaf);
        self.refresh_ears(servo);
    }

    /// A byte from the master as it comes out of its plug.
    pub(super) fn plug_in(&mut self, frame: Frame) {
        let channel = &mut self.faults.to_servos;
        if channel.is_sound() {
            return self.enqueue(frame);
        }
        let passed = channel.pass(frame.byte, frame.start_ns, frame.bit_ns);
        for (byte, start_ns) in passed.into_iter().flatten() {
            self.enqueue(Frame {
                byte,
                start_ns,
                ..frame
            });
        }
    }

    /// A byte for the master as it goes into its plug.
    pub(super) fn plug_out(&mut self, heard: Heard) {
        let bit_ns = self.master.bit_ns();
        let Faults {
            to_master, late, ..
        } = &mut self.faults;
        if to_master.is_sound() {
            return self.heard.push_back(heard);
        }
        let passed = to_master.pass(heard.byte, heard.end_ns, bit_ns);
        for (byte, end_ns) in passed.into_iter().flatten() {
            let place = late.partition_point(|other| other.end_ns <= end_ns);
            let heard = Heard {
                byte,
                end_ns,
                ..heard
            };
            late.insert(place, heard);
        }
    }

    /// The first late byte is there.
    pub(super) fn late_byte(&mut self) {
        self.heard.extend(self.faults.late.pop_front());
    }
}

fn set(servos: &mut Vec<usize>, servo: usize, on: bool) {
    servos.retain(|other| *other != servo);
    if on {
        servos.push(servo);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::half_duplex_bus::{Device, Mechanics};
    use crate::morpheus_servo::{Reading, Servo};
    use armbridge_shared::actuator::Pwm;
    use armbridge_shared::servo::morpheus::{Request, ServoId};

    const BAUD: u32 = 1_000_000;
    const MS: u64 = 1_000_000;

    struct Nothing;

    impl Mechanics for Nothing {
        fn convert(&mut self, _servo: usize, _at_ns: u64) -> Reading {
            Reading::default()
        }

        fn drive(&mut self, _servo: usize, _at_ns: u64, _pwm: u16) {}
    }

    /// Sends a packet and returns what the master hears within 2 ms.
    fn say(wire: &mut Wire, packet: &[u8]) -> Vec<u8> {
        let begin_ns = wire.now_ns();
        for (start_ns, byte) in (begin_ns..).step_by(10_000).zip(packet) {
            wire.send(start_ns, *byte, BAUD);
        }
        wire.advance(begin_ns + 2 * MS, &mut Nothing);
        std::iter::from_fn(|| wire.take_heard())
            .map(|heard| heard.byte)
            .collect()
    }

    /// Bytes that each of two servos answers to a ping.
    fn pinged(wire: &mut Wire) -> [usize; 2] {
        [1, 2].map(|id| {
            let ping = Request::Ping(ServoId::new(id).unwrap()).encode();
            say(wire, &ping).len()
        })
    }

    fn pwm(wire: &Wire) -> Vec<u16> {
        wire.servos().iter().map(Device::pwm).collect()
    }

    #[test]
    fn line_and_servos_fail_as_they_are_told_and_recover() {
        let mut wire = Wire::new(vec![Servo::with_id(1), Servo::with_id(2)]);
        wire.advance(20 * MS, &mut Nothing);
        assert_eq!(pinged(&mut wire), [6, 6]);

        wire.hold_high(4 * MS);
        assert_eq!(pinged(&mut wire), [0, 0]);
        assert_eq!(pinged(&mut wire), [6, 6]);

        // The master takes the line's fall for a byte.
        wire.hold_low(4 * MS);
        assert_eq!(pinged(&mut wire), [1, 0]);
        assert_eq!(pinged(&mut wire), [6, 6]);

        wire.mute(0, true);
        assert_eq!(pinged(&mut wire), [0, 6]);
        let stop = Request::StopAll.encode();
        say(&mut wire, &stop);
        wire.mute(0, false);
        wire.deafen(1, true);
        assert_eq!(pinged(&mut wire), [6, 0]);
        wire.deafen(1, false);
        assert_eq!(pinged(&mut wire), [6, 6]);

        wire.echo(true);
        assert_eq!(pinged(&mut wire), [12, 12]);
        wire.echo(false);
        assert_eq!(pinged(&mut wire), [6, 6]);
        assert_eq!(pwm(&wire), [1000, 1000]);
    }

    #[test]
    fn the_deaf_goes_on_and_the_mute_obeys() {
        let mut wire = Wire::new(vec![Servo::with_id(1), Servo::with_id(2)]);
        wire.advance(20 * MS, &mut Nothing);
        let ids = [1, 2].map(|id| ServoId::new(id).unwrap());
        let drive = |pwm: u16| {
            let pwm = Pwm::new(pwm).unwrap();
            Request::Drive(ids.map(|id| (id, pwm))).encode()
        };
        say(&mut wire, &drive(1200));
        assert_eq!(pwm(&wire), [1200, 1200]);
        wire.mute(0, true);
        wire.deafen(1, true);
        say(&mut wire, &drive(1100));
        assert_eq!(pwm(&wire), [1100, 1200]);
    }
}
