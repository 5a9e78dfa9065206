//! Control link and transparent port on their UARTs, as streams for the byte loops.

use super::uart::Uart;
use crate::port::Buffers;
use crate::tasks::{FromClient, FromHost, LineChanges, ToHost};
use armbridge_board::bridge::transparent_port::ClientLine;

/// Either direction of a UART.
#[derive(Clone, Copy)]
pub struct Stream(pub &'static Uart);

impl FromHost for Stream {
    async fn read(&mut self, buffer: &mut [u8]) -> usize {
        self.0.until(Buffers::has_received).await;
        let mut len = 0;
        for (slot, byte) in buffer
            .iter_mut()
            .zip(core::iter::from_fn(|| self.0.buffers().read()))
        {
            *slot = byte;
            len += 1;
        }
        len
    }
}

impl ToHost for Stream {
    async fn write(&mut self, bytes: &[u8]) -> usize {
        self.0.until(Buffers::has_room).await;
        let buffers = self.0.buffers();
        let sent = bytes.iter().take_while(|byte| buffers.write(**byte));
        let len = sent.count();
        self.0.send();
        len
    }
}

impl FromClient for Stream {
    /// A UART has no modem lines, and QEMU's no speed.
    fn line(&self) -> ClientLine {
        ClientLine {
            is_open: true,
            baud: 0,
        }
    }
}

/// Port settings that never change.
#[derive(Clone, Copy, Debug)]
pub struct NoChanges;

impl LineChanges for NoChanges {
    async fn changed(&mut self) {
        core::future::pending::<()>().await;
    }
}
