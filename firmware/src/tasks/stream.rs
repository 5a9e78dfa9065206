//! Byte streams of a board for the byte loops, and a conditional wait.

use armbridge_board::bridge::transparent_port::ClientLine;
use core::future::{Future, poll_fn};
use core::pin::Pin;
use core::task::Poll;

/// Bytes from the host.
pub trait FromHost {
    /// Waits for bytes, returns their number. May be dropped at any time without
    /// loss: bytes that it did not report were not taken.
    fn read(&mut self, buffer: &mut [u8]) -> impl Future<Output = usize>;
}

/// Bytes to the host.
pub trait ToHost {
    /// Waits until some of `bytes` can be sent, returns the number sent. May be
    /// dropped at any time: bytes that it did not report were not sent.
    fn write(&mut self, bytes: &[u8]) -> impl Future<Output = usize>;
}

/// Bytes from the client of the transparent port.
pub trait FromClient: FromHost {
    /// The settings that the client has given its port.
    fn line(&self) -> ClientLine;
}

/// Changes of the client's port settings.
pub trait LineChanges {
    /// Waits for the next change.
    fn changed(&mut self) -> impl Future<Output = ()>;
}

/// `future` if `condition` holds; never otherwise. An `async` block panics when it is
/// polled again after its end, and the compiler cannot see that none is.
pub(super) fn when<F: Future>(
    condition: bool,
    mut future: Pin<&mut F>,
) -> impl Future<Output = F::Output> {
    poll_fn(move |context| {
        if condition {
            future.as_mut().poll(context)
        } else {
            Poll::Pending
        }
    })
}
