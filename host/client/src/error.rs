//! Reasons for the end of a session, and causes that a board reports, as text.

use armbridge_link::message::{End, Hello, LastEnd, Missing};
use armbridge_link::schema;

/// Reason for the end of a session.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum SessionError {
    /// No valid frame came from the board.
    #[error("{}", no_board(*.damaged))]
    NoBoard {
        /// Invalid frames that were received.
        damaged: u64,
    },
    /// The board was built from other message types.
    #[error(
        "the board speaks another schema ({}; this host {}): build and flash both from the \
         same source", build(*.0), build(schema::HELLO)
    )]
    OtherSchema(Hello),
    /// The board stopped answering commands.
    #[error("the board stopped answering: was it reset or unplugged?")]
    Silent,
}

/// End of a program, the cause of a reset, as text.
pub fn end_in_words(end: &LastEnd) -> String {
    let at = |cause: &str| format!("{cause} in tick {}, at address {:#010x}", end.tick, end.pc);
    match end.cause {
        End::PowerUp => "its power was off; check the cable".into(),
        End::BrownOut => "its supply sagged; check it under load".into(),
        End::ResetPin => "its reset button was pressed, or a debugger did it".into(),
        End::Software => "its program asked for it".into(),
        End::Watchdog => at("its watchdog found no good tick for too long;"),
        End::HardFault => at("a fault of its processor"),
        End::StackOverflow => at("its stack overflowed"),
        End::Crystal => "its crystal stopped; the board is defective".into(),
        End::Panic => {
            let place = end
                .place
                .split(|byte| *byte == 0)
                .next()
                .unwrap_or_default();
            let place = String::from_utf8_lossy(place);
            format!("a panic in tick {}, at {place}:{}", end.tick, end.line)
        }
    }
}

fn no_board(damaged: u64) -> String {
    match damaged {
        0 => "no answer from the board: is it running, and is this its link?".into(),
        _ => format!(
            "{damaged} frames came that are no Armbridge frames of this version: \
             is this the board's link? Flash board and build host from the same version"
        ),
    }
}

fn build(hello: Hello) -> String {
    let schema = u64::from_be_bytes(hello.schema);
    let [major, minor, patch] = hello.version;
    format!("{schema:016x}, version {major}.{minor}.{patch}")
}

/// Likely reason for which a servo does not reply.
pub(crate) fn likely_cause(missing: Missing) -> &'static str {
    match missing {
        Missing::NotAsked | Missing::Silence => {
            "nothing was received; check its power, its id and the data wire"
        }
        Missing::EchoOnly => "only our own bytes were received; check its power and its id",
        Missing::BadChecksum => {
            "a damaged reply was received; two servos with one id, or a poor ground?"
        }
        Missing::WrongId => "another servo answered; check the ids",
        Missing::Short => "its reply broke off; check the supply voltage under load",
        Missing::Line => "the line was disturbed; wrong baud rate, or direction pin not connected?",
    }
}
