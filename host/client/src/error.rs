//! Why a run came to nothing, and what to do about it.

use armbridge_shared::link::message::{End, Fault, Hello, LastEnd, Missing, Refusal};
use armbridge_shared::link::schema;
use armbridge_shared::servo::Firmware;

use crate::names;
use crate::refusal;

/// Why a run came to nothing.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum OperatorError {
    /// Nothing that can be read came from the board.
    #[error("{}", no_board(*.damaged))]
    NoBoard {
        /// Frames that came but could not be read.
        damaged: u64,
    },
    /// The board was built from other message types.
    #[error(
        "the board speaks another schema ({}; this host {}): build and flash both from the \
         same source", build(*.0), build(schema::HELLO)
    )]
    OtherSchema(Hello),
    /// The board looks for its servos in vain.
    #[error("{}", no_servos(*.last))]
    NoServos {
        /// Joint that was missed last, and what was heard; `None` if the board
        /// says nothing about it.
        last: Option<(u8, Missing)>,
    },
    /// The servos run different firmwares.
    #[error(
        "servo 1 runs {0} and servo 2 {1}: they disturb each other on one bus; flash both with \
         the same firmware"
    )]
    Mixed(Firmware, Firmware),
    /// A stock servo does not take its settings.
    #[error(
        "servo {servo} answers, but cannot be set to wheel mode: is its EEPROM locked? \
         Switch its power off and on",
        servo = u32::from(*.0) + 1
    )]
    Unprepared(u8),
    /// The board refused a command.
    #[error("the board refused `{command}`: {}", refusal::in_words(*.refusal))]
    Refused {
        /// Its name.
        command: &'static str,
        /// Why.
        refusal: Refusal,
    },
    /// The board has begun anew, with its motors off.
    #[error("the board has been reset: {}", end_in_words(.0))]
    Reset(LastEnd),
    /// Torque cannot come on.
    #[error(
        "a fault is latched on the board, `{}`: see to its cause, then clear it (`run --clear`)",
        names::fault(*.0)
    )]
    Latched(Fault),
    /// The link broke while the motors were on.
    #[error(
        "the link to the board broke in mid-run; the arm was braked by the board and let go of \
         within half a second, and is not armed again: look at the cable, then run again"
    )]
    Parted,
    /// Torque went off without a fault, and not by this host.
    #[error(
        "somebody else disarmed the board in mid-run: is another program on its link? End it, \
         then run again"
    )]
    Disarmed,
    /// A setting of the scenario does not go with the board's.
    #[error("{0}")]
    Setting(#[from] crate::params::ParameterError),
    /// The settings that come of both.
    #[error("with the board's own settings, the scenario's cannot be: {}", refusal::in_words(*.0))]
    Settings(Refusal),
    /// The board stopped answering commands.
    #[error("the board stopped answering: was it reset or unplugged?")]
    Silent,
}

/// How a program ended, as the cause of a reset.
pub fn end_in_words(end: &LastEnd) -> String {
    let at = |what: &str| format!("{what} in tick {}, at address {:#010x}", end.tick, end.pc);
    match end.cause {
        End::PowerUp => "its power was off; check the cable".into(),
        End::BrownOut => "its supply sagged; check it under load".into(),
        End::ResetPin => "its reset button was pressed, or a debugger did it".into(),
        End::Software => "its program asked for it".into(),
        End::Watchdog => at("its watchdog found no good tick for too long;"),
        End::HardFault => at("a fault of its processor"),
        End::StackOverflow => at("its stack overflowed"),
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

fn no_servos(last: Option<(u8, Missing)>) -> String {
    match last {
        None => "the board does not find its servos: check their power and wiring".into(),
        Some((joint, missing)) => {
            let servo = u32::from(joint) + 1;
            format!("servo {servo} does not answer: {}", likely_cause(missing))
        }
    }
}

/// Why a servo that is asked for does not answer.
pub fn likely_cause(missing: Missing) -> &'static str {
    match missing {
        Missing::NotAsked | Missing::Silence => {
            "nothing was heard; check its power, its id and the data wire"
        }
        Missing::EchoOnly => "only our own bytes were heard; check its power and its id",
        Missing::BadChecksum => {
            "a damaged reply was heard; two servos with one id, or a poor ground?"
        }
        Missing::WrongId => "another servo answered; check the ids",
        Missing::Short => "its reply broke off; check the supply voltage under load",
        Missing::Line => "the line was disturbed; wrong baud rate, or direction pin not connected?",
    }
}
