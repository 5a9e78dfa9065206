//! Point to point with least jerk, and how soon it can be done.

use super::bounds::{Bounds, Peak, PeakTracker};
use super::quintic::Quintic;
use super::{DURATION_MAX_S, DURATION_MIN_S};
use crate::real::Real;
use crate::trajectory::Reference;

/// The shortest duration in s that meets the bounds, as near as 0.01 %.
///
/// From rest it is that at which the peak speed or acceleration touches its
/// bound. From motion there is no closed form, and longer is not always gentler:
/// an arm that must reach a near point in a long time first overshoots. So
/// durations are tried in a geometric progression, and the first that will do is
/// refined.
///
/// # Errors
///
/// The mildest violation if no duration will do.
pub(super) fn shortest<T: Real>(
    from: &Reference<T>,
    to: &Reference<T>,
    bounds: &Bounds<T>,
) -> Result<T, Peak<T>> {
    /// 2^(1/8).
    const RATIO: f64 = 1.0905077326652577;
    const HALVINGS: u8 = 12;

    let judge = |duration_s| {
        let mut tightest = PeakTracker::new(bounds);
        Quintic::joining(from, to, duration_s).show(T::zero(), duration_s, &mut tightest);
        tightest
    };
    // Nothing covers the distance faster than at full speed throughout.
    let at_full_speed_s = (to.q - from.q).amax() / bounds.speed_rad_s;
    let mut duration_s = at_full_speed_s.max(T::lit(DURATION_MIN_S));
    let mut too_short_s = duration_s;
    let mut mildest = judge(duration_s);
    while mildest.verdict().is_err() {
        too_short_s = duration_s;
        duration_s *= T::lit(RATIO);
        if duration_s > T::lit(DURATION_MAX_S) {
            return mildest.verdict().map(|_| duration_s);
        }
        let next = judge(duration_s);
        if next.verdict().is_ok() || next.ratio() < mildest.ratio() || !mildest.ratio().is_finite()
        {
            mildest = next;
        }
    }
    for _ in 0..HALVINGS {
        let middle_s = (too_short_s + duration_s) * T::lit(0.5);
        if judge(middle_s).verdict().is_ok() {
            duration_s = middle_s;
        } else {
            too_short_s = middle_s;
        }
    }
    Ok(duration_s)
}
