//! Bus, flash, board, host and client, each of which may do anything at any time.

use core::convert::Infallible;
use core::future::Future;
use core::hint::black_box;
use core::marker::PhantomData;
use core::pin::Pin;
use core::task::{Context, Poll};

use armbridge_board::bridge::transparent_port::ClientLine;
use armbridge_firmware::stop::PolledUart;
use armbridge_firmware::tasks::{FromClient, FromHost, LineChanges, RealTime, ToHost};
use armbridge_link::message::StopSource;
use armbridge_servo::bus::{Bus, LineAfter, Received, Transmission};
use armbridge_servo::port::{SERVO_BAUD_MAX, SetBaud};
use embedded_hal::digital::{ErrorType, OutputPin};
use embedded_hal_nb::serial::{self, ErrorKind};
use embedded_storage::nor_flash::{self, NorFlash, NorFlashErrorKind, ReadNorFlash};

use super::{any, planted};

/// A servo bus.
pub(crate) struct AnyBus(pub(crate) [u8; 64]);

impl Bus for AnyBus {
    const RELEASES_BY_ITSELF: bool = true;
    const BAUD_MAX: u32 = SERVO_BAUD_MAX;

    fn set_baud(&mut self, baud: u32) {
        black_box(baud);
    }

    fn send(&mut self, bytes: &[u8], after: LineAfter) {
        black_box((bytes, after));
    }

    fn send_delay_us(&self) -> u32 {
        any()
    }

    fn transmission(&mut self) -> Transmission {
        black_box(Transmission::Waiting)
    }

    fn release(&mut self) {
        black_box(());
    }

    fn received(&mut self) -> Received<'_> {
        let bytes = black_box(&self.0);
        Received {
            bytes: bytes.get(..any()).unwrap_or(bytes),
            error: black_box(Some(ErrorKind::Noise)),
        }
    }
}

/// A serial port.
pub(crate) struct AnyPort;

impl serial::ErrorType for AnyPort {
    type Error = ErrorKind;
}

impl serial::Read<u8> for AnyPort {
    fn read(&mut self) -> nb::Result<u8, ErrorKind> {
        black_box(Err(nb::Error::WouldBlock))
    }
}

impl serial::Write<u8> for AnyPort {
    fn write(&mut self, byte: u8) -> nb::Result<(), ErrorKind> {
        black_box(byte);
        black_box(Err(nb::Error::WouldBlock))
    }

    fn flush(&mut self) -> nb::Result<(), ErrorKind> {
        black_box(Err(nb::Error::WouldBlock))
    }
}

impl SetBaud for AnyPort {
    fn set_baud(&mut self, baud: u32) {
        black_box(baud);
    }
}

/// Direction pin of the bus.
pub(crate) struct Direction;

impl ErrorType for Direction {
    type Error = Infallible;
}

impl OutputPin for Direction {
    fn set_low(&mut self) -> Result<(), Infallible> {
        black_box(false);
        Ok(())
    }

    fn set_high(&mut self) -> Result<(), Infallible> {
        black_box(true);
        Ok(())
    }
}

/// A flash that fails. The compiler cannot follow the data flow of the storage library;
/// the fuzz target `store` checks that no content of a flash makes it panic.
pub(crate) struct Flash;

impl nor_flash::ErrorType for Flash {
    type Error = NorFlashErrorKind;
}

impl ReadNorFlash for Flash {
    const READ_SIZE: usize = 1;

    fn read(&mut self, _offset: u32, _bytes: &mut [u8]) -> Result<(), NorFlashErrorKind> {
        Err(NorFlashErrorKind::Other)
    }

    fn capacity(&self) -> usize {
        2 * Self::ERASE_SIZE
    }
}

impl NorFlash for Flash {
    const WRITE_SIZE: usize = 4;
    const ERASE_SIZE: usize = 1 << 17;

    fn erase(&mut self, _from: u32, _to: u32) -> Result<(), NorFlashErrorKind> {
        Err(NorFlashErrorKind::Other)
    }

    fn write(&mut self, _offset: u32, _bytes: &[u8]) -> Result<(), NorFlashErrorKind> {
        Err(NorFlashErrorKind::Other)
    }
}

/// Future that uses its input at an arbitrary time and returns an arbitrary value. Not an
/// `async` block, which panics when it is polled after its end.
struct Sometime<W, T>(W, PhantomData<T>);

impl<W: Unpin, T: Default + Unpin> Future for Sometime<W, T> {
    type Output = T;

    #[expect(
        clippy::inline_always,
        reason = "a planted panic is in the loop that waits"
    )]
    #[inline(always)]
    fn poll(mut self: Pin<&mut Self>, _: &mut Context<'_>) -> Poll<T> {
        black_box(&mut self.0);
        planted();
        if any() {
            Poll::Ready(any())
        } else {
            Poll::Pending
        }
    }
}

fn sometime<W: Unpin, T: Default + Unpin>(input: W) -> impl Future<Output = T> {
    Sometime(input, PhantomData)
}

/// Board, host and client.
pub(crate) struct Outside;

impl RealTime for Outside {
    fn now_us(&self) -> u64 {
        any()
    }

    fn start_stopwatch(&mut self) {
        black_box(());
    }

    fn stopwatch_ns(&self) -> u32 {
        any()
    }

    fn note_good_tick(&mut self) {
        black_box(());
    }

    fn stop_source(&mut self) -> Option<StopSource> {
        planted();
        any::<bool>().then_some(StopSource::Pin)
    }
}

impl FromHost for Outside {
    fn read(&mut self, buffer: &mut [u8]) -> impl Future<Output = usize> {
        sometime(buffer)
    }
}

impl ToHost for Outside {
    fn write(&mut self, bytes: &[u8]) -> impl Future<Output = usize> {
        sometime(bytes)
    }
}

impl FromClient for Outside {
    fn line(&self) -> ClientLine {
        any()
    }
}

impl LineChanges for Outside {
    fn changed(&mut self) -> impl Future<Output = ()> {
        sometime(())
    }
}

impl PolledUart for Outside {
    fn set_baud(&mut self, baud: u32) {
        black_box(baud);
    }

    fn drive(&mut self, on: bool) {
        black_box(on);
    }

    fn send(&mut self, byte: u8) {
        black_box(byte);
    }

    fn flush(&mut self) {
        black_box(());
    }

    fn pause_us(&mut self, us: u32) {
        black_box(us);
    }
}
