//! Whether a case requires, allows or forbids a fault.

use super::activity::Activity;
use super::case::Case;
use super::expect::parks;
use super::injection::{Injection, Origin};
use super::kind::{DamageKind, Kind};
use crate::half_duplex_bus::BusDirection;

/// Whether a case requires a fault.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum FaultExpectation {
    /// There must be a fault, or an expected refusal.
    Required,
    /// There may be a fault.
    Allowed,
    /// There must be no fault.
    Forbidden,
}

/// Silence of the host that is a fault, and the part of it that may have passed before
/// the host vanished.
const SILENCE_US: u64 = 500_000;
const HEARTBEAT_US: u64 = 25_000;
/// Share of damaged bytes that leaves no packet whole.
const ALL: f64 = 0.94;
/// Amount of a replay that replaces all other frames.
const REPLAY_ALONE: f64 = 0.5;
/// Time in µs after arming within which the motors are checked, at the longest period of that.
const CHECKED_US: u64 = 1_000_000;
/// Step of an encoder, in counts of an AX-12A, that no motion explains: twice the innovation's limit.
const STEP_COUNTS: f64 = 40.0;
/// Noise of an encoder, in counts, whose equal samples are never credible for long.
const RUN_NOISE_COUNTS: f64 = 0.8;
/// Drift of an encoder, in counts of an AX-12A, that takes the arm as far as it may be: 0.5 rad.
const DRIFT_COUNTS: f64 = 98.0;

/// Whether this injection requires a fault. A board that is not armed may detect one, but
/// need not.
pub(super) fn fault_expectation(injection: &Injection, case: &Case) -> FaultExpectation {
    use FaultExpectation::{Allowed, Forbidden, Required};
    let later = when_ready(injection, case);
    // A fault of the time before arming may be over.
    match (injection.origin, later) {
        (Origin::PowerUp, Required) if !lasts(injection.kind) => Allowed,
        // No fault of that time is forbidden, but without any effect on servos it is.
        (Origin::PowerUp, Forbidden) if injection.kind == Kind::Frozen => Allowed,
        (_, Forbidden) if case.activity.is_armed() && may_prevent_drive(injection) => Allowed,
        // An obstacle may be in the way of an arm that is parked.
        (_, Forbidden) if parks(injection.kind) && case.has_obstructed_pose() => Allowed,
        _ => later,
    }
}

/// Whether the fault may keep an arm whose motors were checked from being driven, so that it
/// falls to its angle limit.
fn may_prevent_drive(injection: &Injection) -> bool {
    let is_of_commands = matches!(
        injection.kind,
        Kind::HostRange | Kind::HostHeartbeats | Kind::HostReplay
    );
    is_of_commands && (injection.origin == Origin::PowerUp || injection.after_us < CHECKED_US)
}

/// Whether ticks come at 1 kHz, at 1 Mbaud.
fn is_fast(case: &Case) -> bool {
    case.set_up.period_us == 1_000 && case.bus.baud == 1_000_000
}

/// Whether a fault from before arming is required to be found after it.
fn lasts(kind: Kind) -> bool {
    matches!(
        kind,
        Kind::SwappedFirst
            | Kind::DeadZone
            | Kind::TorqueSign
            | Kind::FlashRot
            | Kind::StopHost
            | Kind::StopPin
    )
}

/// The same for a fault that comes while the board does what it shall.
fn when_ready(injection: &Injection, case: &Case) -> FaultExpectation {
    use FaultExpectation::{Allowed, Forbidden, Required};
    let Injection {
        kind,
        lasts_us,
        amount,
        ..
    } = *injection;
    let is_armed = case.activity.is_armed();
    let is_closed = case.activity.is_closed();
    let is_balanced = case.activity.is_balanced();
    let required_if = |condition| if condition { Required } else { Allowed };
    let lasting = |tolerated_us, detected_us| match lasts_us {
        _ if lasts_us < tolerated_us => Forbidden,
        _ if lasts_us > detected_us => required_if(is_armed),
        _ => Allowed,
    };
    // Half the time for which samples may be missing, and three times that time.
    let lost_us = case.lost_us();
    match kind {
        Kind::Bytes(_, damage) if damage == DamageKind::Late || amount < ALL => Allowed,
        // A servo that takes a damaged packet for a long one waits for the rest of it, which
        // takes several ticks unless they are short.
        Kind::Bytes(BusDirection::ToServos, _)
        | Kind::LineLow
        | Kind::LineHigh
        | Kind::ServoDeaf
            if case.lost_us() > lasts_us && !is_fast(case) =>
        {
            Allowed
        }
        Kind::Bytes(..) | Kind::LineLow | Kind::LineHigh | Kind::ServoMute | Kind::ServoDeaf => {
            lasting(lost_us / 2, 3 * lost_us)
        }
        Kind::HostVanish | Kind::HostStall | Kind::HostSchema | Kind::HostReplay | Kind::Push
            if !is_armed =>
        {
            Forbidden
        }
        Kind::HostReplay if amount < REPLAY_ALONE => Forbidden,
        Kind::HostVanish | Kind::HostStall | Kind::HostSchema => {
            match lasting(SILENCE_US - HEARTBEAT_US, SILENCE_US + HEARTBEAT_US) {
                // The host may be back when the arm has been parked.
                Required if case.pose.is_some() => Allowed,
                expectation => expectation,
            }
        }
        Kind::EncoderStep => required_if(is_closed && case.ax12a_counts(amount.abs()) > STEP_COUNTS),
        Kind::EncoderDrift => {
            let drift_counts = amount.abs() * case.observation_us() as f64 * 1e-6;
            required_if(is_closed && case.ax12a_counts(drift_counts) > DRIFT_COUNTS)
        }
        Kind::TorqueSign | Kind::SwappedFirst => required_if(is_balanced),
        // Where no controller or float holds the joint only the missing noise shows.
        Kind::Frozen => {
            required_if(is_balanced || (is_armed && case.noise_counts > RUN_NOISE_COUNTS))
        }
        Kind::HostReplay
        | Kind::EchoOn
        | Kind::EchoOff
        | Kind::ServosSwapped
        | Kind::SecondMaster
        | Kind::DuplicateId
        | Kind::EncoderNoise
        | Kind::TorqueGain
        | Kind::TorqueOffset
        | Kind::CalibrationScale
        | Kind::CalibrationZero
        | Kind::CalibrationDirection
        | Kind::ClockAhead
        | Kind::Push => Allowed,
        Kind::HostGarbage
        | Kind::HostRange
        | Kind::HostHeartbeats
        | Kind::HostHello
        | Kind::ClientHang
        | Kind::ClientBaud
        | Kind::BrownOut
        | Kind::Goodbye => Forbidden,
        // Heat is detected against the first reading, which takes some ticks.
        Kind::Hot if injection.after_us < case.poll_us() => Allowed,
        // Within a tick the clock may go back unseen.
        Kind::ClockBack if amount * 1e3 < f64::from(case.set_up.period_us) => Allowed,
        Kind::ServoReset
        | Kind::ServosReset
        | Kind::DeadZone
        | Kind::Hot
        // A refusal to arm; the oracle knows whether the settings are lost.
        | Kind::FlashRot
        | Kind::HostFlood
        | Kind::ClockBack
        | Kind::Corrupt => required_if(is_armed),
        // A command that the host repeats may replace it before a tick compares it.
        Kind::CorruptDrive => {
            let is_repeated = matches!(case.activity, Activity::Stream | Activity::Torque);
            required_if(is_armed && !is_repeated)
        }
        // Only a reference in use is compared.
        Kind::CorruptReference => required_if(is_closed || case.activity == Activity::Armed),
        Kind::CorruptState | Kind::StopHost | Kind::StopPin | Kind::ClientStop => Required,
    }
}
