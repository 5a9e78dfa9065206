//! Messages between a program and the server of a simulated board's link.
//!
//! They share the link's stream and [frames](super::frame) with the messages of the board, and
//! have directions of their own: `S` towards the server, `P` towards the program. The server
//! takes the first out of the stream, and the program's link takes out the second, so that
//! neither a board nor a log ever sees one. A board that gets one all the same ignores it, as
//! it does its own echo.
//!
//! ```text
//! program                                  server
//!    |-- Join: who, and whether to observe -->|   first, before the hello
//!    |<-- Role: who commands -----------------|   once it is known, and when it changes
//!    |-- Touch: a hand on the arm ----------->|   at any time, from any program
//!    |<-- Touched: done, or the reason -------|
//! ```

use core::fmt;

use postcard::experimental::max_size::MaxSize;
use serde::{Deserialize, Serialize};

use super::frame::Message;
use armbridge_servo::JOINTS;

/// Bytes of a program's name.
pub const NAME_LEN: usize = 24;

/// From a program to the server.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, MaxSize)]
pub enum ToServer {
    /// Announces the program.
    Join {
        /// It only observes: its hello never makes it the commander.
        is_observer: bool,
        /// Name of the program.
        program: Program,
    },
    /// A hand on the simulated arm; no command of the board.
    Touch(Touch),
}

/// From the server to a program.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, MaxSize)]
pub enum FromServer {
    /// The program's role.
    Role(LinkRole),
    /// Answer to [`ToServer::Touch`]; of a motion, when it has ended.
    Touched(Result<(), TouchRefusal>),
}

impl Message for ToServer {
    const DIRECTION: u8 = b'S';
}

impl Message for FromServer {
    const DIRECTION: u8 = b'P';
}

/// Role of a program on a served link.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, MaxSize)]
pub struct LinkRole {
    /// Its commands reach the board.
    pub is_commander: bool,
    /// The program that commands, if one does.
    pub commander: Option<Program>,
    /// The arm is simulated, and can be pushed and moved by hand.
    pub is_touchable: bool,
}

/// Identity of a program, for other users of the link. Nothing depends on it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, MaxSize)]
pub struct Program {
    /// Its name in ASCII, padded with zeros; all zeros if it is not known.
    name: [u8; NAME_LEN],
    /// Its process.
    process: u32,
}

impl Program {
    /// A program that has not announced itself.
    pub const UNKNOWN: Self = Self {
        name: [0; NAME_LEN],
        process: 0,
    };

    /// A program with this name, of which the first [`NAME_LEN`] bytes are kept.
    pub fn new(name: &str, process: u32) -> Self {
        let mut program = Self {
            process,
            ..Self::UNKNOWN
        };
        for (kept, byte) in program.name.iter_mut().zip(name.bytes()) {
            *kept = byte;
        }
        program
    }
}

/// As "armbridge run (process 4242)". The name comes from another program: only printable
/// ASCII reaches a terminal.
impl fmt::Display for Program {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if *self == Self::UNKNOWN {
            return f.write_str("another program");
        }
        for byte in self.name.iter().take_while(|byte| **byte != 0) {
            let is_printable = byte.is_ascii_graphic() || *byte == b' ';
            let shown = if is_printable { char::from(*byte) } else { '?' };
            fmt::Write::write_char(f, shown)?;
        }
        write!(f, " (process {})", self.process)
    }
}

/// A hand on the simulated arm. Angles and torques are the arm's true ones, which the board's
/// calibration does not affect.
///
/// ```
/// use armbridge_link::server::{Touch, TouchRefusal};
///
/// let push = Touch::Push { joint: 1, torque_nm: -0.2, duration_us: 100_000 };
/// assert_eq!(push.check(), Ok(()));
/// let too_fast = Touch::Move { angle_rad: [0.3, 0.0], duration_us: 100_000 };
/// assert_eq!(too_fast.check(), Err(TouchRefusal::Value));
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, MaxSize)]
pub enum Touch {
    /// A torque on a joint.
    Push {
        /// Joint, counting from 0.
        joint: u8,
        /// In N m.
        torque_nm: f32,
        /// In µs.
        duration_us: u32,
    },
    /// Moves the arm to these angles in this time, and holds it there until a motor drives it
    /// or it is released.
    Move {
        /// In rad.
        angle_rad: [f32; JOINTS],
        /// In µs.
        duration_us: u32,
    },
    /// Moves it to the angles at which the simulation began, and holds it there.
    Lift,
    /// Lets go of it.
    Release,
}

/// Reason for which the arm is not touched.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, MaxSize)]
pub enum TouchRefusal {
    /// The board is armed: a hand would work against the motors.
    Armed,
    /// A value is beyond its bounds.
    Value,
    /// The server has no simulated arm of its own.
    NoArm,
}

impl Touch {
    /// Largest torque of a push, in N m: four times what a servo has.
    pub const TORQUE_MAX_NM: f32 = 6.0;
    /// Longest push and longest motion.
    pub const DURATION_MAX_US: u32 = 60_000_000;
    /// Duration of a lift.
    pub const LIFT_US: u32 = 1_000_000;
    /// Shortest motion of a hand: from one end stop to the other it peaks at 10 rad/s.
    pub const MOVE_MIN_US: u32 = 1_000_000;
    /// Largest angle of a motion in rad: inside the board's angle limit.
    pub const ANGLE_MAX_RAD: f32 = 1.4;

    /// Duration of a motion of a hand in µs; 0 if it is none.
    pub fn motion_us(&self) -> u32 {
        match *self {
            Self::Move { duration_us, .. } => duration_us,
            Self::Lift => Self::LIFT_US,
            Self::Push { .. } | Self::Release => 0,
        }
    }

    /// Checks all values.
    ///
    /// # Errors
    /// If one is beyond its bounds.
    pub fn check(&self) -> Result<(), TouchRefusal> {
        let is_valid = match *self {
            Self::Push {
                joint,
                torque_nm,
                duration_us,
            } => {
                usize::from(joint) < JOINTS
                    && torque_nm.abs() <= Self::TORQUE_MAX_NM
                    && duration_us <= Self::DURATION_MAX_US
            }
            Self::Move {
                angle_rad,
                duration_us,
            } => {
                angle_rad.iter().all(|q| q.abs() <= Self::ANGLE_MAX_RAD)
                    && (Self::MOVE_MIN_US..=Self::DURATION_MAX_US).contains(&duration_us)
            }
            Self::Lift | Self::Release => true,
        };
        if is_valid {
            Ok(())
        } else {
            Err(TouchRefusal::Value)
        }
    }
}

#[cfg(test)]
mod tests {
    extern crate std;

    use super::*;
    use std::string::ToString;

    use crate::frame::{Decoder, Encoder, FrameError};
    use crate::message::ToBoard;

    #[test]
    fn a_board_takes_none_of_these_frames() {
        let join = ToServer::Join {
            is_observer: true,
            program: Program::new("armbridge watch", 7),
        };
        let (mut encoder, mut board, mut server) =
            (Encoder::default(), Decoder::default(), Decoder::default());
        let (_, frame) = encoder.encode(&join);
        let at_board = frame.iter().find_map(|byte| board.push::<ToBoard>(*byte));
        assert_eq!(at_board, Some(Err(FrameError::Direction)));
        let at_server = frame.iter().find_map(|byte| server.push::<ToServer>(*byte));
        assert_eq!(at_server.unwrap().unwrap().message, join);
    }

    #[test]
    fn a_name_cannot_control_a_terminal() {
        let shown = Program::new("evil\u{1b}[2J\nx", 3).to_string();
        assert_eq!(shown, "evil?[2J?x (process 3)");
        assert_eq!(Program::UNKNOWN.to_string(), "another program");
    }

    #[test]
    fn values_have_bounds() {
        let push = |joint, torque_nm| Touch::Push {
            joint,
            torque_nm,
            duration_us: 1,
        };
        let to = |angle, duration_us| Touch::Move {
            angle_rad: [0.0, angle],
            duration_us,
        };
        for (touch, is_valid) in [
            (push(1, -6.0), true),
            (push(2, 1.0), false),
            (push(0, f32::NAN), false),
            (to(1.4, 1_000_000), true),
            (to(1.5, 1_000_000), false),
            (to(f32::INFINITY, 1_000_000), false),
            (to(0.0, 999_999), false),
            (Touch::Release, true),
        ] {
            assert_eq!(touch.check().is_ok(), is_valid, "{touch:?}");
        }
    }
}
