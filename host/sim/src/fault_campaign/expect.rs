//! Expected faults of each injection: one table, with the reasons.
//!
//! A fault is right if a person who observes the arm would agree with it. Where an
//! injection has no effect, or one that the loop is designed to tolerate, no fault is right
//! too; [`requirement`](super::requirement) decides whether one is required. A board that
//! refuses to arm, for a reason that [`is_refusal_expected`] has, has detected the fault.

use Fault::{
    AngleLimit, Clock, Corrupted, DeadZone, Diverged, EmergencyStop, EncoderFrozen, ExternalTorque,
    HostSilent, JointsSwapped, MotorDirection, Overrun, PwmLimit, SamplesLost, SamplesRare,
    ServoAlarm, ServoReset, ServoSilent, SpeedLimit, Stuck, Temperature, TorqueLimit, TorqueRate,
};
use armbridge_board::tick::limits::CHECK_PERIOD_MAX_US;
use armbridge_link::message::{Fault, Refusal, StopSource};
use armbridge_servo::Firmware;

use super::case::Case;
use super::injection::{Injection, Origin};
use super::kind::Kind;
use crate::half_duplex_bus::BusDirection;

/// From a fault to motors off, where the bus carries packets, in µs: at 1 Mbaud and a
/// period of 1 ms. [`Case::stop_us`](super::Case::stop_us) has the others.
pub const STOP_US: u64 = 20_000;

/// Kinds that boards do not detect yet, or not always: their wrong names and the harm that
/// they do are counted apart. A guard takes its kind off this list.
const UNGUARDED: [Kind; 7] = [
    Kind::SecondMaster,
    Kind::EncoderStep,
    Kind::EncoderDrift,
    Kind::TorqueOffset,
    Kind::CalibrationScale,
    Kind::CalibrationZero,
    Kind::CalibrationDirection,
];

/// Longest period in µs at which an encoder that stops is detected before the arm is far from its
/// reference. At 45 ms it is detected before the arm is at the table.
const FROZEN_PERIOD_US: u32 = 10_000;

/// Largest noise in counts with which the check of the motors does not end in a fault of its own. It
/// ends where a joint has moved by 0.06 rad; five counts of these are its pulses, and the rest is
/// four times this noise.
const CHECKED_NOISE_COUNTS: f64 = 1.6;
/// The same at periods of [`SPARSE_PERIOD_US`] and more, where it has a hundred samples: the ratio
/// of two responses then has a standard error of 0.15 at this noise, and the ratios of right and
/// swapped servos, with what friction takes, are 0.3 apart.
const SPARSE_NOISE_COUNTS: f64 = 1.1;
const SPARSE_PERIOD_US: u32 = 5_000;
/// Period in µs from which on the check lasts for 0.7 s and more.
const SLOW_CHECK_PERIOD_US: u32 = 10_000;
/// Noise in counts with which a sample may be 0.1 rad from its prediction at 45 ms.
const DIVERGED_NOISE_COUNTS: f64 = 2.1;
/// Longest period in µs at which a motor that turns the wrong way is always called so.
const DIRECTED_PERIOD_US: u32 = 2_000;

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
const TABLE: [Expected; 38] = rows! {
    Kind::Bytes(BusDirection::ToServos, _) => [SamplesLost, SamplesRare, ServoSilent, Diverged]
        "a servo does not answer a damaged request; if only a PWM value is lost, the arm \
         departs from the model";
    Kind::Bytes(BusDirection::ToMaster, _) => [SamplesLost, SamplesRare, ServoSilent]
        "replies are damaged or lost";
    Kind::EchoOn | Kind::EchoOff => [SamplesLost, SamplesRare, ServoSilent]
        "the master either separates its echo from the replies or loses samples";
    Kind::LineLow | Kind::LineHigh => [SamplesLost, ServoSilent]
        "no servo replies; a stuck line and servos without power look alike";
    Kind::SecondMaster => [SamplesLost, SamplesRare, ServoSilent, ServoReset, ServoAlarm, Diverged,
                           SpeedLimit, AngleLimit]
        "its packets collide with the board's, or drive a motor until the next tick";
    Kind::DuplicateId => [SamplesLost, SamplesRare, ServoSilent, ServoReset, ServoAlarm, Diverged,
                          SpeedLimit, AngleLimit, DeadZone, ExternalTorque]
        "two servos answer at once: their bytes collide, or either of them is heard, and the \
         other moves the joint";
    Kind::ServoReset | Kind::ServosReset => [ServoReset, ServoSilent]
        "it answers a ping, and has lost its place in the cyclic order; it is silent while it \
         boots";
    Kind::ServoMute | Kind::ServoDeaf => [ServoSilent]
        "it does not reply; its silence does not show whether it receives";
    Kind::SwappedFirst => [JointsSwapped, ExternalTorque, Diverged, SpeedLimit, AngleLimit,
                           TorqueLimit, Stuck]
        "the check of the motors at the first arming finds that the wrong joint moves";
    Kind::ServosSwapped => [JointsSwapped, ExternalTorque, Diverged, SpeedLimit, AngleLimit]
        "both angles jump, and the loop drives the wrong joints; while angles and torques \
         are alike there is no effect";
    Kind::Frozen => [EncoderFrozen, Stuck]
        "its noise is missing, or a small motion does not show; under a large torque a joint \
         that is stuck looks the same";
    Kind::DeadZone => [DeadZone, AngleLimit]
        "counts near the ends of the track, which are angles beyond the limit";
    Kind::EncoderStep => [ExternalTorque, Diverged, SpeedLimit, AngleLimit, DeadZone]
        "the estimator predicts no step; one that it takes for motion is a disturbance";
    Kind::EncoderDrift => [ExternalTorque, Diverged, SpeedLimit, AngleLimit, DeadZone, Stuck]
        "the arm follows the reading until the torque that holds it is not what the model \
         expects";
    Kind::EncoderNoise => [Diverged, SpeedLimit, AngleLimit, TorqueLimit, TorqueRate, PwmLimit,
                           DeadZone, SamplesRare, SamplesLost, ExternalTorque, MotorDirection,
                           JointsSwapped]
        "samples are far from the prediction, or the torque is noisy; to the check of the motors \
         they are motion that no torque explains";
    Kind::TorqueGain | Kind::TorqueOffset => [ExternalTorque, JointsSwapped, Diverged, SpeedLimit,
                                              AngleLimit, Stuck, TorqueLimit]
        "a torque that the model does not explain; the loop tolerates a small one, and motors \
         of which one is much weaker look swapped to the check";
    Kind::TorqueSign => [MotorDirection, ExternalTorque, Diverged, SpeedLimit, AngleLimit, Stuck,
                         TorqueLimit, TorqueRate, PwmLimit]
        "the motor turns the wrong way, which the check of the motors finds, or the loop runs \
         away";
    Kind::CalibrationScale => [ExternalTorque, Diverged, SpeedLimit, AngleLimit, Stuck,
                               TorqueLimit, TorqueRate, PwmLimit]
        "angles and torques do not belong together";
    Kind::CalibrationZero => [ExternalTorque, Diverged, AngleLimit, SpeedLimit, Stuck]
        "gravity pulls where the model has none";
    Kind::CalibrationDirection => [ExternalTorque, Diverged, SpeedLimit, AngleLimit, Stuck]
        "encoder and motor are reversed alike, a mirror image that stands as well; only the \
         joints' coupling shows it";
    Kind::FlashRot => []
        "arming is refused until the loss of the settings is confirmed";
    Kind::Hot => [Temperature]
        "it drifts beyond its limit";
    Kind::HostReplay => [HostSilent, AngleLimit]
        "replayed frames beside the host's own count for nothing. A replay that includes the \
         hello is a host to the board: nothing in the frames distinguishes the two; an arm that \
         it disarms, or keeps from being driven, falls";
    Kind::HostVanish | Kind::HostStall | Kind::HostSchema => [HostSilent]
        "frames that are not new and valid count as silence; a pause is tolerated";
    Kind::HostFlood => [EmergencyStop(StopSource::Flood)]
        "garbage outweighs the frames";
    Kind::HostGarbage | Kind::HostRange | Kind::Goodbye => [AngleLimit]
        "enough frames arrive; numbers out of range are refused, and an arm whose motors were \
         checked falls if nothing drives it then; a goodbye disarms";
    Kind::HostHeartbeats => [AngleLimit]
        "a command that is too old ends without a fault; an arm whose motors were checked falls \
         if nothing drives it then";
    Kind::HostHello => []
        "a hello disarms";
    Kind::ClientHang | Kind::ClientBaud => []
        "a client that is silent loses the bus, and one that comes later is refused";
    Kind::BrownOut => []
        "a board that restarts stops the motors, searches the servos and is idle";
    Kind::ClientStop => [EmergencyStop(StopSource::Pin), EmergencyStop(StopSource::Host)]
        "the switch is pressed, or the host requested it";
    Kind::ClockAhead => [Overrun]
        "ticks are missing; a short gap is tolerated";
    Kind::ClockBack => [Clock]
        "no interval between two events is valid";
    Kind::Push => [ExternalTorque, SpeedLimit, AngleLimit, Diverged, TorqueLimit, TorqueRate,
                   PwmLimit, Stuck]
        "the loop counters a push with torque up to the limits; a stronger one moves the arm, \
         or overcomes the friction that held it; one that balances the motor is an obstacle";
    Kind::Corrupt => [Corrupted]
        "the parameters in force are not those that were set";
    Kind::CorruptState | Kind::CorruptDrive | Kind::CorruptReference => [Corrupted]
        "state, drive command and reference are not those that were stored";
    Kind::StopHost => [EmergencyStop(StopSource::Host)]
        "the host requested it";
    Kind::StopPin => [EmergencyStop(StopSource::Pin)]
        "the switch is pressed";
};

/// Rows that differ with stock servos.
const STOCK: [Expected; 2] = rows! {
    Kind::ServoReset | Kind::ServosReset => [ServoReset, ServoSilent]
        "it answers as before, but its torque is no longer enabled";
    Kind::Hot => [Temperature, ServoAlarm]
        "at the servo's own limit, which is the board's too, it switches off and sets its \
         alarm in every reply";
};

/// Rows that differ with X servos.
const X: [Expected; 2] = rows! {
    Kind::ServoReset | Kind::ServosReset => [ServoReset, ServoSilent]
        "it answers as before, but its watchdog, which is volatile, is not set any more";
    Kind::Hot => [Temperature, ServoAlarm]
        "at the servo's own limit it switches off and sets its alert in every reply";
};

/// The row of a kind with these servos.
pub(super) fn expected(kind: Kind, servos: Firmware) -> &'static Expected {
    let own: &[Expected] = match servos {
        Firmware::Morpheus => &[],
        Firmware::Stock => &STOCK,
        Firmware::XSeries => &X,
    };
    let [first, ..] = &TABLE;
    let mut rows = own.iter().chain(&TABLE);
    let row = rows.find(|row| (row.matches_kind)(kind));
    // Every kind has a row, as a test shows.
    row.unwrap_or(first)
}

/// Whether this fault is a right name for the kind in this case.
pub(super) fn is_fault_expected(kind: Kind, fault: Fault, case: &Case) -> bool {
    // The motor check finds nothing else about a motor that turns the wrong way.
    if kind == Kind::TorqueSign && case.set_up.period_us <= DIRECTED_PERIOD_US {
        return fault == MotorDirection;
    }
    // While no sample arrives, an obstacle may keep the arm from where it is predicted.
    let is_held = case.is_obstructed && matches!(kind, Kind::LineLow | Kind::LineHigh);
    let is_listed = expected(kind, case.servos()).faults.contains(&fault);
    // So it may where the arm is parked.
    let is_parked = case.has_obstructed_pose() && parks(kind);
    is_listed
        || (is_held && fault == Diverged)
        || (is_parked && matches!(fault, Stuck | ExternalTorque))
}

/// Whether an arm that has a pose is parked after this.
pub(super) fn parks(kind: Kind) -> bool {
    matches!(
        kind,
        Kind::HostVanish
            | Kind::HostStall
            | Kind::HostSchema
            | Kind::HostReplay
            | Kind::HostRange
            | Kind::HostHeartbeats
            | Kind::HostHello
            | Kind::Goodbye
            | Kind::Hot
    )
}

/// Whether a board may have this fault for the noise alone, in the check of the motors or later. To
/// the check loud noise is motion; and an arm without friction keeps the speed that a slow check
/// has left it.
pub(super) fn is_noise_fault(fault: Fault, is_in_check: bool, case: &Case) -> bool {
    let (noise, period_us) = (case.noise_counts, case.set_up.period_us);
    let is_sparse = period_us >= SPARSE_PERIOD_US;
    match fault {
        Diverged => noise > DIVERGED_NOISE_COUNTS && period_us > CHECK_PERIOD_MAX_US,
        ExternalTorque | MotorDirection | JointsSwapped if !is_in_check => false,
        ExternalTorque | MotorDirection if noise > CHECKED_NOISE_COUNTS => true,
        ExternalTorque => period_us >= SLOW_CHECK_PERIOD_US && !case.friction,
        JointsSwapped => noise > CHECKED_NOISE_COUNTS || (is_sparse && noise > SPARSE_NOISE_COUNTS),
        _ => false,
    }
}

/// Whether boards detect this injection, and before it does harm. With an encoder that has stopped
/// before the motors are checked, that joint may fall meanwhile, for 1.5 s at 10 ms. At long periods motors are not checked.
pub(super) fn is_guarded(injection: &Injection, case: &Case) -> bool {
    let period_us = case.set_up.period_us;
    match injection.kind {
        Kind::Frozen => injection.origin == Origin::Ready && period_us <= FROZEN_PERIOD_US,
        Kind::SwappedFirst | Kind::TorqueSign => period_us <= CHECK_PERIOD_MAX_US,
        kind => !UNGUARDED.contains(&kind),
    }
}

/// Whether this refusal to configure or arm names the fault.
pub(super) fn is_refusal_expected(kind: Kind, refusal: Refusal) -> bool {
    match kind {
        Kind::CalibrationScale => matches!(refusal, Refusal::OutOfRange),
        Kind::FlashRot => matches!(refusal, Refusal::SettingsLost),
        Kind::DuplicateId => {
            matches!(refusal, Refusal::NotReady | Refusal::EncoderUnknown { .. })
        }
        // It stopped before its noise was known.
        Kind::Frozen => matches!(refusal, Refusal::EncoderUnknown { .. }),
        Kind::DeadZone => matches!(refusal, Refusal::BeyondLimit { .. }),
        _ => false,
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
