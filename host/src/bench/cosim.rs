//! Board, bus, arm and host in one virtual time.
//!
//! Nothing sleeps and nothing is stepped at a fixed rate: time jumps to the
//! next instant at which something happens, a byte on the wire, an alarm of the
//! board, a word of the host. Two runs with the same seed are equal to the
//! bit. The link between board and host takes no time.

use super::Bench;
use super::board::{Board, Output};

/// Who is at the other end of the link.
pub trait Host {
    /// Why there is nobody any more.
    type Error;

    /// What to tell the board now.
    ///
    /// # Errors
    /// If the host gives up.
    fn speak(&mut self, now_us: u64) -> Result<&[u8], Self::Error>;

    /// Takes what the board said.
    ///
    /// # Errors
    /// If the host gives up.
    fn hear(&mut self, now_us: u64, bytes: &[u8]) -> Result<(), Self::Error>;

    /// When to be asked again, at the latest.
    fn wake_at_us(&self) -> u64;

    /// Whether there is nothing left to do.
    fn is_done(&self) -> bool;
}

/// Why a run ended early.
#[derive(Debug)]
pub enum CosimError<B, H> {
    /// The board is gone.
    Board(B),
    /// The host gave up.
    Host(H),
}

/// Runs until the host is done; returns the virtual time in µs.
///
/// # Errors
/// If the board is gone, or the host gives up.
pub fn run<B: Board, H: Host>(
    board: &mut B,
    bench: &mut Bench,
    host: &mut H,
) -> Result<u64, CosimError<B::Error, H::Error>> {
    let mut output = Output::default();
    let mut heard = Vec::new();
    let mut board_wake_us = 0;
    let mut now_us = 0;
    while !host.is_done() {
        let wake_us = board_wake_us.min(host.wake_at_us()).max(now_us);
        heard.clear();
        now_us = bench.advance(wake_us, &mut heard);

        let from_host = host.speak(now_us).map_err(CosimError::Host)?;
        output.bus.clear();
        output.link.clear();
        board_wake_us =
            board.run(now_us, &heard, from_host, &mut output).map_err(CosimError::Board)?;
        bench.send(now_us, &output.bus);
        host.hear(now_us, &output.link).map_err(CosimError::Host)?;
    }
    Ok(now_us)
}
