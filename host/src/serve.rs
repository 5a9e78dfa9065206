//! The virtual servos in wall-clock time, for anybody's program.
//!
//! Raw bus bytes go in and out of one connection, as on the wire: bytes that
//! come in are put on the bus back to back, what the servos say comes out when
//! its last bit would have arrived. With echo the other side hears itself, as
//! on a single wire whose receiver stays on.

use std::io::{self, Read, Write};
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::time::{Duration, Instant};

use crate::bench::Bench;

/// Finest step of the wall clock: what a sleeping thread can keep.
const STEP: Duration = Duration::from_micros(200);

/// When the bench's time began, and how much slower than the wall clock it runs.
#[derive(Clone, Copy, Debug)]
pub struct Pace {
    /// The bench's time 0.
    pub epoch: Instant,
    /// Wall-clock time per time of the bench.
    pub slow: u32,
}

/// Serves until the other side closes. `bench` goes on from where it was, so
/// that a second connection finds the servos as the first left them.
///
/// # Errors
/// If the connection breaks.
pub fn serve(
    bench: &mut Bench,
    pace: Pace,
    from: impl Read + Send + 'static,
    mut to: impl Write,
    echo: bool,
) -> io::Result<()> {
    let bytes = spawn_reader(from);
    let now_us = || pace.epoch.elapsed().as_micros() as u64 / u64::from(pace.slow);
    let mut heard = Vec::new();
    loop {
        let came = match bytes.recv_timeout(STEP) {
            Ok(came) => came?,
            Err(RecvTimeoutError::Timeout) => Vec::new(),
            Err(RecvTimeoutError::Disconnected) => return Ok(()),
        };
        bench.advance(now_us(), None, &mut heard);
        bench.send(now_us(), &came);
        if echo {
            heard.extend_from_slice(&came);
        }
        if !heard.is_empty() {
            to.write_all(&heard)?;
            to.flush()?;
            heard.clear();
        }
    }
}

/// Reads on a thread, so that the servos need not wait for bytes.
fn spawn_reader(mut from: impl Read + Send + 'static) -> Receiver<io::Result<Vec<u8>>> {
    let (sender, receiver) = channel();
    std::thread::spawn(move || {
        let mut bytes = [0; 1024];
        loop {
            let came = match from.read(&mut bytes) {
                Ok(0) => return,
                Ok(count) => Ok(bytes[..count].to_vec()),
                Err(error) => Err(error),
            };
            let failed = came.is_err();
            if sender.send(came).is_err() || failed {
                return;
            }
        }
    });
    receiver
}
