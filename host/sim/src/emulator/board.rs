//! Emulated board in virtual time.
//!
//! Each run is one exchange: a grant sends all received bytes; when the board is idle, its
//! reply has its next time and its output. No clock is involved: load of the machine
//! changes only the wall time of a run.

use std::collections::VecDeque;
use std::io::{self, BufReader, Read, Write};
use std::os::unix::net::UnixStream;
use std::time::Duration;

use armbridge_board::lockstep::{HEADER_LEN, MESSAGE_MAX, PayloadLens, TimeGrant, TimeRequest};

use super::qemu::{ProcessEnd, Qemu, QemuError};
use crate::board::{Board, Input, Output, Wake};

/// Timeout after which a silent board is dead, not busy.
const DEAD_AFTER: Duration = Duration::from_secs(30);

/// A board under QEMU that waits for grants.
#[derive(Debug)]
pub struct EmulatedBoard {
    qemu: Qemu,
    reader: BufReader<UnixStream>,
    /// Buffer of a message, kept to reuse its memory.
    message: Vec<u8>,
    /// Bytes without room in the board wait, as they would in a USB host.
    from_client: VecDeque<u8>,
    client_room: usize,
}

impl EmulatedBoard {
    /// Takes over an emulator started in lockstep, and waits until its board
    /// has booted.
    ///
    /// # Errors
    /// If the board does not come up.
    pub fn new(qemu: Qemu) -> Result<Self, QemuError> {
        qemu.from_board.set_read_timeout(Some(DEAD_AFTER))?;
        let reader = BufReader::with_capacity(MESSAGE_MAX, qemu.from_board.try_clone()?);
        let mut board = Self {
            qemu,
            reader,
            message: Vec::with_capacity(MESSAGE_MAX),
            from_client: VecDeque::new(),
            client_room: 0,
        };
        let mut output = Output::default();
        board
            .receive_request(&mut output)
            .map_err(|error| board.qemu.explain(error))?;
        let count = output.bus.len() + output.link.len() + output.client.len();
        if count == 0 {
            Ok(board)
        } else {
            Err(QemuError::Died(ProcessEnd::EarlyBytes(count)))
        }
    }

    /// Sends a grant with all inputs, in as many messages as that takes.
    fn send_grant(&mut self, now_us: u64, input: Input<'_>) -> io::Result<()> {
        self.from_client.extend(input.client);
        let room = self.client_room.min(self.from_client.len());
        let client = &self.from_client.make_contiguous()[..room];
        let mut rest = [input.link, client, input.bus];
        loop {
            let mut free = MESSAGE_MAX - HEADER_LEN;
            let parts = rest.each_mut().map(|bytes| {
                let (part, later) = bytes.split_at(free.min(bytes.len()));
                free -= part.len();
                *bytes = later;
                part
            });
            // No part is longer than a message.
            let [link, client, bus] = parts.map(|part| part.len() as u16);
            let grant = TimeGrant {
                now_us,
                client_line: input.line,
                is_stop_pressed: input.is_stop_pressed,
                lens: PayloadLens { link, client, bus },
                is_last: rest.iter().all(|bytes| bytes.is_empty()),
            };
            self.message.clear();
            self.message.extend(grant.to_bytes());
            self.message.extend(parts.into_iter().flatten());
            self.qemu.to_board.write_all(&self.message)?;
            if grant.is_last {
                self.from_client.drain(..room);
                return Ok(());
            }
        }
    }

    /// Waits until the board has nothing left to do, and reads its output.
    fn receive_request(&mut self, output: &mut Output) -> io::Result<Wake> {
        loop {
            let mut header = [0; HEADER_LEN];
            self.reader.read_exact(&mut header)?;
            let request = TimeRequest::from_bytes(header);
            let len = request.lens.total();
            if HEADER_LEN + len > MESSAGE_MAX {
                let text =
                    format!("the board announced {len} bytes: is the image of this version?");
                return Err(io::Error::new(io::ErrorKind::InvalidData, text));
            }
            let PayloadLens { link, client, bus } = request.lens;
            for (count, into) in [
                (link, &mut output.link),
                (client, &mut output.client),
                (bus, &mut output.bus),
            ] {
                let begin = into.len();
                into.resize(begin + usize::from(count), 0);
                self.reader.read_exact(&mut into[begin..])?;
            }
            if request.is_last {
                self.client_room = request.client_room as usize;
                output.bus_baud = request.bus_baud;
                return Ok(Wake {
                    at_us: request.until_us,
                    bus_bytes: request.bus_wanted.map(usize::from),
                });
            }
        }
    }
}

impl Board for EmulatedBoard {
    type Error = QemuError;

    fn run(
        &mut self,
        now_us: u64,
        input: Input<'_>,
        output: &mut Output,
    ) -> Result<Wake, QemuError> {
        let granted = self.send_grant(now_us, input);
        output.client_waiting = self.from_client.len();
        granted
            .and_then(|()| self.receive_request(output))
            .map_err(|error| self.qemu.explain(error))
    }
}
