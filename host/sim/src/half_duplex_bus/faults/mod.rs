//! Faults of a bus and of the electronics of its servos.
//!
//! | fault              | affected                                              |
//! |--------------------|-------------------------------------------------------|
//! | [`ByteFault`]      | the servos, or the master                             |
//! | [`Wire::hold_low`] | all: one byte of zeros with a wrong stop bit, then nothing |
//! | [`Wire::hold_high`]| all: nothing is received                              |
//! | [`Wire::echo`]     | the master: it receives what it sends                 |
//! | [`Wire::mute`]     | the servo: it executes, but does not reply            |
//! | [`Wire::deafen`]   | the servo: it receives nothing, and keeps its command |

mod bytes;

pub use bytes::{ByteFault, Damage, Way};

use std::collections::VecDeque;
use std::ops::Range;

use super::line::{Frame, Listening, MASTER};
use super::{ReceivedByte, Wire};
use bytes::Channel;

/// Index of the sender that holds the line low.
pub(super) const FAULT_SENDER: usize = MASTER - 1;

/// Active faults.
#[derive(Clone, Debug, Default)]
pub(super) struct Faults {
    to_servos: Channel,
    to_master: Channel,
    /// Bytes on their way to the master, earliest first.
    late: VecDeque<ReceivedByte>,
    /// The line is held high.
    high_ns: Range<u64>,
    muted: Vec<usize>,
    deaf: Vec<usize>,
}

impl Faults {
    /// When the next late byte is there.
    pub(super) fn next_ns(&self) -> u64 {
        self.late
            .front()
            .map_or(u64::MAX, |received| received.end_ns)
    }

    /// Whether bytes that this sender begins now never reach the line.
    pub(super) fn keep_off(&self, sender: usize, now_ns: u64) -> bool {
        sender != FAULT_SENDER && (self.high_ns.contains(&now_ns) || self.muted.contains(&sender))
    }

    /// Whether this servo receives nothing.
    pub(super) fn is_deaf(&self, servo: usize) -> bool {
        self.deaf.contains(&servo)
    }
}

impl Wire {
    /// Damages bytes between the master and the bus.
    pub fn inject(&mut self, fault: ByteFault) {
        match fault.way {
            Way::ToServos => self.faults.to_servos.add(fault),
            Way::ToMaster => self.faults.to_master.add(fault),
        }
    }

    /// Removes all damage of bytes; late ones still arrive.
    pub(crate) fn clear_byte_faults(&mut self) {
        self.faults.to_servos.clear();
        self.faults.to_master.clear();
    }

    /// Holds the line low from now on, for this time.
    pub(crate) fn hold_low(&mut self, duration_ns: u64) {
        // A byte of zeros is low for nine bits.
        self.enqueue(Frame {
            sender: FAULT_SENDER,
            byte: 0,
            start_ns: self.now_ns,
            bit_ns: (duration_ns / 9).max(1),
        });
    }

    /// Holds the line high from now on, for this time.
    pub fn hold_high(&mut self, duration_ns: u64) {
        self.faults.high_ns = self.now_ns..self.now_ns.saturating_add(duration_ns);
    }

    /// Whether the master receives what it sends.
    pub fn echo(&mut self, on: bool) {
        let listening = if on {
            Listening::All
        } else {
            Listening::Servos
        };
        self.master
            .set_listening(listening, self.now_ns, &self.frames);
    }

    /// Whether a servo does not reply, though it receives and executes.
    pub(crate) fn mute(&mut self, servo: usize, is_mute: bool) {
        set(&mut self.faults.muted, servo, is_mute);
    }

    /// Whether a servo receives nothing, and so keeps its last command.
    pub fn deafen(&mut self, servo: usize, is_deaf: bool) {
        set(&mut self.faults.deaf, servo, is_deaf);
        self.refresh_ears(servo);
    }

    /// A byte from the master behind its plug.
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

    /// A byte for the master before its plug.
    pub(super) fn plug_out(&mut self, received: ReceivedByte) {
        let bit_ns = self.master.bit_ns();
        let Faults {
            to_master, late, ..
        } = &mut self.faults;
        if to_master.is_sound() {
            return self.received.push_back(received);
        }
        let passed = to_master.pass(received.byte, received.end_ns, bit_ns);
        for (byte, end_ns) in passed.into_iter().flatten() {
            let place = late.partition_point(|other| other.end_ns <= end_ns);
            let received = ReceivedByte {
                byte,
                end_ns,
                ..received
            };
            late.insert(place, received);
        }
    }

    /// The first late byte arrives.
    pub(super) fn late_byte(&mut self) {
        self.received.extend(self.faults.late.pop_front());
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

    /// Sends a packet and returns the bytes that the master receives within 2 ms.
    fn say(wire: &mut Wire, packet: &[u8]) -> Vec<u8> {
        let begin_ns = wire.now_ns();
        for (start_ns, byte) in (begin_ns..).step_by(10_000).zip(packet) {
            wire.send(start_ns, *byte, BAUD);
        }
        wire.advance(begin_ns + 2 * MS, &mut Nothing);
        std::iter::from_fn(|| wire.take_received())
            .map(|received| received.byte)
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

        // The master takes the falling edge for a byte.
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
