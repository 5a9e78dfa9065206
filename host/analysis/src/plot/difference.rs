//! Difference of the joint angles of two runs, tick by tick.
//!
//! The ticks are those of [`pairs`](armbridge_log::inspect::diff::pairs), read from both logs
//! again: the ticks that a [`Run`] keeps for its curves are not enough for interpolation, nor for
//! a root mean square. As in `diff`, they end with a reset of the board.

use armbridge_link::message::Record;
use armbridge_log::inspect::diff::{pairs, ticks};
use armbridge_log::record_values::angle_rad;
use armbridge_log::recording::ReadError;
use armbridge_servo::JOINTS;

use super::reduce::{Reduced, Tick};
use super::rms::Rms;
use super::run::Run;

/// Time in s by which a tick at the end of a window may be outside of it: times are rounded
/// where runs are aligned.
const ROUNDING_S: f64 = 1e-9;

/// Difference of a run from the first.
#[derive(Debug)]
pub(super) struct Difference {
    /// Difference of each joint's angle in mrad, in the visible ticks.
    pub(super) ticks: Vec<Tick<[f64; JOINTS]>>,
    /// Its root mean square over all ticks, in mrad.
    pub(super) rms_mrad: [f64; JOINTS],
}

impl Difference {
    /// Reads the logs of both runs, in the windows of both.
    pub(super) fn read(first: &Run, other: &Run) -> Result<Self, ReadError> {
        let periods_s = [first, other].map(Run::period_s);
        let (mut reduced, mut rms) = (Reduced::default(), Rms::default());
        for pair in pairs([shown(first)?, shown(other)?], periods_s) {
            let [a, b] = &pair.records;
            let mrad = [0, 1].map(|joint| 1e3 * (angle_rad(b, joint) - angle_rad(a, joint)));
            rms.add(mrad);
            reduced.add(Tick {
                time_s: pair.time_s,
                follows: pair.follows,
                record: mrad,
            });
        }
        Ok(Self {
            ticks: reduced.into_ticks(),
            rms_mrad: rms.values(),
        })
    }

    /// Values of a joint, with NaN where ticks are missing.
    pub(super) fn curve(&self, joint: usize) -> impl Iterator<Item = (f64, f64)> {
        self.ticks.iter().flat_map(move |tick| {
            let gap = (!tick.follows).then_some((tick.time_s, f64::NAN));
            gap.into_iter().chain([(tick.time_s, tick.record[joint])])
        })
    }
}

/// Ticks of a run in its window.
fn shown(run: &Run) -> Result<impl Iterator<Item = (f64, Record)> + use<>, ReadError> {
    let [from_s, to_s] = run.window;
    let ticks = ticks(&run.path, run.origin_s, from_s - ROUNDING_S)?;
    Ok(ticks.take_while(move |(time_s, _)| *time_s <= to_s + ROUNDING_S))
}
