//! Motors off on boards that are running: what `stop` and `disarm` have in common.
//!
//! Without a link every board is meant that a program of this user has, that is plugged in, or
//! that the configuration names. A program that has a board is asked to do it; a board that
//! no program of this user has is opened. A simulated board is never made for it.

use std::process::ExitCode;

use armbridge::board_tasks::TaskError;
use armbridge::board_tasks::motors_off::{Goal, MotorsOff};
use armbridge::config::Config;
use armbridge_client::transport::stop_socket::{Answer, BoardKey, Order, OwnerAnswer, ask};
use armbridge_client::transport::{LinkUri, usb_discovery};
use armbridge_client::{fault_text, stdio};
use armbridge_link::message::{Fault, Mode};
use armbridge_sim::link::{BoardUri, Pace};
use serde_json::{Value, json};

use super::{Error, Outcome, task};
use crate::args::TaskArgs;

/// Remedy where motors may be on.
const OTHERWISE: &str = "use the stop switch at the board, or the switch of the servos' supply";

/// A board that was asked, and what it reports.
struct Board {
    name: String,
    /// A program that has it.
    process: Option<u32>,
    /// Action taken, in words, and the name of the latched fault.
    result: Result<(String, Option<String>), String>,
}

impl Board {
    /// Answer of the link's owner.
    fn of_owner(asked: OwnerAnswer) -> Self {
        let name = asked.board.in_words().to_owned();
        let by = format!("by the program that has {name} (process {})", asked.process);
        let result = match asked.answer {
            Answer::Stopped(fault) => Ok((
                format!("stopped {by}: the board reports {fault}"),
                Some(fault),
            )),
            Answer::Disarmed => Ok((format!("disarmed {by}: motors are off"), None)),
            Answer::Failed(reason) => Err(format!(
                "{name} is in use by process {}: {reason}",
                asked.process
            )),
        };
        Self {
            name,
            process: Some(asked.process),
            result,
        }
    }

    /// Opens a board that no program of this user has.
    fn opened(args: &TaskArgs, link: LinkUri, order: Order) -> Self {
        let name = link.to_string();
        let mut args = args.clone();
        args.link.link = Some(BoardUri::Link(link));
        Self {
            name,
            process: None,
            result: open(&args, order).map_err(|error| error.to_string()),
        }
    }

    fn json(&self) -> Value {
        let (words, fault) = match &self.result {
            Ok((words, fault)) => (words, fault.clone()),
            Err(words) => (words, None),
        };
        json!({
            "board": self.name,
            "process": self.process,
            "is_off": self.result.is_ok(),
            "fault": fault,
            "in_words": words,
        })
    }
}

fn open(args: &TaskArgs, order: Order) -> Result<(String, Option<String>), Error> {
    let (name, goal) = match order {
        Order::Stop => ("stop", Goal::Stop),
        Order::Disarm => ("disarm", Goal::Disarm),
    };
    let (_, host) = task::go(args, name, Pace::Free, MotorsOff::new(goal))?;
    let status = host.session.status();
    let Some(trip) = status
        .trip
        .filter(|_| order == Order::Stop || matches!(status.mode(), Some(Mode::Fault(_))))
    else {
        return Ok(("disarmed: motors are off".into(), None));
    };
    let account = fault_text::in_words(&trip);
    let fault: Fault = trip.fault;
    let message = match order {
        Order::Stop => format!(
            "stopped: {}; `armbridge clear` clears it when the arm is free to move",
            account.cause
        ),
        Order::Disarm => format!(
            "motors are off; a fault is latched: {}; {}",
            account.cause, account.remedy
        ),
    };
    Ok((message, Some(fault.name().into())))
}

/// Runs `stop` or `disarm`.
pub(super) fn run(args: &TaskArgs, order: Order) -> Outcome {
    let boards = match &args.link.link {
        Some(uri) => one(args, uri, order),
        None => all(args, order),
    };
    report(args, &boards, order)
}

/// This board; if it is simulated, each that is running.
fn one(args: &TaskArgs, uri: &BoardUri, order: Order) -> Vec<Board> {
    // The server of a socket passes on a stop, also while the program that commands hangs.
    if let (BoardUri::Link(link @ LinkUri::Tcp(_)), Order::Stop) = (uri, order) {
        let board = Board::opened(args, link.clone(), order);
        if board.result.is_ok() {
            return vec![board];
        }
    }
    let asked = uri.key().map(|key| ask(Some(&key), order));
    let asked = asked.unwrap_or_default();
    let mut boards: Vec<Board> = asked.into_iter().map(Board::of_owner).collect();
    if let BoardUri::Link(link) = uri
        && boards.is_empty()
    {
        boards.push(Board::opened(args, link.clone(), order));
    }
    boards
}

/// Every board that can be found.
fn all(args: &TaskArgs, order: Order) -> Vec<Board> {
    let asked = ask(None, order);
    let mut known: Vec<BoardKey> = asked.iter().map(|asked| asked.board.clone()).collect();
    let mut boards: Vec<Board> = Vec::new();
    for asked in asked {
        let link = asked.board.tcp_link();
        let mut board = Board::of_owner(asked);
        if let (Err(_), Some(link)) = (&board.result, link) {
            board = Board::opened(args, link, order);
        }
        boards.push(board);
    }
    let configured = Config::discover().and_then(|config| config.link(None));
    let configured = match configured {
        Ok(BoardUri::Link(link)) => Some(link),
        Ok(BoardUri::Sim | BoardUri::Emulate(_)) => None,
        // It hides a board perhaps, but none that was asked.
        Err(error) => {
            boards.push(Board {
                name: "the configured board".into(),
                process: None,
                result: Err(error.to_string()),
            });
            None
        }
    };
    for link in usb_discovery::links().into_iter().chain(configured) {
        let Some(key) = BoardKey::of(&link).filter(|key| !known.contains(key)) else {
            continue;
        };
        known.push(key);
        boards.push(Board::opened(args, link, order));
    }
    boards
}

fn report(args: &TaskArgs, boards: &[Board], order: Order) -> Outcome {
    let undone = match order {
        Order::Stop => "STOPPED",
        Order::Disarm => "DISARMED",
    };
    if args.json {
        let boards: Vec<Value> = boards.iter().map(Board::json).collect();
        stdio::print_line(json!({ "boards": boards }))?;
    }
    if boards.is_empty() {
        let reason = match &args.link.link {
            Some(link) => format!("no program of this user runs a board on {link}"),
            None => "no program of this user has a board, none is plugged in, and the \
                     configuration names none"
                .into(),
        };
        return Err(format!("NOTHING WAS {undone}: {reason}; {OTHERWISE}").into());
    }
    let mut failures = Vec::new();
    for board in boards {
        match &board.result {
            Ok((words, _)) if !args.json => stdio::print_line(words)?,
            Ok(_) => {}
            Err(words) => failures.push(words.as_str()),
        }
    }
    if failures.is_empty() {
        return Ok(ExitCode::SUCCESS);
    }
    let nothing_or_not = if failures.len() == boards.len() {
        "NOTHING WAS"
    } else {
        "NOT ALL WERE"
    };
    let mut why = failures.join("; ");
    // Some reasons have the remedy.
    if !why.ends_with(&TaskError::NotStopped.to_string()) {
        why = format!("{why}; {OTHERWISE}");
    }
    Err(format!("{nothing_or_not} {undone}: {why}").into())
}
