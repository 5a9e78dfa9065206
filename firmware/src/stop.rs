//! The stop sequence by polling.
//!
//! A servo keeps its last PWM for ever. When the program can no longer be
//! trusted (panic, hard fault, watchdog), the board sends the stop
//! sequence itself: no interrupts, no executor, no memory but this stack.
//!
//! The sequence has 4.35 ms of pauses and 272 bytes: [`SEQUENCE_US`] at 1 Mbaud, where
//! Morpheus servos always are, and 52.2 ms at the 57,600 baud of the slowest
//! stock servos that discovery finds.

use armbridge_board::bridge::SERVO_IDS;
use armbridge_servo::port::BAUD_RATES;
use armbridge_servo::stop::{StopStep, stop_steps};

/// Duration of the sequence from the first to the last bit at 1 Mbaud, in µs, without
/// delays of the processor.
pub const SEQUENCE_US: u32 = 7_070;

/// A UART and direction pin without interrupts or buffers.
pub trait PolledUart {
    /// Sends at this many bits per second from now on.
    fn set_baud(&mut self, baud: u32);
    /// Drives the line (`true`) or releases it.
    fn drive(&mut self, on: bool);
    /// Sends a byte when there is room; gives up after a time-out.
    fn send(&mut self, byte: u8);
    /// Waits until the last stop bit has left.
    fn flush(&mut self);
    /// Waits for this time in µs.
    fn pause_us(&mut self, us: u32);
}

/// Sends the stop sequence at this many bits per second.
pub fn send(line: &mut impl PolledUart, baud: u32) {
    line.set_baud(baud);
    line.drive(true);
    for step in stop_steps(SERVO_IDS) {
        match step {
            StopStep::Send(packet) => {
                for byte in &packet {
                    line.send(*byte);
                }
            }
            StopStep::Repeat(byte, count) => {
                for _ in 0..count {
                    line.send(byte);
                }
            }
            StopStep::Pause { us } => {
                line.flush();
                line.pause_us(us);
            }
        }
    }
    line.flush();
    line.drive(false);
}

/// Sends the sequence after a reset: at the previous speed of the bus, if it is known and
/// differs from the factory speed of servos, and at the factory speed.
pub fn send_first(line: &mut impl PolledUart, baud_before: Option<u32>) {
    let [ex_works, ..] = BAUD_RATES;
    if let Some(baud) = baud_before.filter(|baud| *baud != ex_works) {
        send(line, baud);
    }
    send(line, ex_works);
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;
    use armbridge_servo::port::bytes_us;
    use std::vec::Vec;

    /// A wire, and what was on it: at which speed, and from when on in µs.
    #[derive(Default)]
    struct Wire {
        baud: u32,
        driven: bool,
        now_us: u64,
        sent: Vec<(u8, u32)>,
    }

    impl PolledUart for Wire {
        fn set_baud(&mut self, baud: u32) {
            self.baud = baud;
        }

        fn drive(&mut self, on: bool) {
            self.driven = on;
        }

        fn send(&mut self, byte: u8) {
            assert!(self.driven);
            self.sent.push((byte, self.baud));
            self.now_us += bytes_us(1, self.baud);
        }

        fn flush(&mut self) {}

        fn pause_us(&mut self, us: u32) {
            self.now_us += u64::from(us);
        }
    }

    #[test]
    fn it_takes_as_long_as_is_said() {
        let mut wire = Wire::default();
        send(&mut wire, 1_000_000);
        assert_eq!(
            (wire.now_us, wire.sent.len()),
            (u64::from(SEQUENCE_US), 272)
        );
        let stop_all = [0xAA, 0x06, 0xFF, 0xFE, 0x03, 0x10, 0xE8, 0x03, 0xF8];
        assert!(
            wire.sent
                .iter()
                .zip(stop_all)
                .all(|(sent, byte)| sent.0 == byte)
        );
        assert!(!wire.driven);
        let mut wire = Wire::default();
        send(&mut wire, 57_142);
        assert_eq!(wire.now_us, 52_222);
    }

    #[test]
    fn after_a_reset_servos_are_stopped_at_the_speed_they_had() {
        let mut wire = Wire::default();
        send_first(&mut wire, Some(57_142));
        let mut bauds: Vec<_> = wire.sent.iter().map(|sent| sent.1).collect();
        bauds.dedup();
        assert_eq!(bauds, [57_142, 1_000_000]);
        for before in [None, Some(1_000_000)] {
            let mut wire = Wire::default();
            send_first(&mut wire, before);
            assert_eq!((wire.sent.len(), wire.baud), (272, 1_000_000));
        }
    }
}
