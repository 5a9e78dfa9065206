//! Dropout monitor: missing samples.
//!
//! Three faults of each joint: a servo is silent; its replies are repeatedly damaged;
//! or too many samples are missing, though never too many in a row. The
//! estimator predicts through shorter dropouts.

use super::debounce::ticks;
use crate::tick::limits::ROW_TICKS;
use armbridge_control::check_word::checked;
use armbridge_link::fault::Fault;
use armbridge_link::limits::Limits;
use armbridge_link::message::Missing;
use armbridge_link::record::Violation;
use armbridge_servo::JOINTS;

/// Number of parts of the window of a share, the last of them growing: no history of
/// single ticks is needed.
const PARTS: usize = 10;

/// Length of a part in µs: a second in all.
const PART_US: u32 = 100_000;

/// Ticks of a part, at any period. Fifty distinguish one lost reply in five from
/// one in two; ten do not.
const PART_TICKS: u32 = 5;

/// Least window for a share, in µs and in ticks.
const SHARE_US: u32 = 500_000;
const SHARE_TICKS: u32 = 40;

/// Parameters of the dropout monitor, for one set of limits and one period.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct DropoutConfig {
    row_ticks: u32,
    part_ticks: u32,
    share_ticks: u32,
    period_ms: f32,
}

checked!(DropoutConfig {
    row_ticks,
    part_ticks,
    share_ticks,
    period_ms,
});

/// Counters of the dropout monitor.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "snapshot", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Dropout {
    rows: [Row; JOINTS],
    shares: [Share; JOINTS],
    /// Index of the growing part, and its ticks.
    part: usize,
    part_age: u32,
    /// Ticks of all parts.
    age: u32,
}

/// Samples of one joint missing in a row.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "snapshot", derive(serde::Serialize, serde::Deserialize))]
struct Row {
    missing: u32,
    /// Whether bytes were received meanwhile.
    has_bytes: bool,
}

/// Samples of one joint missing in the window.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "snapshot", derive(serde::Serialize, serde::Deserialize))]
struct Share {
    parts: [u32; PARTS],
    missing: u32,
}

impl DropoutConfig {
    pub(super) fn new(limits: &Limits, period_us: u32) -> Self {
        let row_us = u32::from(limits.lost_ms) * 1_000;
        Self {
            row_ticks: ticks(row_us, period_us, ROW_TICKS),
            part_ticks: ticks(PART_US, period_us, PART_TICKS),
            share_ticks: ticks(SHARE_US, period_us, SHARE_TICKS),
            period_ms: period_us as f32 * 1e-3,
        }
    }

    /// Number of consecutive missing samples that is a fault.
    pub(super) fn row_ticks(&self) -> u32 {
        self.row_ticks
    }
}

impl Dropout {
    /// Samples of this joint that are missing in a row.
    pub(super) fn in_row(&self, joint: usize) -> u32 {
        self.rows.get(joint).map_or(0, |row| row.missing)
    }

    pub(super) fn check(
        &mut self,
        config: &DropoutConfig,
        limits: &Limits,
        missing: [Option<Missing>; JOINTS],
    ) -> Result<(), Violation> {
        self.begin_tick(config);
        let limit_percent = u32::from(limits.lost_percent);
        let counted = self.rows.iter_mut().zip(&mut self.shares);
        for ((joint, missing), (row, share)) in (0..).zip(missing).zip(counted) {
            let Some(missing) = missing else {
                *row = Row::default();
                continue;
            };
            row.add(missing);
            if row.missing >= config.row_ticks {
                return Err(Violation {
                    fault: row.fault(),
                    joint: Some(joint),
                    value: row.missing as f32 * config.period_ms,
                    limit: limits.lost_ms.into(),
                });
            }
            share.add(self.part);
            if self.age >= config.share_ticks && share.missing * 100 > limit_percent * self.age {
                return Err(Violation {
                    fault: Fault::SamplesRare,
                    joint: Some(joint),
                    value: (share.missing * 100) as f32 / self.age as f32,
                    limit: limit_percent as f32,
                });
            }
        }
        Ok(())
    }

    /// Moves the window on by a part when one is full.
    fn begin_tick(&mut self, config: &DropoutConfig) {
        if self.part_age == config.part_ticks {
            self.part = if self.part + 1 < PARTS {
                self.part + 1
            } else {
                0
            };
            self.part_age = 0;
            if self.age == config.part_ticks * PARTS as u32 {
                self.age -= config.part_ticks;
            }
            for share in &mut self.shares {
                share.clear_part(self.part);
            }
        }
        self.part_age += 1;
        self.age += 1;
    }
}

impl Row {
    fn add(&mut self, missing: Missing) {
        // A servo that fails may be cut off in the middle of its reply, so the
        // first missing sample of the row is no evidence.
        self.has_bytes |= self.missing > 0 && has_bytes(missing);
        self.missing = self.missing.saturating_add(1);
    }

    fn fault(self) -> Fault {
        if self.has_bytes {
            Fault::SamplesLost
        } else {
            Fault::ServoSilent
        }
    }
}

impl Share {
    fn add(&mut self, part: usize) {
        if let Some(part) = self.parts.get_mut(part) {
            *part += 1;
        }
        self.missing += 1;
    }

    fn clear_part(&mut self, part: usize) {
        if let Some(part) = self.parts.get_mut(part) {
            self.missing -= *part;
            *part = 0;
        }
    }
}

/// Whether a servo may have answered. A servo without a request is not silent.
const fn has_bytes(missing: Missing) -> bool {
    match missing {
        Missing::Silence | Missing::EchoOnly => false,
        Missing::NotAsked
        | Missing::BadChecksum
        | Missing::WrongId
        | Missing::Short
        | Missing::Line => true,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Ticks until a violation, with what is missing of joint 1 in each.
    fn until(
        period_us: u32,
        mut missing: impl FnMut(u32) -> Option<Missing>,
    ) -> Option<(u32, Fault)> {
        let limits = Limits::default();
        let config = DropoutConfig::new(&limits, period_us);
        let mut losses = Dropout::default();
        (1..10_000).find_map(|tick| {
            let violation = losses
                .check(&config, &limits, [None, missing(tick)])
                .err()?;
            assert_eq!(violation.joint, Some(1));
            assert!(violation.value >= violation.limit, "{violation:?}");
            Some((tick, violation.fault))
        })
    }

    #[test]
    fn a_row_is_20_ms_and_five_ticks() {
        let rows = [1_000, 1_500, 4_000, 5_000, 100_000]
            .map(|period| until(period, |_| Some(Missing::EchoOnly)));
        let silent = |ticks| Some((ticks, Fault::ServoSilent));
        assert_eq!(rows, [20, 14, 5, 5, 5].map(silent));
        // One sample in 20 ends every row.
        let almost = |tick| (tick % 20 > 0).then_some(Missing::Silence);
        let (tick, fault) = until(1_000, almost).unwrap();
        // Half a second, at the end of which that one came.
        assert_eq!((tick, fault), (501, Fault::SamplesRare));
    }

    #[test]
    fn a_servo_is_silent_if_nothing_was_heard_once_it_was_gone() {
        let cut = |tick| {
            Some(match tick {
                1 => Missing::Short,
                _ => Missing::Silence,
            })
        };
        assert_eq!(until(1_000, cut), Some((20, Fault::ServoSilent)));
        let damaged = |tick| {
            Some(match tick {
                7 => Missing::BadChecksum,
                _ => Missing::Silence,
            })
        };
        assert_eq!(until(1_000, damaged), Some((20, Fault::SamplesLost)));
    }

    /// Four in nine may be lost, two in three may not.
    #[test]
    fn a_share_is_that_of_the_last_second_whatever_the_period() {
        for period_us in [600, 1_000, 10_000, 100_000] {
            let many = |tick| (tick % 9 < 4).then_some(Missing::Line);
            assert_eq!(until(period_us, many), None, "{period_us}");
            // Two thirds, after a long time without any loss.
            let clean = ticks(3_000_000, period_us, 150);
            let turning = |tick| (tick > clean && tick % 3 > 0).then_some(Missing::Line);
            let (tick, fault) = until(period_us, turning).unwrap();
            assert_eq!(fault, Fault::SamplesRare);
            let window = ticks(1_000_000, period_us, 50);
            // Half of the window missing, at two thirds, takes three quarters of
            // it, give or take the part that it moves on by.
            let taken = f64::from(tick - clean) / f64::from(window);
            assert!((0.6..0.85).contains(&taken), "{period_us}: {taken}");
        }
    }

    /// One reply in five, at random: seen on real lines, and bearable.
    #[test]
    fn a_fifth_of_all_samples_may_be_missing() {
        for period_us in [1_000, 45_000] {
            let mut seed = 1_u32;
            let mut random = move || {
                seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                seed >> 16
            };
            let limits = Limits::default();
            let config = DropoutConfig::new(&limits, period_us);
            let mut losses = Dropout::default();
            let mut longest = 0;
            for _ in 0..20_000 {
                let missing = (random() % 5 == 0).then_some(Missing::BadChecksum);
                // Rows of five do come, and are the other rule's.
                let missing = missing.filter(|_| losses.rows[0].missing < 4);
                assert_eq!(losses.check(&config, &limits, [missing, None]), Ok(()));
                longest = longest.max(losses.shares[0].missing);
            }
            assert!(longest > losses.age / 5, "{longest} of {}", losses.age);
        }
    }
}
