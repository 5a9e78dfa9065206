//! Path of the campaign's streams: from where the arm is to a target and back, again and again,
//! from rest. A board refuses a stream that it cannot join from there.

use armbridge_link::message::{Drive, Record};
use armbridge_servo::JOINTS;

/// Frequency in Hz.
const STREAM_HZ: f64 = 0.5;
/// Time in µs after which a stream that is not followed begins again where the arm is.
const AGAIN_US: u64 = 500_000;

/// See the [module](self).
#[derive(Clone, Copy, Debug)]
pub(super) struct StreamPath {
    /// Time of its first point, on the board's clock.
    since_us: u64,
    from_rad: [f32; JOINTS],
}

/// Whether the board follows a stream in this tick.
pub(super) fn is_followed(record: &Record) -> bool {
    record.mode.drive() == Some(Drive::Track)
}

impl StreamPath {
    /// The path for a point at this time: the present one, or another from where the arm is.
    pub(super) fn next(present: Option<Self>, at_us: u64, record: &Record) -> Self {
        let goes_on = |path: &Self| is_followed(record) || at_us <= path.since_us + AGAIN_US;
        present.filter(goes_on).unwrap_or(Self {
            since_us: at_us,
            from_rad: record.output.angle_rad,
        })
    }

    /// Its angles at this time.
    pub(super) fn angle_rad(&self, to_rad: [f32; JOINTS], at_us: u64) -> [f32; JOINTS] {
        let elapsed_s = at_us.saturating_sub(self.since_us) as f64 * 1e-6;
        let phase = std::f64::consts::TAU * STREAM_HZ * elapsed_s;
        let share = (0.5 - 0.5 * phase.cos()) as f32;
        std::array::from_fn(|joint| {
            let from_rad = self.from_rad[joint];
            from_rad + share * (to_rad[joint] - from_rad)
        })
    }
}
