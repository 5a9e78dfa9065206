//! The stop sequence by polling.
//!
//! A servo keeps its last PWM for ever. When the program can no longer be
//! trusted (panic, hard fault, a watchdog's bite), the board sends the stop
//! sequence itself: no interrupts, no executor, no memory but this stack.

use armbridge_shared::bridge::SERVO_IDS;
use armbridge_shared::servo::stop::{StopStep, stop_steps};

/// A UART and direction pin that need nothing but themselves.
pub trait PolledLine {
    /// Drives the line (`true`) or releases it.
    fn drive(&mut self, on: bool);
    /// Sends a byte, waiting for room; gives up if there is never any.
    fn send(&mut self, byte: u8);
    /// Waits until the last stop bit has left.
    fn flush(&mut self);
    /// Waits so long.
    fn pause_us(&mut self, us: u32);
}

/// Sends the stop sequence: about 9 ms.
pub fn send(line: &mut impl PolledLine) {
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
