//! Kinds of injected faults, with one name each.

use std::fmt;
use std::str::FromStr;

use serde::{Deserialize, Deserializer, Serialize, Serializer};

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
    /// A second master sends on the bus: drive packets, queries, garbage.
    SecondMaster,
    /// A third servo answers to the id of one of the arm's.
    DuplicateId,
    /// A servo is power-cycled.
    ServoReset,
    /// Both servos are power-cycled.
    ServosReset,
    /// A servo receives and executes, but does not reply.
    ServoMute,
    /// A servo receives nothing, and keeps its last command.
    ServoDeaf,
    /// The servos are swapped.
    ServosSwapped,
    /// The servos are swapped from the beginning.
    SwappedFirst,
    /// A potentiometer's reading stays at one count.
    Frozen,
    /// A potentiometer's wiper has left its track.
    DeadZone,
    /// A potentiometer's reading is off by a step.
    EncoderStep,
    /// A potentiometer's reading drifts.
    EncoderDrift,
    /// A potentiometer's reading is noisy.
    EncoderNoise,
    /// A motor heats up.
    Hot,
    /// A motor gives half to twice its torque.
    TorqueGain,
    /// A motor turns the other way.
    TorqueSign,
    /// A motor's zero is elsewhere.
    TorqueOffset,
    /// The host sets a wrong angle per count while the board is idle.
    CalibrationScale,
    /// The host sets a wrong zero while the board is idle.
    CalibrationZero,
    /// The host sets a wrong direction while the board is idle.
    CalibrationDirection,
    /// No bytes of the host arrive.
    HostVanish,
    /// Nothing is transferred for a while; then all of it arrives at once.
    HostStall,
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
    /// The host sends heartbeats only.
    HostHeartbeats,
    /// The host sends a burst of frames and a hello in one write.
    HostHello,
    /// The host ends its session with a goodbye.
    Goodbye,
    /// A client of the transparent port drives a motor and hangs.
    ClientHang,
    /// A client of the transparent port drives and changes the servos' rate.
    ClientBaud,
    /// A client of the transparent port is stopped inside a packet.
    ClientStop,
    /// The board's clock jumps forward.
    ClockAhead,
    /// The board's clock goes back.
    ClockBack,
    /// Somebody pushes the arm.
    Push,
    /// A bit of the configuration in memory flips.
    Corrupt,
    /// A bit of the supervisor's state flips.
    CorruptState,
    /// A bit of the drive command flips.
    CorruptDrive,
    /// A bit of the reference's numbers flips.
    CorruptReference,
    /// A byte of the stored settings has a flipped bit at boot.
    FlashRot,
    /// The board restarts, and the servos too where the supply is one.
    BrownOut,
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

/// Number of kinds.
const KINDS: usize = 58;

/// All kinds, with their names on the command line.
const NAMES: [(Kind, &str); KINDS] = {
    use BusDirection::{ToMaster, ToServos};
    use DamageKind::{CutOff, Doubled, Flipped, Late, Lost};
    [
        (Kind::Bytes(ToServos, Lost), "lost-to-servos"),
        (Kind::Bytes(ToServos, Late), "late-to-servos"),
        (Kind::Bytes(ToServos, Doubled), "doubled-to-servos"),
        (Kind::Bytes(ToServos, Flipped), "flipped-to-servos"),
        (Kind::Bytes(ToServos, CutOff), "cut-to-servos"),
        (Kind::Bytes(ToMaster, Lost), "lost-to-master"),
        (Kind::Bytes(ToMaster, Late), "late-to-master"),
        (Kind::Bytes(ToMaster, Doubled), "doubled-to-master"),
        (Kind::Bytes(ToMaster, Flipped), "flipped-to-master"),
        (Kind::Bytes(ToMaster, CutOff), "cut-to-master"),
        (Kind::EchoOn, "echo-on"),
        (Kind::EchoOff, "echo-off"),
        (Kind::LineLow, "line-low"),
        (Kind::LineHigh, "line-high"),
        (Kind::SecondMaster, "second-master"),
        (Kind::DuplicateId, "duplicate-id"),
        (Kind::ServoReset, "servo-reset"),
        (Kind::ServosReset, "servos-reset"),
        (Kind::ServoMute, "servo-mute"),
        (Kind::ServoDeaf, "servo-deaf"),
        (Kind::ServosSwapped, "servos-swapped"),
        (Kind::SwappedFirst, "swapped-first"),
        (Kind::Frozen, "frozen"),
        (Kind::DeadZone, "dead-zone"),
        (Kind::EncoderStep, "encoder-step"),
        (Kind::EncoderDrift, "encoder-drift"),
        (Kind::EncoderNoise, "encoder-noise"),
        (Kind::Hot, "hot"),
        (Kind::TorqueGain, "torque-gain"),
        (Kind::TorqueSign, "torque-sign"),
        (Kind::TorqueOffset, "torque-offset"),
        (Kind::CalibrationScale, "calibration-scale"),
        (Kind::CalibrationZero, "calibration-zero"),
        (Kind::CalibrationDirection, "calibration-sign"),
        (Kind::HostVanish, "host-vanish"),
        (Kind::HostStall, "host-stall"),
        (Kind::HostFlood, "host-flood"),
        (Kind::HostGarbage, "host-garbage"),
        (Kind::HostSchema, "host-schema"),
        (Kind::HostReplay, "host-replay"),
        (Kind::HostRange, "host-range"),
        (Kind::HostHeartbeats, "host-heartbeats"),
        (Kind::HostHello, "host-hello"),
        (Kind::Goodbye, "goodbye"),
        (Kind::ClientHang, "client-hang"),
        (Kind::ClientBaud, "client-baud"),
        (Kind::ClientStop, "client-stop"),
        (Kind::ClockAhead, "clock-ahead"),
        (Kind::ClockBack, "clock-back"),
        (Kind::Push, "push"),
        (Kind::Corrupt, "corrupt"),
        (Kind::CorruptState, "corrupt-state"),
        (Kind::CorruptDrive, "corrupt-drive"),
        (Kind::CorruptReference, "corrupt-reference"),
        (Kind::FlashRot, "flash-rot"),
        (Kind::BrownOut, "brown-out"),
        (Kind::StopHost, "stop-host"),
        (Kind::StopPin, "stop-pin"),
    ]
};

impl Kind {
    /// All kinds.
    pub const ALL: [Self; KINDS] = {
        let mut all = [Self::EchoOn; KINDS];
        let mut index = 0;
        while index < KINDS {
            all[index] = NAMES[index].0;
            index += 1;
        }
        all
    };

    /// Name on the command line.
    pub fn name(self) -> &'static str {
        let name = NAMES.iter().find(|(kind, _)| *kind == self);
        // Every kind has a name, as a test shows.
        name.map_or("", |(_, name)| name)
    }

    /// Whether it is there from the beginning, not from a time on.
    pub(super) fn is_from_start(self) -> bool {
        matches!(
            self,
            Self::SwappedFirst
                | Self::TorqueSign
                | Self::CalibrationScale
                | Self::CalibrationZero
                | Self::CalibrationDirection
                | Self::FlashRot
        )
    }

    /// Whether it keeps the host's bytes from the board.
    pub(super) fn is_of_link(self) -> bool {
        matches!(
            self,
            Self::HostVanish
                | Self::HostStall
                | Self::HostFlood
                | Self::HostSchema
                | Self::HostReplay
        )
    }

    /// Whether a client of the transparent port is part of it.
    pub(super) fn has_client(self) -> bool {
        matches!(self, Self::ClientHang | Self::ClientBaud | Self::ClientStop)
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

impl<'de> Deserialize<'de> for Kind {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let name = String::deserialize(deserializer)?;
        name.parse().map_err(serde::de::Error::custom)
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
