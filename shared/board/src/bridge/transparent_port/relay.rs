//! Relay: passes the client's packets to the bus, and every byte from it to the client,
//! while that has the bus.
//!
//! A relayed packet needs the supervisor's permission at that moment; the sequencer checks
//! it. A client that has sent a packet that may drive a motor, and then is silent for
//! longer than [`client_silence_ms`](armbridge_link::limits::Limits::client_silence_ms),
//! loses the bus: the stop sequence and a new search for the servos follow.

use super::TransparentPort;
use crate::sequencer::BusSequencer;
use armbridge_link::message::Limits;
use armbridge_servo::bus::Bus;

impl TransparentPort<'_> {
    /// Sends the client's packet unchanged; the client has the bus, and it is idle.
    pub(in crate::bridge) fn relay<B: Bus>(
        &mut self,
        sequencer: &mut BusSequencer<B>,
        now_us: u64,
    ) {
        // A request from the idle slots of ticks is dropped.
        self.pending = None;
        let Some(kind) = self.waiting.take() else {
            return;
        };
        let baud = self.client.line().baud;
        let frame = self.framer.frame(kind);
        let may_drive = frame.may_drive();
        let is_sent = sequencer.relay(&frame, baud);
        if is_sent {
            self.relayed_us = now_us;
            self.may_have_driven |= may_drive;
        }
        self.count(is_sent);
    }

    /// The time at which a client that may have set a motor moving has been silent for too
    /// long.
    pub(super) fn silent_at_us(&self, limits: &Limits) -> Option<u64> {
        let watched = self.may_have_driven && limits.client_silence_ms > 0;
        watched.then(|| {
            let silence_us = u64::from(limits.client_silence_ms) * 1_000;
            self.relayed_us.saturating_add(silence_us)
        })
    }
}
