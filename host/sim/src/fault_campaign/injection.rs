//! An injected fault of a case: its time and magnitude.

use armbridge_servo::JOINTS;
use serde::Serialize;

use super::draw::Random;
use super::kind::{DamageKind, Kind};

/// Duration of faults that last until they are removed.
const UNTIL_REMOVED_US: u64 = u64::MAX / 4;

/// Origin of an injection's time.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Origin {
    /// Power-up of board and servos: bring-up takes 20 ms at 1 Mbaud.
    PowerUp,
    /// The start of the activity.
    Ready,
}

/// One fault, with its time and magnitude.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Injection {
    /// Kind of fault.
    pub kind: Kind,
    /// Origin of its time.
    pub origin: Origin,
    /// Time after that, in µs.
    pub after_us: u64,
    /// Duration, in µs.
    pub lasts_us: u64,
    /// Servo or joint, for kinds that affect one.
    pub servo: usize,
    /// Magnitude: share of bytes, N m, counts, counts a second, factor, ms.
    pub amount: f64,
    /// Delay of late bytes, in µs.
    pub late_us: u64,
    /// Seed of its random numbers.
    pub seed: u64,
}

/// Draws duration and amount of a fault.
pub(super) fn draw_injection(
    kind: Kind,
    origin: Origin,
    after_us: u64,
    draw: &mut Random,
) -> Injection {
    let (lasts_us, amount) = draw_size(kind, draw);
    let late_us = match kind {
        Kind::Bytes(_, DamageKind::Late) => draw.log_uniform_us(0.02, 2.0),
        _ => 0,
    };
    Injection {
        kind,
        origin,
        after_us,
        lasts_us,
        servo: draw.below(JOINTS as u64) as usize,
        amount,
        late_us,
        seed: draw.below(1 << 32),
    }
}

/// Duration in µs, and magnitude.
fn draw_size(kind: Kind, draw: &mut Random) -> (u64, f64) {
    match kind {
        Kind::Bytes(..) => match draw.below(3) {
            // Rarely, without end.
            0 => (UNTIL_REMOVED_US, draw.log_uniform(1e-4, 5e-3)),
            // Often, for a while.
            1 => (draw.log_uniform_us(5.0, 800.0), draw.log_uniform(0.02, 0.9)),
            // All or nearly all.
            _ => (draw.log_uniform_us(1.0, 800.0), draw.uniform(0.95, 1.0)),
        },
        Kind::EchoOn | Kind::EchoOff => (draw.log_uniform_us(1.0, 1_000.0), 0.0),
        Kind::LineLow | Kind::LineHigh | Kind::ServoMute | Kind::ServoDeaf => {
            (draw.log_uniform_us(0.05, 800.0), 0.0)
        }
        // Time between two packets in ms.
        Kind::SecondMaster => {
            let between_ms = draw.log_uniform(1.0, 100.0);
            (draw.log_uniform_us(5.0, 1_000.0), between_ms)
        }
        Kind::Hot => (UNTIL_REMOVED_US, draw.uniform(300.0, 1_000.0)),
        Kind::HostVanish => {
            let is_short = draw.coin();
            let short_us = draw.log_uniform_us(30.0, 450.0);
            (if is_short { short_us } else { UNTIL_REMOVED_US }, 0.0)
        }
        Kind::HostStall => (draw.log_uniform_us(5.0, 1_000.0), 0.0),
        Kind::HostFlood => (draw.log_uniform_us(20.0, 500.0), 0.0),
        // Beside the host's own frames, or instead of them.
        Kind::HostReplay => (UNTIL_REMOVED_US, draw.below(2) as f64),
        // Number of frames before the hello.
        Kind::HostHello => (0, draw.uniform(0.0, 40.0).floor()),
        Kind::ClockAhead | Kind::ClockBack => (0, draw.log_uniform(1.0, 100.0)),
        Kind::Push => {
            let torque_nm = draw.uniform(0.3, 3.0);
            (draw.log_uniform_us(50.0, 500.0), draw.sign() * torque_nm)
        }
        Kind::EncoderStep => (UNTIL_REMOVED_US, draw.sign() * draw.log_uniform(5.0, 200.0)),
        Kind::EncoderDrift => (UNTIL_REMOVED_US, draw.sign() * draw.log_uniform(5.0, 50.0)),
        Kind::EncoderNoise => (UNTIL_REMOVED_US, draw.log_uniform(2.0, 40.0)),
        Kind::TorqueGain => (UNTIL_REMOVED_US, draw.log_uniform(0.5, 2.0)),
        Kind::TorqueSign => (UNTIL_REMOVED_US, -1.0),
        Kind::TorqueOffset => (UNTIL_REMOVED_US, draw.sign() * draw.uniform(20.0, 300.0)),
        Kind::CalibrationScale => match draw.below(3) {
            // The range that a calibration may get wrong, and none at all.
            0 => (UNTIL_REMOVED_US, draw.log_uniform(1e-4, 0.1)),
            _ => (UNTIL_REMOVED_US, draw.log_uniform(0.3, 3.0)),
        },
        Kind::CalibrationZero => (
            UNTIL_REMOVED_US,
            draw.sign() * draw.log_uniform(10.0, 200.0),
        ),
        // The board is gone for this time, in µs; the servos restart as well, or not.
        Kind::BrownOut => (draw.log_uniform_us(1.0, 30.0), draw.below(2) as f64),
        // By the switch, or by the host.
        Kind::ClientStop => (0, draw.below(2) as f64),
        Kind::ServosSwapped
        | Kind::SwappedFirst
        | Kind::DuplicateId
        | Kind::Frozen
        | Kind::DeadZone
        | Kind::CalibrationDirection
        | Kind::HostGarbage
        | Kind::HostSchema
        | Kind::HostRange
        | Kind::HostHeartbeats => (UNTIL_REMOVED_US, 0.0),
        Kind::ServoReset
        | Kind::ServosReset
        | Kind::Goodbye
        | Kind::ClientHang
        | Kind::ClientBaud
        | Kind::Corrupt
        | Kind::CorruptState
        | Kind::CorruptDrive
        | Kind::CorruptReference
        | Kind::FlashRot
        | Kind::StopHost
        | Kind::StopPin => (0, 0.0),
    }
}
