//! Where a joint rests until it slides.
//!
//! A controller's PWM trembles: a joint may give way for a moment and rest again unseen.
//! Only rests with a PWM that changes slowly are looked at.

use super::super::arm::Known;
use super::super::dataset::Trace;

/// Ticks to either side of one over which a joint is seen to rest.
const AROUND: usize = 60;
/// Speed in rad/s over these below which it may be at rest: 5 standard deviations with
/// noise of a count.
const RESTS_RAD_S: f64 = 0.07;
/// Speed in rad/s of a smoothed trace above which it surely slides: 5 of them, too.
const SLIDES_RAD_S: f64 = 0.25;
/// How long it must have rested, in ticks.
const SHORTEST: usize = 100;
/// Change of a slow PWM from tick to tick, in counts.
const SLOW_COUNTS: u16 = 2;
/// Ticks of sliding that are looked at.
const AFTER: usize = 60;

/// A rest that ended: first tick, the tick in which the joint surely slides, and the end of
/// what is looked at. It began to slide somewhere between the first two.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Rest {
    pub(super) first: usize,
    pub(super) slides: usize,
    pub(super) end: usize,
}

/// All of them.
pub(super) fn rests(trace: &Trace, known: &Known, joint: usize) -> Vec<Rest> {
    let scale = (known.rad_per_count[joint] / known.period_s).abs();
    let is_at_rest = |tick: usize| {
        let line = trace.line(joint, tick, AROUND);
        line.is_some_and(|[_, rate]| (rate * scale).abs() < RESTS_RAD_S)
    };
    let slides = |tick: usize| trace.smooth[tick][joint][1].abs() > SLIDES_RAD_S;
    let mut rests = Vec::new();
    let mut since: Option<usize> = None;
    for tick in 1..trace.smooth.len().saturating_sub(AFTER) {
        let [before, here] = [tick - 1, tick].map(|tick| trace.pwm[tick][joint]);
        if here.abs_diff(before) > SLOW_COUNTS {
            since = None;
        } else if let Some(first) = since {
            if slides(tick) {
                rests.extend((tick - first >= SHORTEST).then_some(Rest {
                    first,
                    slides: tick,
                    end: tick + AFTER,
                }));
                since = None;
            }
        } else if is_at_rest(tick) && !slides(tick) {
            since = Some(tick);
        }
    }
    rests
}
