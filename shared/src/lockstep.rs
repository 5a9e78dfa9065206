//! Virtual time for an emulated board.
//!
//! An emulator runs as fast as its host lets it, so a wall clock between board
//! and virtual servos would make every run different. In lockstep the bench
//! owns the time: a board with nothing left to do says [`Idle`], until when it
//! would sleep and how many bytes it has sent; the bench advances servos and
//! arm to the next instant that concerns the board and answers with a
//! [`Grant`]: what the time is now and how many bytes have been sent to it.
//! Each side waits for the bytes that were announced before it goes on, so
//! that nothing depends on how busy the machine is.
//!
//! Both messages are 24 bytes, little endian, on a channel of their own. An
//! emulated serial port has no speed and no modem lines, so they carry those of
//! the servo bus and of the transparent port.

use crate::bridge::gateway::ClientLine;

/// From board to bench: nothing to do.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Idle {
    /// When the board wants to run again at the latest, in µs.
    pub until_us: u64,
    /// How many bytes on the servo bus make it run before that, if any do.
    pub bus_wanted: Option<u16>,
    /// Bytes sent on the servo bus since boot, modulo 2¹⁶.
    pub bus_tx: u16,
    /// Bytes sent on the link since boot, modulo 2³².
    pub link_tx: u32,
    /// Bytes sent to the client of the transparent port, modulo 2³².
    pub client_tx: u32,
    /// Speed of the servo bus in bits per second.
    pub bus_baud: u32,
}

/// From bench to board: run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Grant {
    /// The time, in µs.
    pub now_us: u64,
    /// Bytes put on the servo bus for the board since boot, modulo 2³².
    pub bus_rx: u32,
    /// Bytes put on the link for the board since boot, modulo 2³².
    pub link_rx: u32,
    /// Bytes from the client of the transparent port since boot, modulo 2³².
    pub client_rx: u32,
    /// What that client has set its port to.
    pub client_line: ClientLine,
    /// The emergency stop's switch is open.
    pub is_stop_pressed: bool,
}

/// Set in the time of a [`Grant`] if the switch is open: no clock gets there.
const STOP_PRESSED: u64 = 1 << 63;

/// Length of either message.
pub const MESSAGE_LEN: usize = 24;

impl Idle {
    /// As sent.
    pub fn to_bytes(self) -> [u8; MESSAGE_LEN] {
        let bus = u32::from(self.bus_wanted.unwrap_or(0)) << 16 | u32::from(self.bus_tx);
        to_bytes(
            self.until_us,
            [bus, self.link_tx, self.client_tx, self.bus_baud],
        )
    }

    /// As received.
    pub fn from_bytes(bytes: [u8; MESSAGE_LEN]) -> Self {
        let (until_us, [bus, link_tx, client_tx, bus_baud]) = from_bytes(bytes);
        let bus_wanted = Some((bus >> 16) as u16).filter(|wanted| *wanted > 0);
        Self {
            until_us,
            bus_wanted,
            bus_tx: bus as u16,
            link_tx,
            client_tx,
            bus_baud,
        }
    }
}

impl Grant {
    /// As sent.
    pub fn to_bytes(self) -> [u8; MESSAGE_LEN] {
        let line = self.client_line.to_bits();
        let stop = if self.is_stop_pressed {
            STOP_PRESSED
        } else {
            0
        };
        to_bytes(
            self.now_us & !STOP_PRESSED | stop,
            [self.bus_rx, self.link_rx, self.client_rx, line],
        )
    }

    /// As received.
    pub fn from_bytes(bytes: [u8; MESSAGE_LEN]) -> Self {
        let (time, [bus_rx, link_rx, client_rx, line]) = from_bytes(bytes);
        Self {
            now_us: time & !STOP_PRESSED,
            bus_rx,
            link_rx,
            client_rx,
            is_stop_pressed: time & STOP_PRESSED != 0,
            client_line: ClientLine::from_bits(line),
        }
    }
}

fn to_bytes(time: u64, words: [u32; 4]) -> [u8; MESSAGE_LEN] {
    let mut bytes = [0; MESSAGE_LEN];
    let words = words.into_iter().flat_map(u32::to_le_bytes);
    for (slot, byte) in bytes
        .iter_mut()
        .zip(time.to_le_bytes().into_iter().chain(words))
    {
        *slot = byte;
    }
    bytes
}

fn from_bytes(bytes: [u8; MESSAGE_LEN]) -> (u64, [u32; 4]) {
    let (time, words) = bytes.split_at(8);
    let mut rest = words.chunks_exact(4).map(little);
    let words = [0; 4].map(|_: u64| rest.next().unwrap_or_default() as u32);
    (little(time), words)
}

fn little(bytes: &[u8]) -> u64 {
    bytes
        .iter()
        .rev()
        .fold(0, |value, byte| value << 8 | u64::from(*byte))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fields_keep_their_places() {
        let idle = Idle {
            until_us: 0x0102_0304_0506_0708,
            bus_wanted: Some(14),
            bus_tx: 9,
            link_tx: u32::MAX,
            client_tx: 5,
            bus_baud: 57_142,
        };
        assert_eq!(idle.to_bytes()[..12], [8, 7, 6, 5, 4, 3, 2, 1, 9, 0, 14, 0]);
        assert_eq!(Idle::from_bytes(idle.to_bytes()), idle);
        let grant = Grant {
            now_us: 1 << 40,
            bus_rx: 1,
            link_rx: 2,
            client_rx: 3,
            client_line: ClientLine {
                is_open: true,
                baud: 1_000_000,
            },
            is_stop_pressed: true,
        };
        assert_eq!(Grant::from_bytes(grant.to_bytes()), grant);
        let released = Grant {
            is_stop_pressed: false,
            ..grant
        };
        assert_eq!(Grant::from_bytes(released.to_bytes()), released);
    }
}
