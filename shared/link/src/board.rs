//! Report of a board: end of its last program, source of its settings and what of them is lost,
//! use of its stack.

use postcard::experimental::max_size::MaxSize;
use postcard_schema::Schema;
use serde::{Deserialize, Serialize};

/// Bytes of a source file's name that are kept: its end is the most specific part.
pub const PLACE_LEN: usize = 24;

/// Sent after the board's hello, and again when something of it changes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default, Serialize, Deserialize, Schema, MaxSize)]
pub struct BoardReport {
    /// Changes with every reset and with every hello: a command of an earlier
    /// session is not executed. See [`Command::Arm`](super::message::Command::Arm).
    pub session: u32,
    /// End of the previous program.
    pub last_end: LastEnd,
    /// Source of its settings.
    pub settings: SettingsFrom,
    /// Stack, in bytes, if it is watched.
    pub stack: Option<Stack>,
    /// CRC-32/ISO-HDLC of the program in flash; `None` where there is no flash.
    pub image: Option<u32>,
}

/// Low bits of a session's number that count the hellos since the last reset; the
/// others count the resets.
pub const HELLO_BITS: u32 = 16;

impl BoardReport {
    /// Whether the board has been reset between this report and a later one.
    pub fn is_before_reset(&self, later: &Self) -> bool {
        self.session >> HELLO_BITS != later.session >> HELLO_BITS
    }
}

/// End of a program, recorded across the reset that followed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default, Serialize, Deserialize, Schema, MaxSize)]
pub struct LastEnd {
    /// Cause.
    pub cause: End,
    /// Program counter; 0 if it is not known.
    pub pc: u32,
    /// Line of the source file that panicked; 0 otherwise.
    pub line: u32,
    /// The end of that file's name, filled up with zeros.
    pub place: [u8; PLACE_LEN],
    /// The last tick that began.
    pub tick: u32,
}

/// Cause of the end of a program.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default, Serialize, Deserialize, Schema, MaxSize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum End {
    /// It did not: power was switched on.
    #[default]
    PowerUp,
    /// The supply sagged.
    BrownOut,
    /// The button, or a debugger.
    ResetPin,
    /// A reset that the program asked for, for no reason that was kept.
    Software,
    /// No good tick for too long.
    Watchdog,
    /// A panic.
    Panic,
    /// A fault of the processor.
    HardFault,
    /// The stack grew beyond its end.
    StackOverflow,
    /// The crystal stopped.
    Crystal,
}

/// Source of a board's settings.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default, Serialize, Deserialize, Schema, MaxSize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum SettingsFrom {
    /// They are the defaults: none were ever saved.
    #[default]
    Default,
    /// As saved.
    Saved,
    /// The defaults, because what was saved is damaged.
    Damaged,
    /// As saved by another version, except for these groups, which that version encoded
    /// otherwise: they are the defaults.
    OtherVersion {
        /// Groups that are lost.
        lost: SettingsGroups,
    },
    /// The defaults, because what was saved is beyond the hard bounds.
    Refused,
    /// The defaults, because the memory cannot be read.
    Unreadable,
}

impl SettingsFrom {
    /// Groups of settings that were saved and are not in force. The board is not armed
    /// before the host confirms the others.
    pub const fn lost(self) -> SettingsGroups {
        match self {
            Self::Default | Self::Saved => SettingsGroups::NONE,
            Self::OtherVersion { lost } => lost,
            Self::Damaged | Self::Refused | Self::Unreadable => SettingsGroups::ALL,
        }
    }
}

/// Groups of settings, as bits: each is stored, and lost, as a whole.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default, Serialize, Deserialize, Schema, MaxSize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct SettingsGroups(u8);

impl SettingsGroups {
    /// No group.
    pub const NONE: Self = Self(0);
    /// Period, controller, estimator and friction compensation.
    pub const CONTROL: Self = Self(1 << 0);
    /// Model of the arm.
    pub const ARM: Self = Self(1 << 1);
    /// Calibration of the servos.
    pub const JOINTS: Self = Self(1 << 2);
    /// Limits.
    pub const LIMITS: Self = Self(1 << 3);
    /// All groups.
    pub const ALL: Self = Self(0b1111);

    /// True if empty.
    pub const fn is_empty(self) -> bool {
        self.0 == 0
    }

    /// Whether all of `groups` are in it.
    pub const fn contains(self, groups: Self) -> bool {
        self.0 & groups.0 == groups.0
    }

    /// Groups that are in either.
    #[must_use]
    pub const fn or(self, groups: Self) -> Self {
        Self(self.0 | groups.0)
    }
}

/// Use of the stack since reset, in bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, Schema, MaxSize)]
pub struct Stack {
    /// Most that was ever in use.
    pub used: u32,
    /// All there is.
    pub size: u32,
}
