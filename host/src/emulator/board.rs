//! The emulated board in virtual time.
//!
//! Each run is one exchange: bytes that have arrived go to the board's serial
//! ports, then the grant; the board answers, when it has nothing left to do,
//! with until when and how much it has sent, and that much is waited for. No
//! clock is involved, so a busy machine changes nothing but how long it takes.

use std::io::{self, Read, Write};
use std::time::Duration;

use armbridge_shared::lockstep::{Grant, Idle, MESSAGE_LEN};

use super::qemu::{Qemu, QemuError};
use crate::bench::board::{Board, Input, Output, Wake};

/// A board that says nothing for so long is not busy but dead.
const DEAD_AFTER: Duration = Duration::from_secs(30);

/// More than a board can have sent in one run: its mailboxes hold 64 records.
const RUN_MAX: u32 = 1 << 16;

/// A board under QEMU that waits for grants.
#[derive(Debug)]
pub struct EmulatedBoard {
    qemu: Qemu,
    bus_rx: u32,
    link_rx: u32,
    client_rx: u32,
    bus_tx: u16,
    link_tx: u32,
    client_tx: u32,
}

impl EmulatedBoard {
    /// Takes over an emulator started in lockstep, and waits until its board
    /// has booted.
    ///
    /// # Errors
    /// If the board does not come up.
    pub fn new(qemu: Qemu) -> Result<Self, QemuError> {
        for socket in [&qemu.link, &qemu.bus, &qemu.client] {
            socket.set_read_timeout(Some(DEAD_AFTER))?;
        }
        qemu.clock.set_read_timeout(Some(DEAD_AFTER))?;
        let mut board = Self {
            qemu,
            bus_rx: 0,
            link_rx: 0,
            client_rx: 0,
            bus_tx: 0,
            link_tx: 0,
            client_tx: 0,
        };
        let idle = board
            .read_idle()
            .map_err(|error| board.qemu.explain(error))?;
        let boot = (idle.bus_tx, idle.link_tx);
        if boot == (0, 0) {
            Ok(board)
        } else {
            Err(QemuError::Died(format!(
                "the board sent {boot:?} bytes before its first grant"
            )))
        }
    }

    fn read_idle(&mut self) -> io::Result<Idle> {
        let mut bytes = [0; MESSAGE_LEN];
        self.qemu.clock.read_exact(&mut bytes)?;
        Ok(Idle::from_bytes(bytes))
    }

    fn exchange(&mut self, now_us: u64, input: Input<'_>, output: &mut Output) -> io::Result<Wake> {
        self.qemu.bus.write_all(input.bus)?;
        self.qemu.link.write_all(input.link)?;
        self.qemu.client.write_all(input.client)?;
        self.bus_rx = self.bus_rx.wrapping_add(input.bus.len() as u32);
        self.link_rx = self.link_rx.wrapping_add(input.link.len() as u32);
        self.client_rx = self.client_rx.wrapping_add(input.client.len() as u32);
        let grant = Grant {
            now_us,
            bus_rx: self.bus_rx,
            link_rx: self.link_rx,
            client_rx: self.client_rx,
            client_line: input.line,
            is_stop_pressed: input.is_stop_pressed,
        };
        self.qemu.clock.write_all(&grant.to_bytes())?;
        let idle = self.read_idle()?;
        let bus = u32::from(idle.bus_tx.wrapping_sub(self.bus_tx));
        let link = idle.link_tx.wrapping_sub(self.link_tx);
        let client = idle.client_tx.wrapping_sub(self.client_tx);
        (self.bus_tx, self.link_tx) = (idle.bus_tx, idle.link_tx);
        self.client_tx = idle.client_tx;
        output.bus_baud = idle.bus_baud;
        read_announced(&mut self.qemu.bus, bus, &mut output.bus)?;
        read_announced(&mut self.qemu.link, link, &mut output.link)?;
        read_announced(&mut self.qemu.client, client, &mut output.client)?;
        Ok(Wake {
            at_us: idle.until_us,
            bus_bytes: idle.bus_wanted.map(usize::from),
        })
    }
}

fn read_announced(from: &mut impl Read, announced: u32, into: &mut Vec<u8>) -> io::Result<()> {
    if announced > RUN_MAX {
        let said = format!("the board announced {announced} bytes: is the image of this version?");
        return Err(io::Error::new(io::ErrorKind::InvalidData, said));
    }
    let begin = into.len();
    into.resize(begin + announced as usize, 0);
    from.read_exact(&mut into[begin..])
}

impl Board for EmulatedBoard {
    type Error = QemuError;

    fn run(
        &mut self,
        now_us: u64,
        input: Input<'_>,
        output: &mut Output,
    ) -> Result<Wake, QemuError> {
        self.exchange(now_us, input, output)
            .map_err(|error| self.qemu.explain(error))
    }
}
