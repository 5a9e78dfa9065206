//! Hand that leads an arm that floats, slowly and to and fro.

use armbridge_servo::JOINTS;

use super::case::Case;
use crate::plant::{Grip, Lead, LeadPoint};

/// Time in µs from the start of the activity to that of the hand; the arm has been weighed
/// before.
pub(super) const LED_US: u64 = 2_500_000;
/// Time in µs of each way of the hand, of half a radian at most, and their number.
const LEG_US: u64 = 1_250_000;
const LEGS: u64 = 5;
/// Grip at the end of the arm.
const HAND: Grip = Grip {
    link: JOINTS - 1,
    stiffness_n_m: 300.0,
    damping_n_s_m: 10.0,
};

/// The hand of a case, where the activity begins now: it leads the arm from where it began by the
/// target angles, and by as much the other way.
pub(super) fn lead(case: &Case, now_us: u64) -> Lead {
    let point = |leg: u64| {
        let sign = if leg.is_multiple_of(2) { -1.0 } else { 1.0 };
        let angle_rad =
            |joint: usize| case.initial_rad[joint] + sign * f64::from(case.to_rad[joint]);
        LeadPoint {
            after_ns: leg * LEG_US * 1_000,
            angle_rad: core::array::from_fn(angle_rad),
        }
    };
    Lead {
        grip: HAND,
        start_ns: (now_us + LED_US) * 1_000,
        path: (1..=LEGS).map(point).collect(),
        release_ns: LEGS * LEG_US * 1_000,
    }
}
