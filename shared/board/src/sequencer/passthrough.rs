//! Passthrough: a client's packets relayed unchanged, replies tapped.
//!
//! It begins with stops, so that the client finds every motor off. The speeds that
//! a client uses are recorded: a stop at each of them precedes the return of the bus.

use super::idle_request::Owner;
use super::stop_plan::add_speed;
use super::{BusSequencer, State};
use armbridge_link::record::Permission;
use armbridge_servo::ClientFrame;
use armbridge_servo::bus::Bus;
use armbridge_servo::port::SERVO_BAUD;

impl<B: Bus> BusSequencer<B> {
    /// Whether a client's packet would be relayed now.
    pub fn is_passthrough(&self) -> bool {
        self.state == State::Passthrough
            && self.permission == Permission::Passthrough
            && !self.is_stopping()
            && self.is_idle()
    }

    /// Relays a client's packet unchanged, at the client's speed; whether it was sent.
    /// A packet that wedges servos is never sent: only power-off releases them.
    pub fn relay(&mut self, frame: &ClientFrame<'_>, baud: u32) -> bool {
        if !self.is_passthrough() || frame.wedges_servo() {
            return false;
        }
        let firmware = frame
            .request()
            .map_or(self.firmware(), |request| request.firmware);
        let baud = Some(baud)
            .filter(|baud| SERVO_BAUD.contains(baud) && *baud <= B::BAUD_MAX)
            .unwrap_or(self.baud());
        add_speed(&mut self.client_speeds, baud);
        let _ = self.master.set_line(firmware, baud);
        let expected = frame.expected_reply();
        let is_sent = self
            .master
            .request(frame.bytes(), expected, self.now_us)
            .is_ok();
        if is_sent {
            self.owner = Some(Owner::Relay);
            let _ = self.master.poll(self.now_us);
        }
        is_sent
    }

    /// Takes the oldest byte that servos have sent in passthrough.
    pub fn take_tapped(&mut self) -> Option<u8> {
        self.master.take_tapped()
    }

    /// Begins passthrough, after stops that switch every motor off.
    pub(super) fn begin_passthrough(&mut self) {
        self.plan_stops();
        let baud = self.baud();
        add_speed(&mut self.client_speeds, baud);
        self.state = State::Passthrough;
        self.next_us = self.now_us;
    }

    /// Ends passthrough: a stop and a new search follow.
    pub(super) fn end_passthrough(&mut self) {
        self.is_tapping = false;
        self.master.set_rx_tap(false);
        self.off.discard_evidence();
        self.search();
    }
}
