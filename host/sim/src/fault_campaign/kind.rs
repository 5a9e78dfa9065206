//! Kinds of injected faults, with one name each.

use std::fmt;
use std::str::FromStr;

use serde::{Serialize, Serializer};

use crate::half_duplex_bus::{BusDirection, ByteDamage};

/// Kinds of faults.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Kind {
    /// Bytes of one direction are damaged.
    Bytes(BusDirection, DamageKind),
    /// The master begins to receive its own bytes.
    EchoOn,
    /// The master no longer receives its own bytes.
    EchoOff,
    /// The data line is held down.
    LineLow,
    /// The data line is held up.
    LineHigh,
    /// A servo is power-cycled.
    ServoReset,
    /// A servo receives and executes, but does not reply.
    ServoMute,
    /// A servo receives nothing, and keeps its last command.
    ServoDeaf,
    /// The servos are swapped.
    ServosSwapped,
    /// A potentiometer's reading stays at one count.
    Frozen,
    /// A potentiometer's wiper has left its track.
    DeadZone,
    /// A motor heats up.
    Hot,
    /// No bytes of the host arrive.
    HostVanish,
    /// Garbage comes at full rate.
    HostFlood,
    /// Garbage comes between good frames.
    HostGarbage,
    /// The host goes on in another schema.
    HostSchema,
    /// Earlier frames are repeated.
    HostReplay,
    /// Commands with numbers that are out of range.
    HostRange,
    /// The host ends its session with a goodbye.
    Goodbye,
    /// The board's clock jumps forward.
    ClockAhead,
    /// The board's clock jumps back.
    ClockBack,
    /// The arm is pushed.
    Push,
    /// A bit of a parameter in force is flipped.
    Corrupt,
    /// The host requests an emergency stop.
    StopHost,
    /// The stop switch is pressed.
    StopPin,
}

/// Kinds of damage to bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum DamageKind {
    /// They never arrive.
    Lost,
    /// They arrive late.
    Late,
    /// They arrive twice.
    Doubled,
    /// They arrive with a bit flipped.
    Flipped,
    /// The rest of their packet does not arrive either.
    CutOff,
}

impl DamageKind {
    /// Damage on the bench; late bytes are delayed by `late_ns`.
    pub(super) fn damage(self, late_ns: u64) -> ByteDamage {
        match self {
            Self::Lost => ByteDamage::Lost,
            Self::Late => ByteDamage::Late { ns: late_ns },
            Self::Doubled => ByteDamage::Doubled,
            Self::Flipped => ByteDamage::Flipped,
            Self::CutOff => ByteDamage::CutOff,
        }
    }
}

impl Kind {
    /// All kinds.
    pub const ALL: [Self; 34] = {
        use BusDirection::{ToMaster, ToServos};
        use DamageKind::{CutOff, Doubled, Flipped, Late, Lost};
        [
            Self::Bytes(ToServos, Lost),
            Self::Bytes(ToServos, Late),
            Self::Bytes(ToServos, Doubled),
            Self::Bytes(ToServos, Flipped),
            Self::Bytes(ToServos, CutOff),
            Self::Bytes(ToMaster, Lost),
            Self::Bytes(ToMaster, Late),
            Self::Bytes(ToMaster, Doubled),
            Self::Bytes(ToMaster, Flipped),
            Self::Bytes(ToMaster, CutOff),
            Self::EchoOn,
            Self::EchoOff,
            Self::LineLow,
            Self::LineHigh,
            Self::ServoReset,
            Self::ServoMute,
            Self::ServoDeaf,
            Self::ServosSwapped,
            Self::Frozen,
            Self::DeadZone,
            Self::Hot,
            Self::HostVanish,
            Self::HostFlood,
            Self::HostGarbage,
            Self::HostSchema,
            Self::HostReplay,
            Self::HostRange,
            Self::Goodbye,
            Self::ClockAhead,
            Self::ClockBack,
            Self::Push,
            Self::Corrupt,
            Self::StopHost,
            Self::StopPin,
        ]
    };

    /// Name on the command line.
    pub const fn name(self) -> &'static str {
        use BusDirection::{ToMaster, ToServos};
        use DamageKind::{CutOff, Doubled, Flipped, Late, Lost};
        match self {
            Self::Bytes(ToServos, Lost) => "lost-to-servos",
            Self::Bytes(ToServos, Late) => "late-to-servos",
            Self::Bytes(ToServos, Doubled) => "doubled-to-servos",
            Self::Bytes(ToServos, Flipped) => "flipped-to-servos",
            Self::Bytes(ToServos, CutOff) => "cut-to-servos",
            Self::Bytes(ToMaster, Lost) => "lost-to-master",
            Self::Bytes(ToMaster, Late) => "late-to-master",
            Self::Bytes(ToMaster, Doubled) => "doubled-to-master",
            Self::Bytes(ToMaster, Flipped) => "flipped-to-master",
            Self::Bytes(ToMaster, CutOff) => "cut-to-master",
            Self::EchoOn => "echo-on",
            Self::EchoOff => "echo-off",
            Self::LineLow => "line-low",
            Self::LineHigh => "line-high",
            Self::ServoReset => "servo-reset",
            Self::ServoMute => "servo-mute",
            Self::ServoDeaf => "servo-deaf",
            Self::ServosSwapped => "servos-swapped",
            Self::Frozen => "frozen",
            Self::DeadZone => "dead-zone",
            Self::Hot => "hot",
            Self::HostVanish => "host-vanish",
            Self::HostFlood => "host-flood",
            Self::HostGarbage => "host-garbage",
            Self::HostSchema => "host-schema",
            Self::HostReplay => "host-replay",
            Self::HostRange => "host-range",
            Self::Goodbye => "goodbye",
            Self::ClockAhead => "clock-ahead",
            Self::ClockBack => "clock-back",
            Self::Push => "push",
            Self::Corrupt => "corrupt",
            Self::StopHost => "stop-host",
            Self::StopPin => "stop-pin",
        }
    }
}

impl fmt::Display for Kind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

impl Serialize for Kind {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(self.name())
    }
}

/// There is no kind of this name.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("there is no fault `{0}`; there are: {all}", all = Kind::ALL.map(Kind::name).join(", "))]
pub struct UnknownKind(String);

impl FromStr for Kind {
    type Err = UnknownKind;

    fn from_str(text: &str) -> Result<Self, UnknownKind> {
        let mut all = Self::ALL.into_iter();
        all.find(|kind| kind.name() == text)
            .ok_or_else(|| UnknownKind(text.to_owned()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_name_is_its_own() {
        for kind in Kind::ALL {
            assert_eq!(kind.name().parse(), Ok(kind));
        }
        assert!("host".parse::<Kind>().is_err());
    }
}
