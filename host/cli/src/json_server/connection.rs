//! Lines of a connection: requests in, answers out.
//!
//! One thread reads, and carries out a stop at once; another carries out everything else in order.
//! Up to [`WAITING_MAX`] requests wait, each of at most [`LINE_MAX`] bytes. A program that does not
//! read its answers for [`WRITE_TIMEOUT`] is disconnected.

use std::io::{BufRead, BufReader, Read, Write};
use std::net::{Shutdown, TcpStream};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, SyncSender, TrySendError, sync_channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use armbridge_client::transport::Intent;
use armbridge_sim::Bench;
use armbridge_sim::link::{BoardClient, BoardUri, Options};
use armbridge_sim::plant::{Plant, PlantConfig};
use serde_json::Value;

use super::answer::{Failure, line};
use super::board::Board;
use super::request::{Line, Request};

/// Requests that wait while one is carried out.
const WAITING_MAX: usize = 64;
/// Bytes of a line: an experiment, or parameters, have some hundred.
const LINE_MAX: u64 = 64 * 1024;
/// Longest time in which the system's buffer takes no bytes of an answer.
const WRITE_TIMEOUT: Duration = Duration::from_secs(2);

/// Answers of a connection, by whichever thread has one.
#[derive(Clone)]
struct Answers(Arc<Mutex<TcpStream>>);

impl Answers {
    /// Writes an answer; the connection is closed if that fails.
    fn write(&self, answer: &[u8]) {
        let mut stream = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        if stream.write_all(answer).is_err() {
            let _ = stream.shutdown(Shutdown::Both);
        }
    }
}

/// Says why a connection is closed.
pub(super) fn refuse(mut stream: TcpStream, why: &str) {
    // It is closed either way.
    let _ = stream.set_write_timeout(Some(WRITE_TIMEOUT));
    let _ = stream.write_all(&line(None, Err(Failure::busy(why))));
}

/// Serves a connection until it ends, by which the arm is parked or the board disarmed.
pub(super) fn serve(stream: TcpStream, link: &BoardUri) {
    let is_set =
        stream.set_nodelay(true).is_ok() && stream.set_write_timeout(Some(WRITE_TIMEOUT)).is_ok();
    let (true, Ok(writer)) = (is_set, stream.try_clone()) else {
        return;
    };
    let answers = Answers(Arc::new(Mutex::new(writer)));
    let mut lines = BufReader::new(stream);
    let Some(first) = next(&mut lines, &answers) else {
        return;
    };
    let intent = match first.request {
        Ok(Request::Observe {}) => Intent::Observe,
        _ => Intent::CommandOrObserve,
    };
    let is_gone = Arc::new(AtomicBool::new(false));
    let client = match open(link, intent, &is_gone) {
        Ok(client) => Arc::new(client),
        Err(failure) => return answers.write(&line(first.id, Err(failure))),
    };
    let (requests, waiting) = sync_channel(WAITING_MAX);
    std::thread::scope(|scope| {
        let (theirs, board) = (answers.clone(), Board::new(Arc::clone(&client)));
        let performs = std::thread::Builder::new().name("json-board".into());
        let begun = performs.spawn_scoped(scope, move || perform(board, &waiting, &theirs));
        if begun.is_ok() {
            read(first, &mut lines, &client, &requests, &answers);
        }
        is_gone.store(true, Ordering::Relaxed);
        drop(requests);
    });
    // The arm is parked or let go of; the program that would read of an error is gone.
    let _ = client.close();
}

fn open(
    link: &BoardUri,
    intent: Intent,
    is_gone: &Arc<AtomicBool>,
) -> Result<BoardClient, Failure> {
    let is_gone = Arc::clone(is_gone);
    let options = move || {
        // The link has a bench of its own.
        let bench = Bench::new(Plant::new(PlantConfig::default(), 1));
        let mut options = Options::new(bench);
        options.link.is_quiet = true;
        options.link.intent = intent;
        options
    };
    let is_interrupted = move || is_gone.load(Ordering::Relaxed);
    Ok(BoardClient::open(link.clone(), options, is_interrupted)?)
}

/// Reads requests until the connection ends.
fn read(
    first: Line,
    lines: &mut impl BufRead,
    client: &BoardClient,
    requests: &SyncSender<(Option<Value>, Request)>,
    answers: &Answers,
) {
    let mut line_read = Some(first);
    while let Some(Line { id, request }) = line_read {
        match request {
            Err(why) => answers.write(&line(id, Err(Failure::request(why)))),
            Ok(Request::Stop {}) => {
                let stopped = client.stop().map_err(Failure::from);
                answers.write(&line(id, stopped.map(|()| serde_json::Map::new())));
            }
            Ok(request) => match requests.try_send((id, request)) {
                Ok(()) => {}
                Err(TrySendError::Full((id, _))) => {
                    let why = format!("{WAITING_MAX} requests wait: read their answers first");
                    answers.write(&line(id, Err(Failure::busy(why))));
                }
                Err(TrySendError::Disconnected(_)) => return,
            },
        }
        line_read = next(lines, answers);
    }
}

/// The next line that is not empty; `None` at the end, within a line too.
fn next(lines: &mut impl BufRead, answers: &Answers) -> Option<Line> {
    loop {
        let mut text = Vec::new();
        lines
            .by_ref()
            .take(LINE_MAX)
            .read_until(b'\n', &mut text)
            .ok()?;
        if text.last() != Some(&b'\n') {
            if text.len() as u64 == LINE_MAX {
                let why = format!("a line has at most {LINE_MAX} bytes");
                answers.write(&line(None, Err(Failure::request(why))));
            }
            return None;
        }
        if !text.trim_ascii().is_empty() {
            return Some(Line::parse(&text));
        }
    }
}

/// Carries out requests in order until no more can come.
fn perform(mut board: Board, requests: &Receiver<(Option<Value>, Request)>, answers: &Answers) {
    for (id, request) in requests {
        answers.write(&line(id, board.perform(request)));
    }
}
