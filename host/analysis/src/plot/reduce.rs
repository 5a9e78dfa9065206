//! Bounded set of ticks that draws like all of them.
//!
//! A figure has about two thousand columns of pixels, a run any number of ticks. Of all ticks
//! in one column only those are visible in which a drawn quantity is first, last, smallest or
//! largest, and those at a change such as that of the mode; the others are omitted. Up to [`TICKS_MAX`]
//! ticks nothing is omitted; beyond, columns widen by doubling, and never beyond a pixel of
//! the figure by much. No peak is lost.

use armbridge_client::enum_names;
use armbridge_link::message::Record;
use armbridge_log::record_values::{angle_rad, count, error_rad, reference_rad};
use armbridge_servo::JOINTS;

/// Largest number of ticks in memory: 80 s at 1 kHz, some 10 MB.
const TICKS_MAX: usize = 80_000;

/// Smallest width of a column in s: one tick at the highest rate.
const COLUMN_S: f64 = 1e-3;

/// Changes that are kept in one column.
const CHANGES: usize = 2;

/// A tick with its time: its record, or other values of it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Tick<T = Record> {
    /// In s.
    pub(super) time_s: f64,
    /// No tick is missing since the one before it.
    pub(super) follows: bool,
    pub(super) record: T,
}

/// Values of a tick that a figure draws.
pub(super) trait Drawn: Sized + 'static {
    /// Quantities whose extremes are visible; NaN where one is not drawn.
    const QUANTITIES: &'static [fn(&Self) -> f64];

    /// Whether the change from one tick to the next is visible.
    fn is_change(_before: &Self, _after: &Self) -> bool {
        false
    }
}

impl Drawn for Record {
    const QUANTITIES: &'static [fn(&Self) -> f64] = &[
        |r| angle_rad(r, 0),
        |r| angle_rad(r, 1),
        |r| count(r, 0),
        |r| count(r, 1),
        |r| error_rad(r, 0),
        |r| error_rad(r, 1),
        |r| reference_rad(r, 0),
        |r| reference_rad(r, 1),
        |r| f64::from(r.output.torque_nm[0]),
        |r| f64::from(r.output.torque_nm[1]),
        |r| f64::from(r.input.pwm_in_force[0]),
        |r| f64::from(r.input.pwm_in_force[1]),
        |r| missing(r, 0),
        |r| missing(r, 1),
        |r| f64::from(r.timing.start_error_us),
        |r| f64::from(r.timing.bus_us),
        |r| f64::from(r.timing.compute_ns),
    ];

    fn is_change(before: &Self, after: &Self) -> bool {
        before.mode != after.mode
    }
}

/// A value of each joint.
impl Drawn for [f64; JOINTS] {
    const QUANTITIES: &'static [fn(&Self) -> f64] = &[|values| values[0], |values| values[1]];
}

/// 1 if a sample is missing, else NaN.
pub(super) fn missing(record: &Record, joint: usize) -> f64 {
    match record.input.samples[joint].lost() {
        Some(_) if enum_names::is_up(record.mode) => 1.0,
        Some(_) | None => f64::NAN,
    }
}

/// Ticks in order of time, reduced as they are added.
#[derive(Debug)]
pub(super) struct Reduced<T = Record> {
    ticks: Vec<Tick<T>>,
    most: usize,
    column_s: f64,
}

impl<T: Drawn> Default for Reduced<T> {
    fn default() -> Self {
        Self::with_most(TICKS_MAX)
    }
}

impl<T: Drawn> Reduced<T> {
    fn with_most(most: usize) -> Self {
        Self {
            ticks: Vec::new(),
            most,
            column_s: COLUMN_S,
        }
    }

    pub(super) fn add(&mut self, tick: Tick<T>) {
        if self.ticks.len() >= self.most {
            self.reduce();
            // A quarter is free again, so that each tick is looked at a few times only.
            while self.ticks.len() > self.most / 4 * 3 {
                self.column_s *= 2.0;
                self.reduce();
            }
        }
        self.ticks.push(tick);
    }

    pub(super) fn into_ticks(self) -> Vec<Tick<T>> {
        self.ticks
    }

    /// Omits what is invisible in columns of this width.
    fn reduce(&mut self) {
        let column = |tick: &Tick<T>| (tick.time_s / self.column_s).floor();
        let columns = self
            .ticks
            .chunk_by(|a, b| column(a).to_bits() == column(b).to_bits());
        let mut is_kept = columns.flat_map(visible).collect::<Vec<_>>().into_iter();
        let mut follows = true;
        self.ticks.retain_mut(|tick| {
            tick.follows &= follows;
            let is_kept = is_kept.next().unwrap_or(true);
            follows = is_kept || tick.follows;
            is_kept
        });
    }
}

/// Which ticks of a column are visible.
fn visible<T: Drawn>(column: &[Tick<T>]) -> Vec<bool> {
    let mut is_visible = vec![false; column.len()];
    for end in [0, column.len() - 1] {
        is_visible[end] = true;
    }
    for quantity in T::QUANTITIES {
        let (mut lowest, mut highest) = (None, None);
        for (at, tick) in column.iter().enumerate() {
            let value = quantity(&tick.record);
            // Never true for NaN.
            if value < lowest.map_or(f64::INFINITY, |(_, least)| least) {
                lowest = Some((at, value));
            }
            if value > highest.map_or(f64::NEG_INFINITY, |(_, most)| most) {
                highest = Some((at, value));
            }
        }
        for (at, _) in lowest.into_iter().chain(highest) {
            is_visible[at] = true;
        }
    }
    let neighbours = column.windows(2).enumerate();
    let changes = neighbours.filter(|(_, two)| T::is_change(&two[0].record, &two[1].record));
    for (at, _) in changes.take(CHANGES) {
        is_visible[at] = true;
        is_visible[at + 1] = true;
    }
    is_visible
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn memory_is_bounded_and_no_peak_gap_or_mode_is_lost() {
        use armbridge_link::message::{Drive, Fault, Mode};
        let mut reduced = Reduced::with_most(4_000);
        let count = 200_000;
        for at in 0..count {
            let mut record = Record {
                tick: at,
                mode: Mode::Running(Drive::Regulate),
                ..Record::NONE
            };
            record.output.angle_rad = [(at as f32 * 0.01).sin(), 0.5];
            record.output.torque_nm[1] = if at == 123_457 { 9.0 } else { 0.0 };
            if at == 150_001 {
                record.mode = Mode::Fault(Fault::HostSilent);
            }
            reduced.add(Tick {
                time_s: f64::from(at) * 1e-3,
                follows: at != 77_777,
                record,
            });
            assert!(reduced.ticks.len() <= 4_000);
        }
        let ticks = reduced.into_ticks();
        // At least as many columns as a small figure has pixels.
        assert!(ticks.len() > 1_000, "{}", ticks.len());
        assert!(
            ticks
                .iter()
                .any(|tick| tick.record.output.torque_nm[1] > 8.9)
        );
        assert_eq!(ticks.iter().filter(|tick| !tick.follows).count(), 1);
        assert!(ticks.iter().any(|tick| tick.record.tick == 150_001));
        assert_eq!(
            [ticks[0].record.tick, ticks.last().unwrap().record.tick],
            [0, count - 1]
        );
        let highest = ticks
            .iter()
            .map(|t| t.record.output.angle_rad[0])
            .fold(0.0, f32::max);
        assert!(highest > 0.999_99, "{highest}");
    }
}
