//! The control link on UART0, as the link loop wants it.

use super::LINK;
use crate::port::Buffers;
use crate::run::{FromHost, ToHost};

/// Either direction of the control link.
#[derive(Debug)]
pub struct LinkStream;

impl FromHost for LinkStream {
    async fn read(&mut self, buffer: &mut [u8]) -> usize {
        LINK.until(Buffers::has_received).await;
        let mut len = 0;
        for (slot, byte) in buffer
            .iter_mut()
            .zip(core::iter::from_fn(|| LINK.buffers().read()))
        {
            *slot = byte;
            len += 1;
        }
        len
    }
}

impl ToHost for LinkStream {
    async fn write(&mut self, bytes: &[u8]) -> usize {
        LINK.until(Buffers::has_room).await;
        let sent = bytes.iter().take_while(|byte| LINK.buffers().write(**byte));
        let len = sent.count();
        LINK.send();
        len
    }
}
