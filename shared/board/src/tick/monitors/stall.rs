//! Stall monitor: a joint that does not move though it is driven.
//!
//! A joint is stuck if it does not move under a torque that is sure to move
//! it: well beyond gravity and friction, in one direction, for long enough. Noise is no
//! motion, and changes every other sample where it is one count rms: so the
//! mean over some samples is compared.

use super::debounce::{Debounce, ticks};
use armbridge_control::check_word::checked;
use armbridge_link::fault::Fault;
use armbridge_link::limits::Limits;
use armbridge_link::record::Violation;

/// Time in µs, and ticks, for which a joint must be driven without motion. By then even
/// 0.4 N m turn the paper's arm by 20 counts; one that such a torque turns round
/// is near its turning point for 100 ms.
const STUCK_US: u32 = 150_000;
const STUCK_TICKS: u32 = 5;

/// Time constant of the mean in µs. At 1 kHz it leaves 0.2 counts of noise.
const MEAN_US: f32 = 20_000.0;

/// Largest change of the mean without motion: a count, and noise.
const STILL_COUNTS: f32 = 1.5;

/// Parameters of the stall monitor, for one period.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct StallConfig {
    pushed_ticks: u32,
    /// Weight of a sample in the mean.
    share: f32,
}

checked!(StallConfig {
    pushed_ticks,
    share,
});

/// Stall monitor of one joint. Ticks without a sample are skipped.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "snapshot", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Stall(Option<StallState>);

/// Samples of a joint since the monitor was reset.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "snapshot", derive(serde::Serialize, serde::Deserialize))]
struct StallState {
    mean: f32,
    /// Mean at the beginning of the push.
    from: f32,
    is_up: bool,
    pushed: Debounce,
}

impl StallConfig {
    pub(super) fn new(period_us: u32) -> Self {
        let period = period_us as f32;
        Self {
            pushed_ticks: ticks(STUCK_US, period_us, STUCK_TICKS),
            share: period / (period + MEAN_US),
        }
    }
}

impl Stall {
    /// Checks a sample, with the torque in N m beyond gravity that acted before it.
    pub(super) fn check(
        &mut self,
        config: StallConfig,
        limits: &Limits,
        joint: u8,
        counts: u16,
        push_nm: f32,
    ) -> Result<(), Violation> {
        let (mean, is_up) = (f32::from(counts), push_nm > 0.0);
        let state = self.0.get_or_insert(StallState {
            mean,
            from: mean,
            is_up,
            pushed: Debounce::default(),
        });
        state.mean += (mean - state.mean) * config.share;
        let is_same_push = push_nm.abs() > limits.stuck_nm && is_up == state.is_up;
        let is_still = (state.mean - state.from).abs() <= STILL_COUNTS;
        if !(is_same_push && is_still) {
            (state.from, state.is_up) = (state.mean, is_up);
        }
        let is_stuck = state
            .pushed
            .count(is_same_push && is_still, config.pushed_ticks);
        if is_stuck {
            return Err(Violation {
                fault: Fault::Stuck,
                joint: Some(joint),
                value: push_nm.abs(),
                limit: limits.stuck_nm,
            });
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Ticks until a violation, of up to 2 s.
    fn until(
        limits: &Limits,
        period_us: u32,
        mut seen: impl FnMut(u32) -> (u16, f32),
    ) -> Option<u32> {
        let (config, mut stall) = (StallConfig::new(period_us), Stall::default());
        (1..2_000_000 / period_us).find(|tick| {
            let (counts, push_nm) = seen(*tick);
            stall
                .check(config, limits, 1, counts, push_nm)
                .is_err_and(|violation| violation.fault == Fault::Stuck)
        })
    }

    /// A count of noise, near enough: -2 to 2, 1.2 rms.
    fn noise(tick: u32) -> u16 {
        let random = tick.wrapping_mul(2_654_435_761) >> 16;
        [510, 511, 511, 512, 512, 512, 513, 513, 514, 512][random as usize % 10]
    }

    #[test]
    fn a_joint_that_is_driven_and_stays_is_stuck() {
        let limits = Limits::default();
        for push in [0.41, -0.41] {
            let still =
                [600, 1_000, 45_000, 100_000].map(|period| until(&limits, period, |_| (512, push)));
            assert_eq!(still, [250, 150, 5, 5].map(Some));
            let noisy = until(&limits, 1_000, |tick| (noise(tick), push)).unwrap();
            assert!((150..300).contains(&noisy), "{noisy}");
        }
    }

    #[test]
    fn a_joint_that_need_not_move_is_not_stuck() {
        let limits = Limits::default();
        // Held by dry friction, gravity misjudged by a good deal.
        assert_eq!(until(&limits, 1_000, |tick| (noise(tick), 0.39)), None);
        // Shaken.
        let shaken = |tick: u32| (512, if tick % 200 < 100 { 0.6 } else { -0.6 });
        assert_eq!(until(&limits, 1_000, shaken), None);
        // Driven along, at 0.3 rad/s: a tenth of what such a torque leads to.
        let driven = |tick: u32| (300 + (tick * 58 / 1_000) as u16, 0.41);
        assert_eq!(until(&limits, 1_000, driven), None);
        // Turned round: a parabola, at 0.4 N m on 0.031 kg m^2.
        let turned = |tick: u32| {
            let t = tick as f32 * 1e-3 - 1.0;
            ((0.5 * 13.0 * t * t / 0.005118) as u16, 0.41)
        };
        assert_eq!(until(&limits, 1_000, turned), None);
    }
}
