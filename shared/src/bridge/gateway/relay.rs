//! The bus while it is the client's: its packets as they came, and every byte that
//! is heard.

use embedded_hal::digital::OutputPin;
use embedded_hal_nb::serial::{Read, Write};

use super::super::Bridge;
use super::{Item, is_deafening};
use crate::servo::Firmware;
use crate::servo::master::Asked;
use crate::servo::master::timing::latency_us;
use crate::servo::port::SetBaud;

/// START is answered 4.74 ms times the id later: enough for the first few.
const START_LATENCY_US: u32 = 20_000;

/// Rates that a client may set: what an AX-12A can do, in bits per second.
const CLIENT_BAUD: core::ops::RangeInclusive<u32> = 7_800..=2_000_000;

/// Places in packets, from the header on.
mod place {
    pub(super) const STOCK_ID: usize = 2;
    pub(super) const STOCK_INSTRUCTION: usize = 4;
    pub(super) const STOCK_COUNT: usize = 6;
    pub(super) const MORPHEUS_DESTINATION: usize = 2;
    pub(super) const MORPHEUS_COMMAND: usize = 4;
    pub(super) const MORPHEUS_COUNT: usize = 6;
}

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
        let firmware = match item {
            Item::Packet(firmware) => firmware,
            Item::Raw => self.master.firmware(),
        };
        let line = self.end.client.line();
        let baud = Some(line.baud).filter(|baud| CLIENT_BAUD.contains(baud));
        // Idle was just seen: it is not busy.
        let _ = self
            .master
            .set_line(firmware, baud.unwrap_or(self.master.baud()));
        let packet = self.gateway.framer.bytes();
        let asked = match item {
            // Never that: only switching their power off brings servos back.
            Item::Packet(Firmware::Morpheus) if is_deafening(packet) => None,
            Item::Packet(firmware) => Some(expected(firmware, packet)),
            Item::Raw => Some(NOTHING),
        };
        let sent =
            asked.is_some_and(|asked| self.master.ask(packet, asked, self.core.now_us()).is_ok());
        self.count(sent);
        let _ = self.master.poll(self.core.now_us());
    }

    /// The bus is no longer the client's; what it has said since is not obeyed.
    pub(in crate::bridge) fn end_relay(&mut self) {
        self.gateway.relays = false;
        self.gateway.was_open = false;
        self.master.listen_in(false);
    }
}

/// A packet that nobody answers.
const NOTHING: Asked = Asked {
    id: 0,
    reply_bytes: 0,
    latency_us: 0,
};

/// What a packet of the client's will be answered, so that the next does not
/// fall into it.
fn expected(firmware: Firmware, packet: &[u8]) -> Asked {
    use place::{
        MORPHEUS_COMMAND, MORPHEUS_COUNT, MORPHEUS_DESTINATION, STOCK_COUNT, STOCK_ID,
        STOCK_INSTRUCTION,
    };
    let at = |place: usize| packet.get(place).copied().unwrap_or_default();
    let (id, reply_bytes, latency_us) = match firmware {
        Firmware::Stock => {
            let (id, instruction) = (at(STOCK_ID), at(STOCK_INSTRUCTION));
            match (id, instruction) {
                // Of all, PING alone is answered.
                (0xFE, 1) => (id, 6, latency_us(firmware)),
                (0xFE, _) => return NOTHING,
                (_, 2) => (id, at(STOCK_COUNT).saturating_add(6), latency_us(firmware)),
                _ => (id, 6, latency_us(firmware)),
            }
        }
        Firmware::Morpheus => {
            let (id, command) = (at(MORPHEUS_DESTINATION), at(MORPHEUS_COMMAND));
            match (id, command) {
                (0xFF, 6) => (id, 6, START_LATENCY_US),
                // Two positions.
                (0xFF, 7) => (id, 14, latency_us(firmware)),
                (0xFF, _) => return NOTHING,
                (_, 2) => (
                    id,
                    at(MORPHEUS_COUNT).saturating_add(5),
                    latency_us(firmware),
                ),
                _ => (id, 6, latency_us(firmware)),
            }
        }
    };
    Asked {
        id,
        reply_bytes,
        latency_us,
    }
}
