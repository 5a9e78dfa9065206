//! Virtual time for an emulated board.
//!
//! An emulator runs as fast as its host lets it, so a wall clock between board
//! and virtual servos would make every run different. In lockstep the bench
//! owns the time: a board with nothing left to do sends a [`TimeRequest`], until when
//! it would sleep, with all that it has sent meanwhile; the bench advances servos
//! and arm to the next instant that concerns the board and answers with a
//! [`TimeGrant`], what the time is now, with all that has arrived at the board's
//! ports by then. While one side runs, the other waits, so that nothing depends
//! on how busy the machine is.
//!
//! # On the wire
//!
//! Both go over one stream, as a header of [`HEADER_LEN`] bytes, little endian,
//! and its payload of the length in [`PayloadLens`]. Handing over a block costs the
//! emulator some microseconds and a byte of an emulated serial port costs it tens, so
//! everything that is due at an instant travels in one message. What does not fit
//! [`MESSAGE_MAX`] is spread over several, all of one instant, of which only the
//! last is marked as the last; the others' headers are about the same.
//!
//! | bytes | of a [`TimeRequest`]                | of a [`TimeGrant`]                |
//! |-------|-------------------------------------|-----------------------------------|
//! | 0–7   | time; bit 62: others follow         | the same, and bit 63: stop switch |
//! | 8–13  | bytes of link, client, bus, 16 bits each | the same                     |
//! | 14–15 | bytes wanted from the bus           | 0                                 |
//! | 16–19 | speed of the bus                    | the client's line                 |
//! | 20–23 | room for bytes of the client        | 0                                 |
//!
//! Nothing in here has the speed and the modem lines that serial ports have, so
//! headers carry those of the servo bus and of the transparent port.

use crate::bridge::transparent_port::ClientLine;

/// Length of a header.
pub const HEADER_LEN: usize = 24;

/// Longest message, its header included: some ticks' records.
pub const MESSAGE_MAX: usize = 2_048;

/// Set in the time if other messages of the same instant follow.
const MORE: u64 = 1 << 62;
/// Set in the time of a [`TimeGrant`] if the switch is open.
const STOP_PRESSED: u64 = 1 << 63;
/// Where no clock gets: the end of time.
const LATEST_US: u64 = MORE - 1;

/// Number of bytes that follow a header, in this order.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct PayloadLens {
    /// Of the control link.
    pub link: u16,
    /// Of the transparent port.
    pub client: u16,
    /// Of the servo bus.
    pub bus: u16,
}

/// From board to bench: nothing to do.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TimeRequest {
    /// When the board wants to run again at the latest, in µs.
    pub until_us: u64,
    /// Number of bytes on the servo bus that make it run before that, if any do.
    pub bus_wanted: Option<u16>,
    /// Speed of the servo bus in bits per second.
    pub bus_baud: u32,
    /// Free space in bytes for the client of the transparent port.
    pub client_room: u32,
    /// Bytes sent since the last grant.
    pub lens: PayloadLens,
    /// There is no more of that in another message.
    pub is_last: bool,
}

/// From bench to board: run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TimeGrant {
    /// The time, in µs.
    pub now_us: u64,
    /// Serial settings of the client of the transparent port.
    pub client_line: ClientLine,
    /// The emergency stop's switch is open.
    pub is_stop_pressed: bool,
    /// Bytes received since the last grant.
    pub lens: PayloadLens,
    /// There is no more of that in another message.
    pub is_last: bool,
}

impl PayloadLens {
    /// All of them.
    pub fn total(self) -> usize {
        self.lengths().into_iter().sum()
    }

    /// The bytes of link, client and bus after the header; `None` if some are missing.
    pub fn split(self, bytes: &[u8]) -> Option<[&[u8]; 3]> {
        let [link, client, bus] = self.lengths();
        let (link, rest) = bytes.split_at_checked(link)?;
        let (client, rest) = rest.split_at_checked(client)?;
        Some([link, client, rest.get(..bus)?])
    }

    fn lengths(self) -> [usize; 3] {
        [self.link, self.client, self.bus].map(usize::from)
    }
}

impl TimeRequest {
    /// As sent.
    pub fn to_bytes(self) -> [u8; HEADER_LEN] {
        let more = if self.is_last { 0 } else { MORE };
        Header {
            time: self.until_us.min(LATEST_US) | more,
            lens: self.lens,
            short: self.bus_wanted.unwrap_or(0),
            words: [self.bus_baud, self.client_room],
        }
        .to_bytes()
    }

    /// As received.
    pub fn from_bytes(bytes: [u8; HEADER_LEN]) -> Self {
        let header = Header::from_bytes(bytes);
        let [bus_baud, client_room] = header.words;
        Self {
            until_us: header.time & LATEST_US,
            bus_wanted: Some(header.short).filter(|wanted| *wanted > 0),
            bus_baud,
            client_room,
            lens: header.lens,
            is_last: header.time & MORE == 0,
        }
    }
}

impl TimeGrant {
    /// As sent.
    pub fn to_bytes(self) -> [u8; HEADER_LEN] {
        let more = if self.is_last { 0 } else { MORE };
        let stop = if self.is_stop_pressed {
            STOP_PRESSED
        } else {
            0
        };
        Header {
            time: self.now_us.min(LATEST_US) | more | stop,
            lens: self.lens,
            short: 0,
            words: [self.client_line.to_bits(), 0],
        }
        .to_bytes()
    }

    /// As received.
    pub fn from_bytes(bytes: [u8; HEADER_LEN]) -> Self {
        let header = Header::from_bytes(bytes);
        let [line, _] = header.words;
        Self {
            now_us: header.time & LATEST_US,
            client_line: ClientLine::from_bits(line),
            is_stop_pressed: header.time & STOP_PRESSED != 0,
            lens: header.lens,
            is_last: header.time & MORE == 0,
        }
    }
}

/// Bytes common to both.
struct Header {
    time: u64,
    lens: PayloadLens,
    short: u16,
    words: [u32; 2],
}

impl Header {
    fn to_bytes(&self) -> [u8; HEADER_LEN] {
        let PayloadLens { link, client, bus } = self.lens;
        let shorts = [link, client, bus, self.short].map(u16::to_le_bytes);
        let words = self.words.map(u32::to_le_bytes);
        let mut bytes = [0; HEADER_LEN];
        let sent = self.time.to_le_bytes().into_iter();
        let sent = sent.chain(shorts.into_iter().flatten());
        for (slot, byte) in bytes
            .iter_mut()
            .zip(sent.chain(words.into_iter().flatten()))
        {
            *slot = byte;
        }
        bytes
    }

    fn from_bytes(bytes: [u8; HEADER_LEN]) -> Self {
        let (time, rest) = bytes.split_at(8);
        let (shorts, words) = rest.split_at(8);
        let mut shorts = shorts.chunks_exact(2).map(little);
        let mut short = || shorts.next().unwrap_or_default() as u16;
        let mut words = words.chunks_exact(4).map(little);
        Self {
            time: little(time),
            lens: PayloadLens {
                link: short(),
                client: short(),
                bus: short(),
            },
            short: short(),
            words: [0; 2].map(|_: u64| words.next().unwrap_or_default() as u32),
        }
    }
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

    const LENS: PayloadLens = PayloadLens {
        link: 2,
        client: 0,
        bus: 1,
    };

    #[test]
    fn fields_keep_their_places() {
        let request = TimeRequest {
            until_us: 0x0102_0304_0506_0708,
            bus_wanted: Some(14),
            bus_baud: 57_142,
            client_room: 256,
            lens: PayloadLens {
                link: 0x0201,
                client: 0x0403,
                bus: 0x0605,
            },
            is_last: true,
        };
        let bytes = [
            8, 7, 6, 5, 4, 3, 2, 1, 1, 2, 3, 4, 5, 6, 14, 0, 0x36, 0xDF, 0, 0, 0, 1, 0, 0,
        ];
        assert_eq!(request.to_bytes(), bytes);
        for is_last in [false, true] {
            let request = TimeRequest { is_last, ..request };
            assert_eq!(TimeRequest::from_bytes(request.to_bytes()), request);
        }
        for (is_stop_pressed, is_last) in
            [(false, false), (false, true), (true, false), (true, true)]
        {
            let grant = TimeGrant {
                now_us: 1 << 40,
                client_line: ClientLine {
                    is_open: true,
                    baud: 1_000_000,
                },
                is_stop_pressed,
                lens: LENS,
                is_last,
            };
            assert_eq!(TimeGrant::from_bytes(grant.to_bytes()), grant);
        }
    }

    #[test]
    fn bytes_are_told_apart_once_all_are_there() {
        assert_eq!(LENS.total(), 3);
        let parts: [&[u8]; 3] = [&[7, 8], &[], &[9]];
        assert_eq!(LENS.split(&[7, 8, 9]), Some(parts));
        assert_eq!(LENS.split(&[7, 8, 9, 10]), Some(parts), "the next one's");
        assert_eq!(LENS.split(&[7, 8]), None);
    }
}
