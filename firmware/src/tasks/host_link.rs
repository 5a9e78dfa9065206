//! The loop of the host's link: frames in and out, and settings to the store.

use super::signals::Signals;
use super::stream::{FromHost, ToHost, when};
use crate::settings;
use armbridge_board::bridge::LinkPort;
use armbridge_board::store::Store;
use armbridge_link::message::Stack;
use core::pin::pin;
use embassy_futures::select::{Either, select};
use embedded_storage::nor_flash::NorFlash;

/// Moves bytes between the host and `port`, for ever, and settings to `store`. Both
/// are borrowed: a future stores an argument twice, as argument and as variable. A
/// host that does not read delays only this loop, which still takes what the host sends.
/// `watch` returns the use of the stack when it has grown.
pub async fn link(
    port: &mut LinkPort<'_>,
    mut from_host: impl FromHost,
    mut to_host: impl ToHost,
    store: &mut Store<impl NorFlash>,
    mut watch: impl FnMut() -> Option<Stack>,
    signals: &Signals,
) -> ! {
    let mut pending = 0..0;
    let mut received = [0; 64];
    loop {
        if let Some(stack) = watch() {
            port.set_stack(stack);
        }
        settings::keep(port, store);
        if pending.is_empty() {
            pending = 0..next_frame(port);
        }
        let bytes = port.last_frame().get(pending.clone()).unwrap_or_default();
        let is_silent = bytes.is_empty();
        let event = {
            let frame_ready = pin!(signals.frame_ready.wait());
            let output = pin!(to_host.write(bytes));
            let output = select(when(is_silent, frame_ready), when(!is_silent, output));
            // Output first: what can be sent at once is, without a look at the input. It ends
            // with the frames there are, so input waits no longer than for those.
            select(output, from_host.read(&mut received)).await
        };
        match event {
            Either::First(Either::First(())) => {}
            Either::First(Either::Second(len)) => pending.start += len,
            Either::Second(len) => receive(port, received.get(..len).unwrap_or(&received)),
        }
    }
}

// Functions of their own, like the parts of the tick: a command that designs gains and
// a save take some kB of stack each, but not at the same time.

/// [`LinkPort::receive`].
#[inline(never)]
fn receive(port: &mut LinkPort<'_>, bytes: &[u8]) {
    port.receive(bytes);
}

/// Takes the next frame for the host; returns its length, 0 if there is none.
#[inline(never)]
fn next_frame(port: &mut LinkPort<'_>) -> usize {
    port.transmit().map_or(0, <[u8]>::len)
}
