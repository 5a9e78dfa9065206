//! The bus lent to a client: packets relayed as they came, replies tapped.
//!
//! Lending begins with stops, so that the client finds every motor off. The speeds that
//! a client uses are kept: the bus comes back by a stop at each of them.

use super::idle_request::Owner;
use super::stop_plan::add_speed;
use super::{BusLeave, BusSequencer, State};
use crate::servo::ClientFrame;
use crate::servo::port::SetBaud;
use embedded_hal::digital::OutputPin;
use embedded_hal_nb::serial::{Read, Write};

/// Rates that a client may set: what an AX-12A can do, in bits per second.
const CLIENT_BAUD: core::ops::RangeInclusive<u32> = 7_800..=2_000_000;

impl<S, D> BusSequencer<S, D>
where
    S: Read<u8> + Write<u8> + SetBaud,
    D: OutputPin,
{
    /// Whether a client's packet would be relayed now.
    pub fn is_lent(&self) -> bool {
        self.state == State::Lent
            && self.leave == BusLeave::Lend
            && !self.is_stopping()
            && self.is_idle()
    }

    /// Relays a client's packet as it came, at the client's speed; whether it was sent.
    /// Never one that wedges servos: only switching their power off brings them back.
    pub fn relay(&mut self, frame: &ClientFrame<'_>, baud: u32) -> bool {
        if !self.is_lent() || frame.wedges_servo() {
            return false;
        }
        let firmware = frame
            .request()
            .map_or(self.firmware(), |request| request.firmware);
        let baud = Some(baud)
            .filter(|baud| CLIENT_BAUD.contains(baud))
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

    /// The oldest byte that servos have sent while the bus is lent.
    pub fn take_tapped(&mut self) -> Option<u8> {
        self.master.take_tapped()
    }

    /// The client finds every motor off.
    pub(super) fn lend(&mut self) {
        self.plan_stops();
        let baud = self.baud();
        add_speed(&mut self.client_speeds, baud);
        self.state = State::Lent;
        self.next_us = self.now_us;
    }

    pub(super) fn take_back(&mut self) {
        self.is_listening = false;
        self.master.set_rx_tap(false);
        self.off.forget();
        self.search();
    }
}
