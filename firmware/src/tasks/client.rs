//! The loop of the transparent port: bytes between a client and the bridge.

use super::signals::Signals;
use super::stream::{FromClient, LineChanges, ToHost, when};
use armbridge_board::bridge::transparent_port::PortEnd;
use core::pin::pin;
use embassy_futures::select::{Either, Either3, select, select3};

/// Moves bytes between a client and the transparent port, for ever. `wake` makes
/// the real-time loop read received bytes.
pub async fn client(
    mut port: PortEnd<'_>,
    mut from_client: impl FromClient,
    mut to_client: impl ToHost,
    mut changes: impl LineChanges,
    wake: impl Fn(),
    signals: &Signals,
) -> ! {
    const CHUNK: usize = 64;
    let mut received = [0; CHUNK];
    let mut answer = heapless::Vec::<u8, CHUNK>::new();
    loop {
        port.set_line(from_client.line());
        while !answer.is_full()
            && let Some(byte) = port.transmit()
        {
            // There is room.
            let _ = answer.push(byte);
        }
        // A USB packet is received whole or not at all: the client waits until there is
        // room for the longest.
        let has_room = port.room() >= CHUNK;
        let is_silent = answer.is_empty();
        let event = {
            let input = pin!(from_client.read(&mut received));
            let client_bytes = pin!(signals.client_bytes.wait());
            let output = pin!(to_client.write(&answer));
            let output = select(when(is_silent, client_bytes), when(!is_silent, output));
            select3(when(has_room, input), output, changes.changed()).await
        };
        match event {
            Either3::First(len) => {
                port.receive(received.get(..len).unwrap_or(&received));
                wake();
            }
            Either3::Second(Either::First(())) => {}
            Either3::Second(Either::Second(len)) => {
                let unsent = answer.len().saturating_sub(len);
                answer.rotate_right(unsent);
                answer.truncate(unsent);
            }
            Either3::Third(()) => {
                port.set_line(from_client.line());
                wake();
            }
        }
    }
}
