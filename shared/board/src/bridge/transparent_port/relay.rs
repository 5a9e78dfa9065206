//! Relay: passes the client's packets to the bus, and every byte from it to the client,
//! while that has the bus.
//!
//! A relayed packet needs the supervisor's permission at that moment; the sequencer checks
//! it. A client that has sent a packet that may drive a motor, and then is silent for
//! longer than [`client_silence_ms`](armbridge_link::limits::Limits::client_silence_ms),
//! loses the bus: the stop sequence and a new search for the servos follow.

use super::super::Bridge;
use armbridge_servo::bus::Bus;

impl<B: Bus> Bridge<'_, B> {
    /// Sends the client's packet unchanged; the client has the bus, and it is idle.
    pub(in crate::bridge) fn relay(&mut self) {
        // A request from the idle slots of ticks is dropped.
        self.port.pending = None;
        let Some(kind) = self.port.waiting.take() else {
            return;
        };
        let baud = self.end.client.line().baud;
        let frame = self.port.framer.frame(kind);
        let may_drive = frame.may_drive();
        let is_sent = self.sequencer.relay(&frame, baud);
        if is_sent {
            self.port.relayed_us = self.core.now_us();
            self.port.may_have_driven |= may_drive;
        }
        self.port.count(is_sent);
    }

    /// The time at which a client that may have set a motor moving has been silent for too
    /// long.
    pub(super) fn client_silent_at_us(&self) -> Option<u64> {
        let silence_ms = self.core.config().limits().client_silence_ms;
        let watched = self.port.may_have_driven && silence_ms > 0;
        watched.then(|| {
            let since_us = self.port.relayed_us;
            since_us.saturating_add(u64::from(silence_ms) * 1_000)
        })
    }
}
