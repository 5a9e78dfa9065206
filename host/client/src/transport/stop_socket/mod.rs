//! Motors switched off from a second terminal: a local socket of each program that has a board.
//!
//! A serial port, a board's USB pipes, a pseudo-terminal and a simulated board have one owner, so
//! `armbridge stop` in a second terminal cannot open them. Each owner listens on a local socket:
//! on Unix a Unix domain socket, in a folder that only its user may enter; on Windows a named
//! pipe. Its name is the board's key and a number of the owner's, so that no program is in another
//! one's way, and the owner of a board is found without asking all.
//!
//! A connection is a request. Its first line is `stop` or `disarm`, and in doubt a stop is meant:
//! also by a connection that closes, or says nothing for 100 ms. The answer is one line, when the
//! board has reported what was asked for, or after a second.
//!
//! A socket that its owner has left behind refuses connections, and the next program that
//! asks removes it. On Windows a pipe ends with its owner.

mod key;
mod listener;
#[cfg_attr(unix, path = "unix.rs")]
#[cfg_attr(windows, path = "windows.rs")]
mod local;
mod relay;

pub use key::BoardKey;
pub use relay::StopRelay;

use std::io::{Read, Write};
use std::sync::mpsc::channel;
use std::time::Duration;

/// Environment variable with the one folder of sockets, on Unix: programs in another are not
/// found.
pub const FOLDER_VARIABLE: &str = "ARMBRIDGE_SOCKETS";
/// Longest wait for an owner's answer.
const ANSWER_TIMEOUT: Duration = Duration::from_secs(3);
/// Longest answer.
const ANSWER_MAX: u64 = 512;

/// Request to the owner of a link.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Order {
    /// The emergency stop.
    Stop,
    /// Motors off, without a fault.
    Disarm,
}

impl Order {
    /// Its line.
    fn word(self) -> &'static str {
        match self {
            Self::Stop => "stop",
            Self::Disarm => "disarm",
        }
    }
}

/// Answer of an owner.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Answer {
    /// The board reports this fault, by its name: motors are off.
    Stopped(String),
    /// The board reports that it is not armed, and no fault.
    Disarmed,
    /// It is not known that the board's motors are off, for this reason.
    Failed(String),
}

impl Answer {
    fn line(&self) -> String {
        match self {
            Self::Stopped(fault) => format!("stopped {fault}"),
            Self::Disarmed => "disarmed".into(),
            Self::Failed(reason) => format!("failed {reason}"),
        }
    }

    fn parse(line: &str) -> Option<Self> {
        let (word, rest) = line.split_once(' ').unwrap_or((line, ""));
        match word {
            "stopped" => Some(Self::Stopped(rest.into())),
            "disarmed" => Some(Self::Disarmed),
            "failed" => Some(Self::Failed(rest.into())),
            _ => None,
        }
    }
}

/// A program that was asked, and its answer.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct OwnerAnswer {
    /// The board that it has.
    pub board: BoardKey,
    /// Its process.
    pub process: u32,
    /// Its answer.
    pub answer: Answer,
}

/// Asks the owners of this board, or of all boards, at the same time. Owners are programs of
/// this user.
pub fn ask(board: Option<&BoardKey>, order: Order) -> Vec<OwnerAnswer> {
    let owners = local::owners()
        .into_iter()
        .filter(|owner| board.is_none_or(|board| owner.board == *board));
    let (sender, answers) = channel();
    let mut asked: Vec<OwnerAnswer> = owners
        .filter_map(|owner| {
            let stream = local::connect(&owner).ok()?;
            let answer = Answer::Failed("it does not answer".into());
            Some((stream, owner.board, owner.process, answer))
        })
        .enumerate()
        .map(|(number, (stream, board, process, answer))| {
            let sender = sender.clone();
            // One that never answers leaves a thread, which ends with this program.
            std::thread::spawn(move || sender.send((number, request(stream, order))));
            OwnerAnswer {
                board,
                process,
                answer,
            }
        })
        .collect();
    drop(sender);
    let until = std::time::Instant::now() + ANSWER_TIMEOUT;
    loop {
        let left = until.saturating_duration_since(std::time::Instant::now());
        // All have answered, or time is over.
        let Ok((number, answer)) = answers.recv_timeout(left) else {
            return asked;
        };
        if let (Some(asked), Some(answer)) = (asked.get_mut(number), answer) {
            asked.answer = answer;
        }
    }
}

fn request(mut stream: local::Stream, order: Order) -> Option<Answer> {
    writeln!(stream, "{}", order.word()).ok()?;
    let mut answer = String::new();
    stream.take(ANSWER_MAX).read_to_string(&mut answer).ok()?;
    Answer::parse(answer.trim_end())
}

/// The program that has the socket.
#[derive(Clone, Debug, PartialEq, Eq)]
struct Owner {
    board: BoardKey,
    process: u32,
    /// Name of its socket.
    name: String,
}

impl Owner {
    /// Of a socket's name: `KEY#PROCESS-NUMBER.stop`.
    fn of(name: &str) -> Option<Self> {
        let (board, rest) = name.strip_suffix(SUFFIX)?.rsplit_once('#')?;
        let (process, _) = rest.split_once('-')?;
        Some(Self {
            board: BoardKey::from_name(board),
            process: process.parse().ok()?,
            name: name.into(),
        })
    }
}

/// Ending of a socket's name.
const SUFFIX: &str = ".stop";
/// Boards that one program may have at a time.
const BOARDS_MAX: u32 = 64;

/// Names for a socket of this process.
fn names(board: &BoardKey) -> impl Iterator<Item = String> {
    let process = std::process::id();
    (0..BOARDS_MAX).map(move |number| format!("{board}#{process}-{number}{SUFFIX}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_name_leads_back_to_board_and_process() {
        let board = BoardKey::from_name("sim:");
        let name = names(&board).nth(1).unwrap();
        let owner = Owner::of(&name).unwrap();
        assert_eq!((&owner.board, &owner.name), (&board, &name));
        assert_eq!(owner.process, std::process::id());
        for other in ["", "sim:.stop", "sim:#1.stop", "sim:#x-1.stop", "sim:#1-1"] {
            assert_eq!(Owner::of(other), None, "{other}");
        }
    }

    #[test]
    fn answers_are_read_as_they_are_written() {
        for answer in [
            Answer::Stopped("emergency_stop_host".into()),
            Answer::Disarmed,
            Answer::Failed("the link is broken".into()),
        ] {
            assert_eq!(Answer::parse(&answer.line()), Some(answer));
        }
        assert_eq!(Answer::parse(""), None);
    }
}
