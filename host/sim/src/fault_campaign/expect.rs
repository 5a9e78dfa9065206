//! Expected faults of each injection: one table, with the reasons.
//!
//! A fault is right if a person who observes the arm would agree with it. Where an
//! injection has no effect, or one that the loop is designed to tolerate, no fault is right
//! too; [`fault_expectation`] decides whether one is required.

use Fault::{
    AngleLimit, Clock, Corrupted, DeadZone, Diverged, EmergencyStop, EncoderFrozen, ExternalTorque,
    HostSilent, Overrun, PwmLimit, SamplesLost, SamplesRare, ServoAlarm, ServoReset, ServoSilent,
    SpeedLimit, Temperature, TorqueLimit, TorqueRate,
};
use armbridge_shared::link::message::{Fault, StopSource};
use armbridge_shared::servo::Firmware;

use super::case::{Case, Injection, Scenario};
use super::kind::{DamageKind, Kind};
use crate::half_duplex_bus::BusDirection;

/// From a fault to motors off, where the bus carries packets, in µs.
pub const STOP_US: u64 = 20_000;

/// A row of the table.
#[derive(Clone, Copy, Debug)]
pub(super) struct Expected {
    /// Kinds of the row.
    matches_kind: fn(Kind) -> bool,
    /// Permitted faults, if there is one.
    pub(super) faults: &'static [Fault],
    /// Why these.
    pub(super) reason: &'static str,
}

/// `kinds => [faults] "reason";` of each row.
macro_rules! rows {
    ($($kinds:pat => [$($fault:expr),*] $reason:literal;)*) => {
        [$(Expected {
            matches_kind: |kind| matches!(kind, $kinds),
            faults: &[$($fault),*],
            reason: $reason,
        }),*]
    };
}

/// Permitted faults of each kind, in one row each. A row holds for both firmwares unless
/// [`STOCK`] has another.
const TABLE: [Expected; 19] = rows! {
    Kind::Bytes(BusDirection::ToServos, _) => [SamplesLost, SamplesRare, ServoSilent, Diverged]
        "a servo does not answer a damaged request; if only a PWM value is lost, the arm \
         departs from the model";
    Kind::Bytes(BusDirection::ToMaster, _) => [SamplesLost, SamplesRare, ServoSilent]
        "replies are damaged or lost";
    Kind::EchoOn | Kind::EchoOff => [SamplesLost, SamplesRare, ServoSilent]
        "the master either separates its echo from the replies or loses samples";
    Kind::LineLow | Kind::LineHigh => [SamplesLost, ServoSilent]
        "no servo replies; a stuck line and servos without power look alike";
    Kind::ServoReset => [ServoReset]
        "it answers a ping, and has lost its place in the cyclic order";
    Kind::ServoMute | Kind::ServoDeaf => [ServoSilent]
        "it does not reply; its silence does not show whether it receives";
    Kind::ServosSwapped => [Diverged, SpeedLimit, AngleLimit]
        "both angles jump, and the loop drives the wrong joints; while angles and torques \
         are alike there is no effect";
    Kind::Frozen => [EncoderFrozen]
        "its noise is missing";
    Kind::DeadZone => [DeadZone]
        "counts near the ends of the track";
    Kind::Hot => [Temperature]
        "it drifts beyond its limit";
    Kind::HostVanish | Kind::HostSchema | Kind::HostReplay => [HostSilent]
        "frames that are not new and valid count as silence; a pause is tolerated, and so are \
         replayed frames beside the host's own. A replay that includes the hello is a host \
         to the board: nothing in the frames distinguishes the two";
    Kind::HostFlood => [EmergencyStop(StopSource::Flood)]
        "garbage outweighs the frames";
    Kind::HostGarbage | Kind::HostRange | Kind::Goodbye => []
        "enough frames arrive; numbers out of range are refused; a goodbye disarms";
    Kind::ClockAhead => [Overrun]
        "ticks are missing; a short gap is tolerated";
    Kind::ClockBack => [Clock]
        "no interval between two events is valid";
    Kind::Push => [SpeedLimit, AngleLimit, Diverged, TorqueLimit, TorqueRate, PwmLimit, ExternalTorque]
        "the loop counters a push with torque up to the limits; a stronger one moves the arm, \
         or overcomes the friction that held it";
    Kind::Corrupt => [Corrupted]
        "the parameters in force are not those that were set";
    Kind::StopHost => [EmergencyStop(StopSource::Host)]
        "the host requested it";
    Kind::StopPin => [EmergencyStop(StopSource::Pin)]
        "the switch is pressed";
};

/// Rows that differ with stock servos.
const STOCK: [Expected; 2] = rows! {
    Kind::ServoReset => [ServoReset]
        "it answers as before, but its torque is no longer enabled";
    Kind::Hot => [Temperature, ServoAlarm]
        "at the servo's own limit, which is the board's too, it switches off and sets its \
         alarm in every reply";
};

/// The row of a kind with these servos.
pub(super) fn expected(kind: Kind, servos: Firmware) -> &'static Expected {
    let stock: &[Expected] = match servos {
        Firmware::Morpheus => &[],
        Firmware::Stock => &STOCK,
    };
    let [first, ..] = &TABLE;
    let mut rows = stock.iter().chain(&TABLE);
    let row = rows.find(|row| (row.matches_kind)(kind));
    // Every kind has a row, as a test shows.
    row.unwrap_or(first)
}

/// Whether a case requires a fault.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum FaultExpectation {
    /// There must be a fault.
    Required,
    /// There may be a fault.
    Allowed,
    /// There must be no fault.
    Forbidden,
}

/// Outage that is tolerated: half the time for which samples may be missing by default.
const TOLERATED_US: u64 = 10_000;
/// Outage that must be detected: three times that time.
const DETECTED_US: u64 = 60_000;
/// Silence of the host that is a fault, and the part of it that may have passed before
/// the host vanished.
const SILENCE_US: u64 = 500_000;
const HEARTBEAT_US: u64 = 25_000;
/// Share of damaged bytes that leaves no packet whole.
const ALL: f64 = 0.94;
/// Amount of a replay that replaces all other frames.
const REPLAY_ALONE: f64 = 0.5;

/// Whether this case requires a fault. A board that is not armed may detect one, but
/// need not.
pub(super) fn fault_expectation(injection: &Injection, case: &Case) -> FaultExpectation {
    use FaultExpectation::{Allowed, Forbidden, Required};
    let Injection {
        kind,
        lasts_us,
        amount,
        ..
    } = *injection;
    let is_armed = case.scenario != Scenario::Idle;
    let required_if_armed = if is_armed { Required } else { Allowed };
    let lasting = |tolerated_us, detected_us| match lasts_us {
        _ if lasts_us < tolerated_us => Forbidden,
        _ if lasts_us > detected_us => required_if_armed,
        _ => Allowed,
    };
    match kind {
        Kind::Bytes(_, damage) if damage == DamageKind::Late || amount < ALL => Allowed,
        Kind::Bytes(..) | Kind::LineLow | Kind::LineHigh | Kind::ServoMute | Kind::ServoDeaf => {
            lasting(TOLERATED_US, DETECTED_US)
        }
        Kind::HostVanish | Kind::HostSchema | Kind::HostReplay | Kind::Push if !is_armed => {
            Forbidden
        }
        Kind::HostReplay if amount < REPLAY_ALONE => Forbidden,
        Kind::HostVanish | Kind::HostSchema => {
            lasting(SILENCE_US - HEARTBEAT_US, SILENCE_US + HEARTBEAT_US)
        }
        Kind::HostReplay
        | Kind::EchoOn
        | Kind::EchoOff
        | Kind::ServosSwapped
        | Kind::ClockAhead
        | Kind::Push => Allowed,
        Kind::HostGarbage | Kind::HostRange | Kind::Goodbye => Forbidden,
        Kind::ServoReset
        | Kind::Frozen
        | Kind::DeadZone
        | Kind::Hot
        | Kind::HostFlood
        | Kind::ClockBack
        | Kind::Corrupt => required_if_armed,
        Kind::StopHost | Kind::StopPin => Required,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_kind_has_one_row() {
        for kind in Kind::ALL {
            let rows = TABLE.iter().filter(|row| (row.matches_kind)(kind));
            assert_eq!(rows.count(), 1, "{kind}");
        }
    }
}
