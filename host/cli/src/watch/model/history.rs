//! The last ten seconds of angles and setpoints, thinned so that a glance costs
//! little: per fiftieth of a second the lowest and highest angle and the last setpoint.

use std::collections::VecDeque;

use armbridge_link::message::{Drive, Record};
use armbridge_servo::JOINTS;

/// Duration that is kept, in s.
pub const SPAN_S: f64 = 10.0;

/// Time that is drawn as one, in µs: fewer than the dots of a wide terminal.
const SLICE_US: u64 = 20_000;
const SLICES: u64 = (SPAN_S * 1e6) as u64 / SLICE_US;

/// One joint in one slice of time, in rad.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Seen {
    /// Lowest estimated angle.
    pub low: f32,
    /// Highest.
    pub high: f32,
    /// Last setpoint; none while no controller holds the arm at it.
    pub setpoint: Option<f32>,
}

/// A slice of time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Slice {
    /// Number of the slice since the board's clock began.
    pub number: u64,
    /// Values in it.
    pub joints: [Seen; JOINTS],
}

impl Slice {
    /// Its middle, in s of the board's clock.
    pub fn at_s(&self) -> f64 {
        (self.number * SLICE_US + SLICE_US / 2) as f64 * 1e-6
    }
}

/// The slices.
#[derive(Clone, Debug, Default)]
pub struct History {
    slices: VecDeque<Slice>,
}

impl History {
    /// Takes a tick.
    pub fn take(&mut self, record: &Record) {
        let number = record.input.start_us / SLICE_US;
        // The board has begun anew.
        if self.slices.back().is_some_and(|last| number < last.number) {
            self.slices.clear();
        }
        let is_held = record.mode.drive().is_some_and(Drive::is_closed_loop);
        let joints = std::array::from_fn(|joint| Seen {
            low: record.output.angle_rad[joint],
            high: record.output.angle_rad[joint],
            setpoint: is_held.then_some(record.output.reference_rad[joint]),
        });
        match self.slices.back_mut() {
            Some(last) if last.number == number => {
                for (seen, more) in last.joints.iter_mut().zip(joints) {
                    seen.low = seen.low.min(more.low);
                    seen.high = seen.high.max(more.high);
                    seen.setpoint = more.setpoint;
                }
            }
            _ => self.slices.push_back(Slice { number, joints }),
        }
        while self
            .slices
            .front()
            .is_some_and(|first| first.number + SLICES < number)
        {
            self.slices.pop_front();
        }
    }

    /// Oldest first.
    pub fn slices(&self) -> impl Iterator<Item = &Slice> {
        self.slices.iter()
    }

    /// Lowest and highest of everything seen since then; `None` if nothing was.
    pub fn range(&self, joint: usize, since_s: f64) -> Option<(f32, f32)> {
        let recent = self.slices().filter(|slice| slice.at_s() >= since_s);
        let seen = recent.map(|slice| slice.joints[joint]);
        let ends = seen.flat_map(|seen| [Some(seen.low), Some(seen.high), seen.setpoint]);
        let finite = ends.flatten().filter(|value| value.is_finite());
        finite.fold(None, |range, value| {
            let (low, high) = range.unwrap_or((value, value));
            Some((low.min(value), high.max(value)))
        })
    }
}
