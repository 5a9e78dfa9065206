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
//! Both messages are 16 bytes, little endian, on a channel of their own.

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
}

/// Length of either message.
pub const MESSAGE_LEN: usize = 16;

impl Idle {
    /// As sent.
    pub fn to_bytes(self) -> [u8; MESSAGE_LEN] {
        let bus = u32::from(self.bus_wanted.unwrap_or(0)) << 16 | u32::from(self.bus_tx);
        to_bytes(self.until_us, bus, self.link_tx)
    }

    /// As received.
    pub fn from_bytes(bytes: [u8; MESSAGE_LEN]) -> Self {
        let (until_us, bus, link_tx) = from_bytes(bytes);
        let bus_wanted = Some((bus >> 16) as u16).filter(|wanted| *wanted > 0);
        Self {
            until_us,
            bus_wanted,
            bus_tx: bus as u16,
            link_tx,
        }
    }
}

impl Grant {
    /// As sent.
    pub fn to_bytes(self) -> [u8; MESSAGE_LEN] {
        to_bytes(self.now_us, self.bus_rx, self.link_rx)
    }

    /// As received.
    pub fn from_bytes(bytes: [u8; MESSAGE_LEN]) -> Self {
        let (now_us, bus_rx, link_rx) = from_bytes(bytes);
        Self {
            now_us,
            bus_rx,
            link_rx,
        }
    }
}

fn to_bytes(time: u64, bus: u32, link: u32) -> [u8; MESSAGE_LEN] {
    (u128::from(time) | u128::from(bus) << 64 | u128::from(link) << 96).to_le_bytes()
}

fn from_bytes(bytes: [u8; MESSAGE_LEN]) -> (u64, u32, u32) {
    let all = u128::from_le_bytes(bytes);
    (all as u64, (all >> 64) as u32, (all >> 96) as u32)
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
        };
        assert_eq!(idle.to_bytes()[..12], [8, 7, 6, 5, 4, 3, 2, 1, 9, 0, 14, 0]);
        assert_eq!(Idle::from_bytes(idle.to_bytes()), idle);
    }
}
