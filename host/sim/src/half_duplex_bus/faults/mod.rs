//! Faults of a bus and of the electronics of its servos.
//!
//! | fault              | affected                                              |
//! |--------------------|-------------------------------------------------------|
//! | [`ByteFault`]      | the servos, or the master                             |
//! | [`Wire::hold_low`] | all: one byte of zeros with a wrong stop bit, then nothing |
//! | [`Wire::hold_high`]| all: nothing is received                              |
//! | [`Wire::echo`]     | the master: it receives its own bytes                 |
//! | [`Wire::mute`]     | the servo: it executes, but does not reply            |
//! | [`Wire::deafen`]   | the servo: it receives nothing, and keeps its command |
//! | [`Wire::send_foreign`] | all: they receive a second master                 |

mod bytes;

pub use bytes::{BusDirection, ByteDamage, ByteFault};

use std::collections::VecDeque;
use std::ops::Range;

use super::line::{Frame, MASTER, SenderFilter};
use super::{ReceivedByte, Wire, bit_ns};
use bytes::FaultyChannel;

/// Index of the sender that holds the line low.
pub(super) const FAULT_SENDER: usize = MASTER - 1;

/// Index of a second master as a sender.
const SECOND_MASTER: usize = MASTER - 2;

/// Active faults.
#[derive(Clone, Debug, Default)]
pub(super) struct Faults {
    to_servos: FaultyChannel,
    to_master: FaultyChannel,
    /// Delayed bytes to the master, earliest first.
    late: VecDeque<ReceivedByte>,
    /// The line is held high.
    high_ns: Range<u64>,
    muted: Vec<usize>,
    deaf: Vec<usize>,
}

impl Faults {
    /// Arrival of the next late byte.
    pub(super) fn next_ns(&self) -> u64 {
        self.late
            .front()
            .map_or(u64::MAX, |received| received.end_ns)
    }

    /// Whether bytes of this sender do not reach the line now.
    pub(super) fn blocks_sender(&self, sender: usize, now_ns: u64) -> bool {
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
        match fault.direction {
            BusDirection::ToServos => self.faults.to_servos.add(fault),
            BusDirection::ToMaster => self.faults.to_master.add(fault),
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

    /// Puts a byte of a second master on the line.
    pub(crate) fn send_foreign(&mut self, start_ns: u64, byte: u8, baud: u32) {
        self.enqueue(Frame {
            sender: SECOND_MASTER,
            byte,
            start_ns: start_ns.max(self.now_ns),
            bit_ns: bit_ns(baud),
        });
    }

    /// Holds the line high from now on, for this time.
    pub fn hold_high(&mut self, duration_ns: u64) {
        self.faults.high_ns = self.now_ns..self.now_ns.saturating_add(duration_ns);
    }

    /// Sets whether the master receives its own bytes.
    pub fn echo(&mut self, on: bool) {
        let filter = if on {
            SenderFilter::All
        } else {
            SenderFilter::Servos
        };
        self.master.set_filter(filter, self.now_ns, &self.line);
    }

    /// Sets whether a servo is mute: it receives and executes, but does not reply.
    pub(crate) fn mute(&mut self, servo: usize, is_mute: bool) {
        set(&mut self.faults.muted, servo, is_mute);
    }

    /// Sets whether a servo is deaf: it receives nothing, and keeps its last command.
    pub fn deafen(&mut self, servo: usize, is_deaf: bool) {
        set(&mut self.faults.deaf, servo, is_deaf);
        self.update_receiver(servo);
    }

    /// Puts a byte of the master on the line, with faults applied.
    pub(super) fn send_frame(&mut self, frame: Frame) {
        let channel = &mut self.faults.to_servos;
        if channel.has_no_faults() {
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

    /// Passes a byte to the master, with faults applied.
    pub(super) fn deliver_to_master(&mut self, received: ReceivedByte) {
        let bit_ns = self.master.bit_ns();
        let Faults {
            to_master, late, ..
        } = &mut self.faults;
        if to_master.has_no_faults() {
            return self.received.push_back(received);
        }
        let passed = to_master.pass(received.byte, received.end_ns, bit_ns);
        for (byte, end_ns) in passed.into_iter().flatten() {
            let index = late.partition_point(|other| other.end_ns <= end_ns);
            let received = ReceivedByte {
                byte,
                end_ns,
                ..received
            };
            late.insert(index, received);
        }
    }

    /// Passes the first late byte to the master.
    pub(super) fn deliver_late_byte(&mut self) {
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
    use crate::half_duplex_bus::{Device, Mechanics, MotorDrive};
    use crate::morpheus_servo::{Reading, Servo};
    use armbridge_servo::Pwm;
    use armbridge_servo::morpheus::{Request, ServoId};

    const BAUD: u32 = 1_000_000;
    const MS: u64 = 1_000_000;

    struct NoMechanics;

    impl Mechanics for NoMechanics {
        fn convert(&mut self, _servo: usize, _at_ns: u64) -> Reading {
            Reading::default()
        }

        fn drive(&mut self, _servo: usize, _at_ns: u64, _drive: MotorDrive) {}
    }

    /// Sends a packet and returns the bytes that the master receives within 2 ms.
    fn exchange(wire: &mut Wire, packet: &[u8]) -> Vec<u8> {
        let begin_ns = wire.now_ns();
        for (start_ns, byte) in (begin_ns..).step_by(10_000).zip(packet) {
            wire.send(start_ns, *byte, BAUD);
        }
        wire.advance(begin_ns + 2 * MS, &mut NoMechanics);
        std::iter::from_fn(|| wire.take_received())
            .map(|received| received.byte)
            .collect()
    }

    /// Length of the reply of each of two servos to a ping.
    fn pinged(wire: &mut Wire) -> [usize; 2] {
        [1, 2].map(|id| {
            let ping = Request::Ping(ServoId::new(id).unwrap()).encode();
            exchange(wire, &ping).len()
        })
    }

    fn pwm(wire: &Wire) -> Vec<u16> {
        wire.servos().iter().map(Device::pwm).collect()
    }

    #[test]
    fn injected_faults_of_line_and_servos_take_effect_and_end() {
        let mut wire = Wire::new(vec![Servo::with_id(1), Servo::with_id(2)]);
        wire.advance(20 * MS, &mut NoMechanics);
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
        exchange(&mut wire, &stop);
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
    fn a_deaf_servo_keeps_its_command_and_a_mute_one_executes() {
        let mut wire = Wire::new(vec![Servo::with_id(1), Servo::with_id(2)]);
        wire.advance(20 * MS, &mut NoMechanics);
        let ids = [1, 2].map(|id| ServoId::new(id).unwrap());
        let drive = |pwm: u16| {
            let pwm = Pwm::new(pwm).unwrap();
            Request::Drive(ids.map(|id| (id, pwm))).encode()
        };
        exchange(&mut wire, &drive(1200));
        assert_eq!(pwm(&wire), [1200, 1200]);
        wire.mute(0, true);
        wire.deafen(1, true);
        exchange(&mut wire, &drive(1100));
        assert_eq!(pwm(&wire), [1100, 1200]);
    }
}
