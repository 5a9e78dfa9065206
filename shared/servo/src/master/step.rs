//! Effect of a transaction step on the bus.

use super::super::bus::{Bus, LineAfter, Received, Transmission};
use super::super::exchange::Step;
use super::super::port::bytes_us;
use super::{DRAIN_MAX, Master, Phase};

impl<B: Bus> Master<B> {
    /// Enters the next step, or ends the transaction.
    pub(super) fn enter_step(&mut self, now_us: u64) {
        let step = self.transaction.step(self.next_step, &self.line);
        self.next_step += 1;
        match &step {
            Some(Step::Send(packet)) => {
                self.set_outgoing(packet);
                self.send(now_us);
            }
            Some(Step::SendRequest) => self.send(now_us),
            Some(Step::Repeat(byte, count)) => {
                self.outgoing.clear();
                let count = usize::from(*count).min(self.outgoing.capacity());
                // There is room.
                let _ = self.outgoing.resize(count, *byte);
                self.send(now_us);
            }
            Some(wait @ (Step::Pause { .. } | Step::Listen(..))) => self.wait(wait, now_us),
            None => {
                self.bus.release();
                self.echo.classify_bus();
                self.phase = Phase::Idle;
            }
        }
    }

    /// Enters a step that begins at `from_us` and sends nothing.
    #[inline]
    fn wait(&mut self, step: &Step, from_us: u64) {
        match *step {
            Step::Pause { us } => {
                self.phase = Phase::Pausing {
                    until_us: from_us + u64::from(us),
                };
            }
            Step::Listen(expected, window_us) => {
                self.receiver.begin(expected, &self.line);
                self.phase = Phase::Listening {
                    until_us: from_us + window_us,
                };
            }
            Step::Send(_) | Step::SendRequest | Step::Repeat(..) => {}
        }
    }

    /// Sets the bytes to be sent, at most as many as a transmission can have.
    pub(super) fn set_outgoing(&mut self, bytes: &[u8]) {
        self.outgoing.clear();
        // Every packet of the bridge is shorter than the longest, and requests are checked.
        let _ = self.outgoing.extend_from_slice(bytes);
    }

    /// Begins the transmission.
    fn send(&mut self, now_us: u64) {
        let next = self.transaction.step(self.next_step, &self.line);
        let after = match next {
            Some(Step::Listen(..)) | None => LineAfter::Released,
            Some(_) => LineAfter::Driven,
        };
        self.echo.begin(self.outgoing.len());
        self.bus.send(&self.outgoing, after);
        let begun_us = now_us + u64::from(self.bus.send_delay_us());
        self.active_us = begun_us + bytes_us(self.outgoing.len() as u32, self.line.baud);
        self.phase = Phase::Sending {
            until_us: match self.bus.transmission() {
                Transmission::Waiting => now_us + bytes_us(1, self.line.baud),
                Transmission::Sending | Transmission::Complete => self.active_us,
            },
        };
        if let (true, Some(wait @ (Step::Pause { .. } | Step::Listen(..)))) =
            (B::RELEASES_BY_ITSELF, &next)
        {
            self.next_step += 1;
            self.wait(wait, self.active_us);
        }
    }

    /// Takes the received bytes, about a receive buffer's worth at most: a bus that reports
    /// errors for ever must not delay the tick.
    pub(super) fn drain(&mut self, now_us: u64) {
        let is_listening = matches!(self.phase, Phase::Listening { .. });
        let mut taken = 0;
        while taken < DRAIN_MAX {
            let Received { bytes, error } = self.bus.received();
            if bytes.is_empty() && error.is_none() {
                return;
            }
            taken += bytes.len() + usize::from(error.is_some());
            let bytes = self.echo.strip(bytes, &self.outgoing);
            if self.is_tapped && !bytes.is_empty() {
                for byte in bytes {
                    // Bytes that are not taken in time: the newest are lost.
                    let _ = self.rx_tap.push_back(*byte);
                }
                self.active_us = self.active_us.max(now_us);
            }
            // Outside a window no request is pending, so no byte is a reply.
            if is_listening {
                self.receiver.push(bytes, self.line.ids);
                if error.is_some() {
                    self.receiver.line_error();
                }
            }
        }
    }
}
