//! The bus while it is the client's: its packets as they came, and every byte that
//! is heard.

use embedded_hal::digital::OutputPin;
use embedded_hal_nb::serial::{Read, Write};

use super::super::Bridge;
use crate::servo::port::SetBaud;

/// Rates that a client may set: what an AX-12A can do, in bits per second.
const CLIENT_BAUD: core::ops::RangeInclusive<u32> = 7_800..=2_000_000;

impl<S, D> Bridge<'_, S, D>
where
    S: Read<u8> + Write<u8> + SetBaud,
    D: OutputPin,
{
    /// The bus is the client's: its packet goes out as it came.
    pub(super) fn relay(&mut self) {
        if !self.gateway.relays {
            self.gateway.relays = true;
            // What was asked in the slack of ticks is answered there or never.
            self.gateway.job = None;
            self.master.listen_in(true);
        }
        if self.stop_due {
            return;
        }
        let Some(item) = self.gateway.item.take() else {
            return;
        };
        let frame = self.gateway.framer.frame(item);
        let firmware = frame.request().map(|request| request.firmware);
        let line = self.end.client.line();
        let baud = Some(line.baud).filter(|baud| CLIENT_BAUD.contains(baud));
        // Idle was just seen: it is not busy.
        let _ = self.master.set_line(
            firmware.unwrap_or(self.master.firmware()),
            baud.unwrap_or(self.master.baud()),
        );
        // Never what wedges: only switching their power off brings servos back.
        let sent = !frame.wedges_servo()
            && self
                .master
                .ask(frame.bytes(), frame.expected_reply(), self.now_us)
                .is_ok();
        self.count(sent);
        let _ = self.master.poll(self.now_us);
    }

    /// The bus is no longer the client's; what it has said since is not obeyed.
    pub(in crate::bridge) fn end_relay(&mut self) {
        self.gateway.relays = false;
        self.gateway.was_open = false;
        self.master.listen_in(false);
    }
}
