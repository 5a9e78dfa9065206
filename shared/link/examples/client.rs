//! Client of a board's control link: hello, heartbeats, ten records, goodbye.
//!
//! ```text
//! armbridge serve board --listen tcp://127.0.0.1:7001
//! cargo run --package armbridge-link --example client -- 127.0.0.1:7001
//! ```
//!
//! [`Client`] takes any stream of bytes of which a read ends after some milliseconds without
//! data. It never arms; but a hello begins a session of its own, for which the board switches
//! the motors off.

use std::io::{self, ErrorKind, Read, Write};
use std::net::TcpStream;
use std::process::ExitCode;
use std::time::{Duration, Instant};

use armbridge_link::frame::{Decoder, Encoder};
use armbridge_link::message::{Record, ToBoard, ToHost};
use armbridge_link::schema;

/// Interval of hellos and heartbeats: a quarter of the silence after which the board brakes.
const INTERVAL: Duration = Duration::from_millis(25);
/// Timeout of the board's hello, and of its records.
const TIMEOUT: Duration = Duration::from_secs(3);
/// Number of records that are printed.
const RECORDS: usize = 10;

fn main() -> ExitCode {
    let Some(address) = std::env::args().nth(1) else {
        eprintln!("which address? For example: client 127.0.0.1:7001");
        return ExitCode::from(2);
    };
    match run(&address) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("{address}: {error}");
            ExitCode::FAILURE
        }
    }
}

fn run(address: &str) -> io::Result<()> {
    let stream = TcpStream::connect(address)?;
    stream.set_read_timeout(Some(INTERVAL))?;
    stream.set_nodelay(true)?;
    let mut client = Client::open(stream)?;
    for _ in 0..RECORDS {
        print(&client.record()?);
    }
    client.close()
}

fn print(record: &Record) {
    let [q1, q2] = record.output.angle_rad.map(|q| q * 1e3);
    let [pwm1, pwm2] = record.output.pwm;
    println!(
        "tick {} {:?}: {q1:.1} {q2:.1} mrad, PWM {pwm1} {pwm2}, bus {} us",
        record.tick, record.mode, record.timing.bus_us,
    );
}

/// The host's end of a link.
struct Client<S> {
    stream: S,
    encoder: Encoder,
    decoder: Decoder,
    /// Received bytes, and the number of those that are decoded.
    received: Vec<u8>,
    decoded: usize,
    sent_at: Instant,
}

impl<S: Read + Write> Client<S> {
    /// Says hello until the board answers.
    fn open(mut stream: S) -> io::Result<Self> {
        // An empty frame ends one that an earlier program left unfinished.
        stream.write_all(&[0])?;
        let mut client = Self {
            stream,
            encoder: Encoder::default(),
            decoder: Decoder::default(),
            received: Vec::new(),
            decoded: 0,
            sent_at: Instant::now(),
        };
        client.send(&ToBoard::Hello(schema::HELLO))?;
        let hello = client.wait(&ToBoard::Hello(schema::HELLO), |message| match message {
            ToHost::Hello(hello) => Some(hello),
            _ => None,
        })?;
        let [major, minor, patch] = hello.version;
        println!("board with version {major}.{minor}.{patch}");
        if hello.schema == schema::HASH {
            Ok(client)
        } else {
            Err(io::Error::other(
                "the board has other messages than this program",
            ))
        }
    }

    /// The record of the next tick.
    fn record(&mut self) -> io::Result<Record> {
        self.wait(&ToBoard::Heartbeat, |message| match message {
            ToHost::Record(record) => Some(record),
            _ => None,
        })
    }

    /// Ends the session, without a fault of the board.
    fn close(mut self) -> io::Result<()> {
        self.send(&ToBoard::Goodbye)
    }

    fn send(&mut self, message: &ToBoard) -> io::Result<()> {
        self.sent_at = Instant::now();
        let (_, frame) = self.encoder.encode(message);
        self.stream.write_all(frame)
    }

    /// Receives until a message is accepted, and sends `repeated` at each interval.
    fn wait<T>(
        &mut self,
        repeated: &ToBoard,
        accept: impl Fn(ToHost) -> Option<T>,
    ) -> io::Result<T> {
        let end = Instant::now() + TIMEOUT;
        while Instant::now() < end {
            while let Some(byte) = self.received.get(self.decoded) {
                self.decoded += 1;
                // A damaged frame is skipped. What it had is in a later one.
                if let Some(Ok(frame)) = self.decoder.push::<ToHost>(*byte)
                    && let Some(accepted) = accept(frame.message)
                {
                    return Ok(accepted);
                }
            }
            if self.sent_at.elapsed() >= INTERVAL {
                self.send(repeated)?;
            }
            self.receive()?;
        }
        Err(io::Error::new(
            ErrorKind::TimedOut,
            "the board does not answer; does another program command it?",
        ))
    }

    /// Reads what is there, or nothing within the stream's timeout.
    fn receive(&mut self) -> io::Result<()> {
        self.received.resize(4_096, 0);
        self.decoded = 0;
        let result = self.stream.read(&mut self.received);
        self.received.truncate(*result.as_ref().unwrap_or(&0));
        match result {
            Ok(0) => Err(ErrorKind::UnexpectedEof.into()),
            Err(error) if !matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::TimedOut) => {
                Err(error)
            }
            _ => Ok(()),
        }
    }
}
