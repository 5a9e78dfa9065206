//! The bus while it is the client's: its packets as they came, and every byte that
//! is heard.
//!
//! A relayed packet needs the supervisor's leave at that moment; the sequencer sees to
//! that. A client that has said what may drive a motor and then is silent for longer
//! than [`client_silence_ms`](crate::link::limits::Limits::client_silence_ms) loses the
//! bus: motors are told off, and the servos are looked for anew.

use embedded_hal::digital::OutputPin;
use embedded_hal_nb::serial::{Read, Write};

use super::super::Bridge;
use crate::servo::port::SetBaud;

impl<S, D> Bridge<'_, S, D>
where
    S: Read<u8> + Write<u8> + SetBaud,
    D: OutputPin,
{
    /// The bus is lent and idle: the client's packet goes out as it came.
    pub(in crate::bridge) fn relay(&mut self) {
        // What was asked in the idle slots of ticks is answered there or never.
        self.gateway.job = None;
        let Some(item) = self.gateway.item.take() else {
            return;
        };
        let baud = self.end.client.line().baud;
        let frame = self.gateway.framer.frame(item);
        let may_drive = frame.may_drive();
        let is_sent = self.sequencer.relay(&frame, baud);
        if is_sent {
            self.gateway.relayed_us = self.core.now_us();
            self.gateway.may_have_driven |= may_drive;
        }
        self.gateway.count(is_sent);
    }

    /// When a client that may have set a motor moving has been silent for too long.
    pub(super) fn client_silent_at_us(&self) -> Option<u64> {
        let silence_ms = self.core.config().limits().client_silence_ms;
        let watched = self.gateway.may_have_driven && silence_ms > 0;
        watched.then(|| {
            let since_us = self.gateway.relayed_us;
            since_us.saturating_add(u64::from(silence_ms) * 1_000)
        })
    }
}
