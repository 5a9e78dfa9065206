//! Listener of a board's owner: takes requests, repeats the order until the board reports it,
//! and answers.

use std::io::{self, Read, Write};
use std::time::{Duration, Instant};

use armbridge_link::frame::Decoder;
use armbridge_link::message::{Fault, Mode, ToHost};

use super::local::{self, Stream};
use super::{Answer, BoardKey, Order};

/// Longest wait for a request's line.
const LINE_TIMEOUT: Duration = Duration::from_millis(100);
/// Longest wait for the board's report.
const REPORT_TIMEOUT: Duration = Duration::from_secs(1);
/// Interval at which an order is repeated until it is reported.
const INTERVAL: Duration = Duration::from_millis(20);
/// Interval of the looks for requests: far below the 100 ms in which a stop acts.
const POLL_INTERVAL: Duration = Duration::from_millis(2);
/// Requests at a time: one more is a stop, and may get no answer.
const REQUESTS_MAX: usize = 8;
/// Longest line of a request.
const LINE_MAX: usize = 16;

/// A connection whose order is not known yet.
#[derive(Debug)]
struct Arriving {
    stream: Stream,
    line: Vec<u8>,
    until: Instant,
}

impl Arriving {
    /// The order, when it is known; in doubt a stop.
    fn order(&mut self, now: Instant) -> Option<Order> {
        let mut bytes = [0; LINE_MAX];
        match self.stream.read(&mut bytes) {
            Ok(0) => return Some(Order::Stop),
            Ok(count) => self.line.extend_from_slice(&bytes[..count]),
            Err(error) if error.kind() == io::ErrorKind::WouldBlock => {}
            Err(_) => return Some(Order::Stop),
        }
        if self.line.starts_with(b"disarm\n") {
            return Some(Order::Disarm);
        }
        let is_over = self.line.contains(&b'\n') || self.line.len() >= LINE_MAX;
        (is_over || now >= self.until).then_some(Order::Stop)
    }
}

/// An order that the board has not reported yet.
#[derive(Debug)]
struct Pending {
    order: Order,
    until: Instant,
    next: Instant,
    streams: Vec<Stream>,
}

/// Socket of a board's owner.
#[derive(Debug)]
pub(super) struct StopListener {
    listener: local::Listener,
    arriving: Vec<Arriving>,
    pending: Option<Pending>,
    decoder: Decoder,
    next_poll: Instant,
}

impl StopListener {
    pub(super) fn open(board: &BoardKey) -> io::Result<Self> {
        Ok(Self {
            listener: local::Listener::bind(board)?,
            arriving: Vec::new(),
            pending: None,
            decoder: Decoder::default(),
            next_poll: Instant::now(),
        })
    }

    /// Takes requests; an order whenever it is to be sent to the board.
    pub(super) fn due(&mut self) -> Option<Order> {
        let now = Instant::now();
        if now >= self.next_poll {
            self.next_poll = now + POLL_INTERVAL;
            self.poll(now);
        }
        let pending = self.pending.as_mut()?;
        if now >= pending.until {
            let reason = "the order was sent, and the board has not reported it";
            self.answer(&Answer::Failed(reason.into()));
            return None;
        }
        let is_due = now >= pending.next;
        if is_due {
            pending.next = now + INTERVAL;
        }
        is_due.then_some(pending.order)
    }

    /// Whether an order waits for the board's report.
    pub(super) fn is_waiting(&self) -> bool {
        self.pending.is_some()
    }

    fn poll(&mut self, now: Instant) {
        while let Some(stream) = self.listener.accept() {
            if self.arriving.len() >= REQUESTS_MAX {
                self.take(Order::Stop, stream, now);
                continue;
            }
            self.arriving.push(Arriving {
                stream,
                line: Vec::new(),
                until: now + LINE_TIMEOUT,
            });
        }
        for mut arriving in std::mem::take(&mut self.arriving) {
            match arriving.order(now) {
                Some(order) => self.take(order, arriving.stream, now),
                None => self.arriving.push(arriving),
            }
        }
    }

    fn take(&mut self, order: Order, stream: Stream, now: Instant) {
        // Only what the board reports from now on is an answer.
        self.decoder = Decoder::default();
        let pending = self.pending.get_or_insert_with(|| Pending {
            order,
            until: now,
            next: now,
            streams: Vec::new(),
        });
        // A stop is not weakened by a request to disarm.
        if order == Order::Stop && pending.order != order {
            (pending.order, pending.next) = (order, now);
        }
        pending.until = now + REPORT_TIMEOUT;
        if pending.streams.len() < REQUESTS_MAX {
            pending.streams.push(stream);
        }
    }

    /// Takes bytes of the board: its report ends a request.
    pub(super) fn receive(&mut self, bytes: &[u8]) {
        for byte in bytes {
            let Some(pending) = &self.pending else {
                return;
            };
            if let Some(Ok(received)) = self.decoder.push::<ToHost>(*byte)
                && let Some(answer) = answer(pending.order, &received.message)
            {
                self.answer(&answer);
            }
        }
    }

    /// Answers all requests: the link is broken.
    pub(super) fn refuse(&mut self) {
        if self.due().is_some() {
            let reason = "its link is broken; a board switches off when its host is silent";
            self.answer(&Answer::Failed(reason.into()));
        }
    }

    fn answer(&mut self, answer: &Answer) {
        for mut stream in self.pending.take().into_iter().flat_map(|all| all.streams) {
            // A short line fits into the socket; one that asked may have gone.
            let _ = writeln!(stream, "{}", answer.line());
        }
    }
}

/// The answer that a message of the board is.
fn answer(order: Order, message: &ToHost) -> Option<Answer> {
    let stopped = |fault: Fault| Some(Answer::Stopped(fault.name().into()));
    match message {
        ToHost::Tripped(trip) => stopped(trip.fault),
        ToHost::Record(record) => match record.mode {
            Mode::Fault(fault) => stopped(fault),
            mode if order == Order::Disarm && !mode.is_armed() => Some(Answer::Disarmed),
            _ => None,
        },
        _ => None,
    }
}
