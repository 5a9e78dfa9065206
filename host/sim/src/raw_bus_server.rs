//! The virtual servos in wall-clock time, served to another program.
//!
//! One connection carries the raw bytes of the bus. Each received chunk is sent on the bus
//! back to back, from the time at which it was read: a pause of the other side is a pause
//! on the bus, as far as the operating system preserves it. A reply is forwarded when its
//! last bit would have arrived. With echo, sent bytes come back first, as on a single wire
//! whose receiver stays on.
//!
//! A terminal has a rate, which the other side sets; the bus master uses it from the next
//! chunk on. Bytes that are garbled by a wrong rate or by a collision of servos are
//! forwarded as a receiver decodes them.
//!
//! # Falling behind
//!
//! The bench follows the wall clock and catches up after a delay of up to 0.1 s. The rest
//! of a longer delay, after a suspension or a peer that did not read, is skipped, and the
//! arm does not move in it.
//!
//! The other side cannot run ahead. The bus carries a byte in 10 µs; with 20 ms of bytes
//! queued, reading stops, and the other side's writes block.
//!
//! On a socket one connection is served and the next one waits. A connection that has been
//! silent for 5 s gives way to it; one that does not read for 1 s is closed.

use std::collections::VecDeque;
use std::io::{self, Read, Write};
use std::net::{Shutdown, SocketAddr, TcpListener, TcpStream};
use std::sync::mpsc::{Receiver, RecvTimeoutError, sync_channel};
use std::time::{Duration, Instant};

use crate::{Bench, nonblocking};

/// Step of the wall clock: the resolution of a sleeping thread.
const STEP: Duration = Duration::from_micros(200);
/// Interval of polls for a connection.
const WAITING_STEP: Duration = Duration::from_millis(5);
/// Longest delay that the bench catches up, in its own time.
const LAG_MAX_US: u64 = 100_000;
/// Longest queue for the bus.
const BACKLOG_MAX_US: u64 = 20_000;
/// Latest reply: that to START, 4.74 ms times the id.
const ANSWER_US: u64 = 15_000;
/// Time for which the servos have been powered when the first request can arrive: more
/// than those of any kind need to start.
const STARTED_US: u64 = 150_000;
/// Chunks read ahead.
const CHUNKS: usize = 8;

/// Bits of the longest reply: of LEN 255.
const ANSWER_BITS: u64 = 2_590;

/// Silence after which the next connection takes the bus over.
const SILENCE: Duration = Duration::from_secs(5);
/// Longest time for which a connection may accept no bytes; the servos stand still in it.
const STUCK: Duration = Duration::from_secs(1);

/// Received bytes.
#[derive(Debug)]
struct Chunk {
    at: Instant,
    /// The terminal's rate, where there is one.
    baud: Option<u32>,
    bytes: Vec<u8>,
}

/// A bench that follows the wall clock.
#[derive(Debug)]
pub struct WallClockBench {
    bench: Bench,
    slow: u32,
    /// Wall-clock time of bench time [`STARTED_US`].
    epoch: Instant,
    now_us: u64,
    /// Bytes queued for the bus, each with the time at which its last one is sent.
    echoes: VecDeque<(u64, Vec<u8>)>,
    received: Vec<u8>,
    is_interrupted: fn() -> bool,
}

impl WallClockBench {
    /// A bench that starts now, `slow` times slower than the wall clock, with servos that
    /// have started.
    pub fn new(mut bench: Bench, slow: u32) -> Self {
        bench.advance(STARTED_US, None, &mut Vec::new());
        Self {
            bench,
            slow,
            epoch: Instant::now(),
            now_us: STARTED_US,
            echoes: VecDeque::new(),
            received: Vec::new(),
            is_interrupted: || false,
        }
    }

    /// The same, but it accepts and serves no connection once `is_interrupted`.
    #[must_use]
    pub fn interrupted_by(self, is_interrupted: fn() -> bool) -> Self {
        Self {
            is_interrupted,
            ..self
        }
    }

    /// Waits for a connection; the servos run meanwhile. `None` if it is interrupted.
    ///
    /// # Errors
    /// If the listener fails.
    pub fn accept(
        &mut self,
        listener: &TcpListener,
    ) -> io::Result<Option<(TcpStream, SocketAddr)>> {
        listener.set_nonblocking(true)?;
        while !(self.is_interrupted)() {
            if let Some((stream, peer)) = nonblocking::accept(listener)? {
                stream.set_nonblocking(false)?;
                return Ok(Some((stream, peer)));
            }
            self.advance_to(Instant::now());
            std::thread::sleep(WAITING_STEP);
        }
        Ok(None)
    }

    /// Serves a connection as [`serve`](Self::serve) does, until it is silent and another one
    /// waits, which is returned.
    ///
    /// # Errors
    /// If the connection breaks.
    pub fn serve_socket(
        &mut self,
        stream: &TcpStream,
        listener: &TcpListener,
        echo: bool,
    ) -> io::Result<Option<(TcpStream, SocketAddr)>> {
        stream.set_nonblocking(false)?;
        stream.set_write_timeout(Some(STUCK))?;
        listener.set_nonblocking(true)?;
        let mut next = None;
        let ended = self.serve_until(
            stream.try_clone()?,
            stream,
            || None,
            echo,
            |silence| {
                if silence > SILENCE {
                    // A listener that fails accepts nothing.
                    next = nonblocking::accept(listener).ok().flatten();
                }
                next.is_some()
            },
        );
        // The reader's thread has the other handle.
        let _ = stream.shutdown(Shutdown::Both);
        ended.map(|()| next)
    }

    /// Serves a connection until the other side closes and the last reply is sent.
    /// The servos keep their state for the next connection. `baud` returns
    /// the rate that the other side has set, if it can set one.
    ///
    /// # Errors
    /// If the connection breaks.
    pub fn serve(
        &mut self,
        from: impl Read + Send + 'static,
        to: impl Write,
        baud: impl Fn() -> Option<u32> + Send + 'static,
        echo: bool,
    ) -> io::Result<()> {
        self.serve_until(from, to, baud, echo, |_| false)
    }

    /// The same, until `is_over` after a silence.
    fn serve_until(
        &mut self,
        from: impl Read + Send + 'static,
        mut to: impl Write,
        baud: impl Fn() -> Option<u32> + Send + 'static,
        echo: bool,
        mut is_over: impl FnMut(Duration) -> bool,
    ) -> io::Result<()> {
        let mut heard = Instant::now();
        let chunks = spawn_reader(from, baud);
        // Bytes from before the connection are dropped.
        self.advance_to(Instant::now());
        self.echoes.clear();
        self.received.clear();
        while !(self.is_interrupted)() {
            let is_behind = self.bench.line_free_us() > self.now_us + BACKLOG_MAX_US;
            let next = if is_behind {
                std::thread::sleep(STEP);
                Err(RecvTimeoutError::Timeout)
            } else {
                chunks.recv_timeout(STEP)
            };
            let Chunk { at, baud, bytes } = match next {
                Ok(chunk) => {
                    heard = Instant::now();
                    chunk?
                }
                Err(RecvTimeoutError::Timeout) if is_over(heard.elapsed()) => break,
                Err(RecvTimeoutError::Timeout) => Chunk {
                    at: Instant::now(),
                    baud: None,
                    bytes: Vec::new(),
                },
                Err(RecvTimeoutError::Disconnected) => break,
            };
            self.advance_to(at);
            if let Some(baud) = baud.filter(|baud| *baud != self.bench.baud()) {
                self.bench.set_baud(baud);
            }
            self.bench.send(self.now_us, &bytes);
            if echo {
                self.echoes.push_back((self.bench.line_free_us(), bytes));
            }
            self.forward(&mut to)?;
        }
        let last_us = self.now_us.max(self.bench.line_free_us())
            + ANSWER_US
            + ANSWER_BITS * 1_000_000 / u64::from(self.bench.baud());
        while self.now_us < last_us && !(self.is_interrupted)() {
            std::thread::sleep(STEP);
            self.advance_to(Instant::now());
            self.forward(&mut to)?;
        }
        Ok(())
    }

    /// Advances the bench to this time, or by [`LAG_MAX_US`] if it is farther behind.
    fn advance_to(&mut self, at: Instant) {
        let wall = at.saturating_duration_since(self.epoch) / self.slow;
        let wall_us = STARTED_US + wall.as_micros() as u64;
        let until_us = wall_us.clamp(self.now_us, self.now_us + LAG_MAX_US);
        self.epoch += Duration::from_micros(wall_us.saturating_sub(until_us)) * self.slow;
        while let Some((sent_us, bytes)) = self.echoes.pop_front() {
            if sent_us > until_us {
                self.echoes.push_front((sent_us, bytes));
                break;
            }
            self.bench.advance(sent_us, None, &mut self.received);
            self.received.extend(bytes);
        }
        self.bench.advance(until_us, None, &mut self.received);
        self.now_us = until_us;
    }

    fn forward(&mut self, to: &mut impl Write) -> io::Result<()> {
        if !self.received.is_empty() {
            to.write_all(&self.received)?;
            to.flush()?;
            self.received.clear();
        }
        Ok(())
    }
}

/// Reads on a thread of its own, so that the bench is not blocked.
fn spawn_reader(
    mut from: impl Read + Send + 'static,
    baud: impl Fn() -> Option<u32> + Send + 'static,
) -> Receiver<io::Result<Chunk>> {
    let (sender, receiver) = sync_channel(CHUNKS);
    std::thread::spawn(move || {
        let mut bytes = [0; 1024];
        loop {
            let chunk = match from.read(&mut bytes) {
                Ok(0) => return,
                Ok(count) => Ok(Chunk {
                    at: Instant::now(),
                    baud: baud(),
                    bytes: bytes[..count].to_vec(),
                }),
                Err(error) if error.kind() == io::ErrorKind::Interrupted => continue,
                Err(error) => Err(error),
            };
            let failed = chunk.is_err();
            if sender.send(chunk).is_err() || failed {
                return;
            }
        }
    });
    receiver
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plant::{Plant, PlantConfig};
    use crate::servo_kind::ServoKind;
    use armbridge_servo::Firmware;

    const PING: [u8; 6] = [0xAA, 3, 1, 0xFE, 1, 0xF9];
    const PONG: [u8; 6] = [0xAA, 3, 0xFE, 1, 1, 0xF9];

    fn live() -> WallClockBench {
        WallClockBench::new(Bench::new(Plant::new(PlantConfig::default(), 1)), 1)
    }

    #[test]
    fn a_closed_peer_is_answered_and_echo_comes_first() {
        for echo in [false, true] {
            let (mut live, mut received) = (live(), Vec::new());
            for _ in 0..2 {
                live.serve(&PING[..], &mut received, || None, echo).unwrap();
            }
            let sent = if echo { PING.as_slice() } else { &[] };
            assert_eq!(received, [sent, &PONG].concat().repeat(2), "echo {echo}");
        }
    }

    #[test]
    fn servos_of_each_firmware_answer_the_first_request() {
        for (firmware, ping) in [
            (Firmware::Morpheus, &PING[..]),
            (Firmware::Stock, &[0xFF, 0xFF, 1, 2, 1, 0xFB]),
            (
                Firmware::XSeries,
                &[0xFF, 0xFF, 0xFD, 0, 1, 3, 0, 1, 0x19, 0x4E],
            ),
        ] {
            let servo = ServoKind::new(firmware, 1, 1_000_000).unwrap();
            let plant = Plant::new(PlantConfig::default(), 1);
            let mut live = WallClockBench::new(Bench::with_servos(plant, &[servo]), 1);
            let mut received = Vec::new();
            live.serve(ping, &mut received, || None, false).unwrap();
            assert!(!received.is_empty(), "{firmware}");
        }
    }

    #[test]
    fn an_interrupted_server_ends_though_the_peer_stays() {
        let mut live = live().interrupted_by(|| true);
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        assert!(live.accept(&listener).unwrap().is_none());
        let stays = TcpStream::connect(listener.local_addr().unwrap()).unwrap();
        let ended = live.serve_socket(&stays, &listener, false).unwrap();
        assert!(ended.is_none());
    }

    #[test]
    fn a_suspension_is_left_out() {
        let mut live = live();
        live.advance_to(live.epoch + Duration::from_secs(3600));
        let then_us = STARTED_US + LAG_MAX_US;
        assert_eq!(live.now_us, then_us);
        // From there on as fast as the wall clock, and never back.
        let resumed = live.epoch + Duration::from_micros(LAG_MAX_US);
        live.advance_to(resumed + Duration::from_millis(7));
        assert_eq!(live.now_us, then_us + 7_000);
        live.advance_to(resumed);
        assert_eq!(live.now_us, then_us + 7_000);
    }

    #[test]
    fn bytes_beyond_the_bus_rate_are_delayed() {
        let (mut live, mut received) = (live(), Vec::new());
        let bytes: Vec<u8> = [0xFF; 4_000].into_iter().chain(PING).collect();
        live.serve(io::Cursor::new(bytes), &mut received, || None, false)
            .unwrap();
        assert!(live.now_us >= 40_000, "{} µs", live.now_us);
        assert_eq!(received, PONG);
    }
}
