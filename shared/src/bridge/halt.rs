//! After a fault: the stop sequence, until the servos are seen to stand.
//!
//! The sequence is sent at once. Then the servos are watched: the ticks go on
//! with motors off, and what each encoder says over a [`WINDOW_US`] tells whether
//! its joint stands. As long as one does not, or says nothing, the sequence is
//! sent again after each window. An arm that falls takes a second to come to
//! rest, so the host is told only of what lasts.

use crate::JOINTS;
use crate::link::message::{Halt, Standstill};

/// How long servos are watched between two stop sequences. An arm that turns by
/// [`STILL_COUNTS`] in this time turns at 0.5 rad/s.
const WINDOW_US: u64 = 100_000;
/// Spread of an encoder that stands: the noise of one count rms spreads 100
/// samples over five, seldom seven.
const STILL_COUNTS: u16 = 10;
/// A joint that moves for so long is reported: a falling arm rests before that.
const FALL_US: u64 = 3_000_000;
/// A servo that says nothing for so long is reported.
const SILENT_US: u64 = 300_000;
/// After the report the sequence is sent so much less often.
const SELDOM: u64 = 5;

/// The watch over servos that were told to stop.
#[derive(Clone, Copy, Debug)]
pub(super) struct Halting {
    since_us: u64,
    window_ends_us: u64,
    /// Least and largest count in this window.
    spread: [Option<(u16, u16)>; JOINTS],
    stops: u16,
    /// What was seen in the window before.
    before: Option<[Standstill; JOINTS]>,
    reported: Option<[Standstill; JOINTS]>,
}

/// What the watch asks for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Verdict {
    /// Send the stop sequence again.
    pub(super) stop_again: bool,
    /// Tell the host.
    pub(super) report: Option<Halt>,
}

impl Halting {
    /// The sequence has just been ordered for the first time.
    pub(super) fn begin(now_us: u64) -> Self {
        Self {
            since_us: now_us,
            window_ends_us: now_us + WINDOW_US,
            spread: [None; JOINTS],
            stops: 1,
            before: None,
            reported: None,
        }
    }

    /// Takes a tick's samples.
    pub(super) fn watch(&mut self, now_us: u64, counts: [Option<u16>; JOINTS]) -> Verdict {
        for (spread, counts) in self.spread.iter_mut().zip(counts) {
            if let Some(counts) = counts {
                let (least, most) = spread.unwrap_or((counts, counts));
                *spread = Some((least.min(counts), most.max(counts)));
            }
        }
        if now_us < self.window_ends_us {
            return Verdict {
                stop_again: false,
                report: None,
            };
        }
        let joints = self.spread.map(|spread| match spread {
            None => Standstill::Silent,
            Some((least, most)) if most - least <= STILL_COUNTS => Standstill::Still,
            Some(_) => Standstill::Moving,
        });
        let stop_again = joints != [Standstill::Still; JOINTS];
        let lasts_us = now_us.saturating_sub(self.since_us);
        let is_sure = joints.iter().all(|joint| match joint {
            // An arm that begins to fall hardly moves in its first tenth of a second.
            Standstill::Still => self.before == Some(joints),
            Standstill::Silent => lasts_us >= SILENT_US,
            Standstill::Moving => lasts_us >= FALL_US,
        });
        let report = (is_sure && self.reported != Some(joints)).then(|| {
            self.reported = Some(joints);
            Halt {
                stops: self.stops,
                joints,
            }
        });
        self.before = Some(joints);
        self.spread = [None; JOINTS];
        let windows = if self.reported.is_some() { SELDOM } else { 1 };
        self.window_ends_us = now_us + windows * WINDOW_US;
        if stop_again {
            self.stops = self.stops.saturating_add(1);
        }
        Verdict { stop_again, report }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use Standstill::{Moving, Silent, Still};

    /// What is asked for in so many ticks of 1 ms: stops, and reports with their tick.
    fn run(
        ticks: u64,
        counts: impl Fn(u64) -> [Option<u16>; 2],
    ) -> (usize, [Option<(u64, Halt)>; 4]) {
        let mut halting = Halting::begin(0);
        let (mut stops, mut reports, mut told) = (0, [None; 4], 0);
        for tick in 1..=ticks {
            let verdict = halting.watch(tick * 1_000, counts(tick));
            stops += usize::from(verdict.stop_again);
            if let Some(halt) = verdict.report {
                reports[told] = Some((tick, halt));
                told += 1;
            }
        }
        (stops, reports)
    }

    #[test]
    fn servos_that_stand_are_stopped_once() {
        let (stops, reports) = run(2_000, |tick| [Some(500 + (tick % 5) as u16), Some(512)]);
        let halt = Halt {
            stops: 1,
            joints: [Still; 2],
        };
        assert_eq!((stops, reports), (0, [Some((200, halt)), None, None, None]));
    }

    #[test]
    fn a_falling_arm_is_stopped_until_it_rests() {
        let falls = |tick: u64| 300 + (tick.min(800) / 4) as u16;
        let (stops, reports) = run(2_000, |tick| [Some(falls(tick)), Some(512)]);
        let (tick, halt) = reports[0].unwrap();
        assert_eq!(
            (stops, tick, halt.stops, halt.joints),
            (8, 1_000, 9, [Still; 2])
        );
        assert_eq!(reports[1], None);
    }

    #[test]
    fn what_moves_or_says_nothing_for_long_is_reported_and_stopped_on() {
        let (stops, reports) = run(6_000, |tick| [Some((tick % 1000) as u16), Some(512)]);
        let (tick, halt) = reports[0].unwrap();
        assert_eq!((tick, halt.joints), (3_000, [Moving, Still]));
        // Each window until then, each fifth after.
        assert_eq!(stops, 30 + 6);
        let (stops, reports) = run(1_000, |_| [Some(512), None]);
        let (tick, halt) = reports[0].unwrap();
        assert_eq!((tick, halt.joints, stops), (300, [Still, Silent], 4));
    }
}
