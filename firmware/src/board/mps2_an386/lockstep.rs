//! The board's side of lockstep: time advances only by grants of the bench.
//!
//! ```text
//! board                                     bench
//!   all work is done, the tick waits
//!   TimeRequest + all bytes sent     ---->  moves the arm to the next instant
//!   takes the bytes                  <----  TimeGrant + all bytes arrived
//!   time becomes that of the grant, the tick runs at once, until it waits again
//! ```
//!
//! So the order of events is always the same, independent of the load of the host;
//! only measured computing times differ between runs.
//!
//! `TimeRequest` goes to QEMU's standard output, `TimeGrant` is read from its standard
//! input. Waiting for a grant stops all of QEMU; a bench that closes the pipe
//! ends it.
//!
//! The UARTs are idle meanwhile. QEMU takes some 40 µs and two changes of thread for
//! every byte that it feeds to one, and a system call for every byte that one sends:
//! the two hundred bytes of a tick took longer than its millisecond. So bytes travel
//! with the messages, in and out of the same buffers that the UARTs' interrupt
//! handlers fill and empty where time is real. A tick is five exchanges, of two system
//! calls each.

use super::semihosting::{self, EXIT_NO_BENCH, Stdio};
use super::{BUS, real_time};
use crate::crash::memory;
use crate::settings;
use armbridge_board::bridge::LinkPort;
use armbridge_board::bridge::transparent_port::PortEnd;
use armbridge_board::lockstep::{HEADER_LEN, MESSAGE_MAX, PayloadLens, TimeGrant, TimeRequest};
use armbridge_board::store::Store;
use embassy_futures::yield_now;
use embedded_storage::nor_flash::NorFlash;

/// Runs the bridge by grants, for ever, in place of [`crate::tasks::link`] and
/// [`crate::tasks::client`]. The real-time loop must be waiting.
pub async fn run(
    port: &mut LinkPort<'_>,
    mut client: PortEnd<'_>,
    store: &mut Store<impl NorFlash>,
) -> ! {
    let Some(stdio) = Stdio::open() else {
        semihosting::exit(EXIT_NO_BENCH);
    };
    let mut bench = Bench {
        stdio,
        message: [0; MESSAGE_MAX],
        len: HEADER_LEN,
        lens: PayloadLens::default(),
    };
    loop {
        loop {
            while let Some(frame) = port.transmit() {
                bench.append(|lens| &mut lens.link, frame);
            }
            if !settings::keep(port, store) {
                break;
            }
        }
        while let Some(byte) = client.transmit() {
            bench.append(|lens| &mut lens.client, &[byte]);
        }
        while let Some(byte) = BUS.buffers().next_to_send() {
            bench.append(|lens| &mut lens.bus, &[byte]);
        }
        bench.finish(client.room());

        let grant = bench.receive_grant(|[from_host, from_client, from_bus]| {
            port.receive(from_host);
            // The bench knows the room for bytes.
            client.receive(from_client);
            for byte in from_bus {
                BUS.buffers().received(*byte);
            }
        });
        client.set_line(grant.client_line);
        real_time::grant(grant.now_us, grant.is_stop_pressed);
        // Yields to the tick, which has been woken, and to the task that reports the mode.
        yield_now().await;
    }
}

/// Connection to the bench, with the buffer of one message in either direction.
struct Bench {
    stdio: Stdio,
    message: [u8; MESSAGE_MAX],
    /// Length of the message so far.
    len: usize,
    /// Lengths of its payloads to the bench.
    lens: PayloadLens,
}

impl Bench {
    /// Appends bytes of one kind to the message, after all of the kinds before it
    /// in [`PayloadLens`]; sends it when it is full, and begins another.
    fn append(&mut self, kind: fn(&mut PayloadLens) -> &mut u16, mut bytes: &[u8]) {
        while !bytes.is_empty() {
            let free = self.message.get_mut(self.len..).unwrap_or_default();
            let count = free.len().min(bytes.len());
            if count == 0 {
                self.send(0, false);
                continue;
            }
            let (part, later) = bytes.split_at(count);
            for (slot, byte) in free.iter_mut().zip(part) {
                *slot = *byte;
            }
            self.len += count;
            // Shorter than a message.
            *kind(&mut self.lens) += count as u16;
            bytes = later;
        }
    }

    /// Sends the last message before the next grant.
    fn finish(&mut self, client_room: usize) {
        self.send(client_room, true);
        self.len = 0;
    }

    fn send(&mut self, client_room: usize, is_last: bool) {
        let (until_us, bus_wanted) = real_time::waits_for();
        let request = TimeRequest {
            until_us,
            bus_wanted,
            bus_baud: memory::baud(),
            client_room: client_room as u32,
            lens: core::mem::take(&mut self.lens),
            is_last,
        };
        for (slot, byte) in self.message.iter_mut().zip(request.to_bytes()) {
            *slot = byte;
        }
        if !self
            .stdio
            .write(self.message.get(..self.len).unwrap_or_default())
        {
            semihosting::exit(EXIT_NO_BENCH);
        }
        self.len = HEADER_LEN;
    }

    /// Waits for a grant, and passes its bytes of link, client and bus to `take`. Makes room
    /// for the next message to the bench.
    fn receive_grant(&mut self, mut take: impl FnMut([&[u8]; 3])) -> TimeGrant {
        loop {
            if let Some((header, rest)) = self.received().split_first_chunk() {
                let grant = TimeGrant::from_bytes(*header);
                if let Some(parts) = grant.lens.split(rest) {
                    take(parts);
                    if grant.is_last {
                        self.len = HEADER_LEN;
                        return grant;
                    }
                    // Bytes of the next message.
                    let end = HEADER_LEN + grant.lens.total();
                    self.message.copy_within(end..self.len, 0);
                    self.len -= end;
                    continue;
                }
            }
            let free = self.message.get_mut(self.len..).unwrap_or_default();
            match self.stdio.read(free) {
                Some(count) => self.len += count,
                // The bench has gone, or sent an invalid message.
                None => semihosting::exit(EXIT_NO_BENCH),
            }
        }
    }

    /// Bytes received so far.
    fn received(&self) -> &[u8] {
        self.message.get(..self.len).unwrap_or_default()
    }
}
