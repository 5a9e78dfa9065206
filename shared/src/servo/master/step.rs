//! Effect of a transaction step on serial port and direction pin.

use embedded_hal::digital::{OutputPin, PinState};
use embedded_hal_nb::serial::{Read, Write};

use super::super::exchange::Step;
use super::super::port::{SetBaud, bytes_us};
use super::receiver::Receiver;
use super::{DRAIN_MAX, Master, Phase};

impl<S, D> Master<S, D>
where
    S: Read<u8> + Write<u8> + SetBaud,
    D: OutputPin,
{
    /// Enters the next step, or ends the transaction.
    pub(super) fn enter_step(&mut self, now_us: u64) {
        let step = self.transaction.step(self.next_step, &self.line);
        self.next_step += 1;
        let before = core::mem::replace(&mut self.phase, Phase::Idle);
        if let Phase::Listening { receiver, .. } = before {
            self.reply = receiver.into_reply();
        }
        self.phase = match step {
            Some(Step::Send(packet)) => self.send(&packet, 1, now_us),
            Some(Step::SendRequest) => self.send_outgoing(1, now_us),
            Some(Step::Repeat(byte, count)) => self.send(&[byte], count, now_us),
            Some(Step::Pause { us }) => Phase::Pausing {
                until_us: now_us + u64::from(us),
            },
            Some(Step::Listen(expected, window_us)) => {
                self.drive_line(false);
                Phase::Listening {
                    receiver: Receiver::new(expected, self.line.firmware),
                    until_us: now_us + window_us,
                }
            }
            None => {
                self.drive_line(false);
                self.echo.classify_bus();
                Phase::Idle
            }
        };
    }

    fn send(&mut self, bytes: &[u8], repeats: u16, now_us: u64) -> Phase {
        // Every packet of the bridge is shorter than the longest.
        self.outgoing = heapless::Vec::from_slice(bytes).unwrap_or_default();
        self.send_outgoing(repeats, now_us)
    }

    fn send_outgoing(&mut self, repeats: u16, now_us: u64) -> Phase {
        self.drive_line(true);
        self.echo.reset();
        let bytes = self.outgoing.len() as u32 * u32::from(repeats);
        self.active_us = now_us + bytes_us(bytes, self.line.baud);
        Phase::Writing {
            cursor: 0,
            repeats,
            retry_us: now_us,
        }
    }

    /// Reads the received bytes, at most a receive buffer's worth: a port that reports
    /// errors for ever must not delay the tick.
    pub(super) fn drain(&mut self, now_us: u64) {
        for _ in 0..DRAIN_MAX {
            match self.serial.read() {
                Err(nb::Error::WouldBlock) => return,
                Ok(byte) if self.echo.is_echo(byte) => {}
                Ok(byte) => {
                    if self.is_tapped {
                        // Bytes that are not taken in time: the newest are lost.
                        let _ = self.rx_tap.push_back(byte);
                        self.active_us = self.active_us.max(now_us);
                    }
                    // Outside a window no request is pending, so no byte is a reply.
                    if let Phase::Listening { receiver, .. } = &mut self.phase {
                        receiver.push_byte(byte, self.line.ids);
                    }
                }
                Err(nb::Error::Other(_)) => {
                    if let Phase::Listening { receiver, .. } = &mut self.phase {
                        receiver.line_error();
                    }
                }
            }
        }
    }

    /// Turns the line driver on or off. A pin that fails has no remedy here;
    /// the missing replies show it.
    pub(super) fn drive_line(&mut self, on: bool) {
        let _ = self.direction.set_state(PinState::from(on));
    }
}
