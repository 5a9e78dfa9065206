//! Rests of a joint that end in sliding.
//!
//! With the jitter of a controller's PWM a joint may slide for a moment and rest again
//! undetected. Only rests with a PWM that changes slowly count.

use super::super::arm::KnownParameters;
use super::super::dataset::Trace;

/// Ticks on either side of one in the line fit that detects a rest.
const HALF_WIDTH: usize = 60;
/// Speed of this fit in counts a second below which a joint counts as resting: 5 standard
/// deviations with noise of a count.
const RESTS_COUNTS_S: f64 = 13.7;
/// Speed of a smoothed trace in counts a second above which a joint counts as sliding: 5 standard
/// deviations as well.
const SLIDES_COUNTS_S: f64 = 48.9;
/// Shortest rest in ticks.
const REST_MIN: usize = 100;
/// Largest change of a slow PWM from tick to tick, in counts.
const SLOW_COUNTS: u16 = 2;
/// Ticks of sliding in the analysis of a breakaway.
const SLIDING_TICKS: usize = 60;

/// A rest that ended: first tick, first tick that counts as sliding, and end of the analysis.
/// The onset of sliding lies between the first two.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Rest {
    pub(super) first: usize,
    pub(super) sliding: usize,
    pub(super) end: usize,
}

/// All rests of a joint that end in sliding.
pub(super) fn rests(trace: &Trace, known: &KnownParameters, joint: usize) -> Vec<Rest> {
    let is_at_rest = |tick: usize| {
        let line = trace.fit_line(joint, tick, HALF_WIDTH);
        line.is_some_and(|[_, rate]| rate.abs() < RESTS_COUNTS_S * known.period_s)
    };
    let slides_rad_s = SLIDES_COUNTS_S * known.rad_per_count[joint].abs();
    let slides = |tick: usize| trace.states[tick][joint][1].abs() > slides_rad_s;
    let mut rests = Vec::new();
    let mut since: Option<usize> = None;
    for tick in 1..trace.states.len().saturating_sub(SLIDING_TICKS) {
        let [before, here] = [tick - 1, tick].map(|tick| trace.pwm[tick][joint]);
        if here.abs_diff(before) > SLOW_COUNTS {
            since = None;
        } else if let Some(first) = since {
            if slides(tick) {
                rests.extend((tick - first >= REST_MIN).then_some(Rest {
                    first,
                    sliding: tick,
                    end: tick + SLIDING_TICKS,
                }));
                since = None;
            }
        } else if is_at_rest(tick) && !slides(tick) {
            since = Some(tick);
        }
    }
    rests
}
