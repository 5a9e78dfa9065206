//! Playback: the motion of the last float, replayed from the dashboard.
//!
//! The arm moves to the first angles of the motion and rests there; then points of it are streamed,
//! some tenths of a second ahead of the board's clock. Any other drive ends the playback.

use armbridge_analysis::taught_motion::{SPACING_S, TaughtMotion};
use armbridge_link::message::{Command, Drive, Record};
use armbridge_link::motion::Motion;
use armbridge_servo::JOINTS;

/// Samples of the motion from one point of the stream to the next, and the time between in µs.
const SAMPLES: usize = 5;
const POINT_US: u64 = (SAMPLES as f64 * SPACING_S * 1e6) as u64;
/// Time in µs for which points are sent ahead: six points, of which a board keeps eight.
const AHEAD_US: u64 = 6 * POINT_US;
/// Distance in rad from the first angles at which the reference is there.
const THERE_RAD: f32 = 1e-3;
/// Longest time in µs of the way to the first angles.
const APPROACH_US: u64 = 15_000_000;

/// See the [module](self).
#[derive(Clone, Debug)]
pub struct Playback {
    points: Vec<[f32; JOINTS]>,
    phase: Phase,
}

/// Phase, with times of the board's clock in µs.
#[derive(Clone, Copy, Debug)]
enum Phase {
    /// On the way to the first angles, until then at the latest.
    Approach { until_us: u64 },
    /// The first point is at this time, and this is the next to be sent.
    Streaming { begins_us: u64, next: usize },
}

/// Progress of a playback.
#[derive(Clone, Debug, PartialEq)]
pub enum Progress {
    /// These commands are due.
    Due(Vec<Command>),
    /// The arm is at the end of the motion.
    Done,
    /// Something else drives the arm, or nothing does.
    Ended,
}

impl Playback {
    /// A playback that begins at this time of the board's clock, and its first command.
    pub fn begin(taught: &TaughtMotion, board_us: u64) -> (Self, Command) {
        let last = taught.angle_rad.last();
        let points = taught.angle_rad.iter().step_by(SAMPLES).chain(last);
        let points: Vec<[f32; JOINTS]> = points.map(|q| q.map(|rad| rad as f32)).collect();
        let approach = Command::Follow(Motion::MinimumJerk {
            to_rad: points.first().copied().unwrap_or_default(),
            duration_s: None,
        });
        let phase = Phase::Approach {
            until_us: board_us + APPROACH_US,
        };
        (Self { points, phase }, approach)
    }

    /// Advances to this time of the board's clock, after this record.
    pub fn advance(&mut self, record: &Record, board_us: u64) -> Progress {
        let Some(drive) = record.mode.drive() else {
            return Progress::Ended;
        };
        match &mut self.phase {
            Phase::Approach { until_us } if board_us > *until_us => Progress::Ended,
            Phase::Approach { .. } => {
                if drive == Drive::Track && self.is_at_first(record) {
                    self.phase = Phase::Streaming {
                        begins_us: board_us + AHEAD_US / 2,
                        next: 0,
                    };
                }
                Progress::Due(Vec::new())
            }
            Phase::Streaming { .. } if drive != Drive::Track => Progress::Ended,
            Phase::Streaming { begins_us, next } => {
                let at_us = |number: usize| *begins_us + number as u64 * POINT_US;
                let mut due = Vec::new();
                while let Some(angle_rad) = self.points.get(*next)
                    && at_us(*next) < board_us + AHEAD_US
                {
                    due.push(Command::Stream {
                        at_us: at_us(*next),
                        angle_rad: *angle_rad,
                        speed_rad_s: None,
                    });
                    *next += 1;
                }
                if due.is_empty() && board_us > at_us(self.points.len()) {
                    Progress::Done
                } else {
                    Progress::Due(due)
                }
            }
        }
    }

    /// Whether the reference rests at the first angles.
    fn is_at_first(&self, record: &Record) -> bool {
        let output = &record.output;
        let there = self.points.first().is_some_and(|first| {
            (0..JOINTS).all(|joint| (output.reference_rad[joint] - first[joint]).abs() < THERE_RAD)
        });
        there
            && output
                .reference_speed_rad_s
                .iter()
                .all(|speed| speed.abs() < THERE_RAD)
    }
}

#[cfg(test)]
mod tests {
    use armbridge_link::message::Mode;

    use super::*;

    fn record(drive: Drive, reference_rad: [f32; JOINTS]) -> Record {
        let mut record = Record {
            mode: Mode::Running(drive),
            ..Record::NONE
        };
        record.output.reference_rad = reference_rad;
        record
    }

    fn taught() -> TaughtMotion {
        let angle_rad = (0..103).map(|k| [0.2 + f64::from(k) * 1e-3, -0.1]);
        TaughtMotion {
            angle_rad: angle_rad.collect(),
            cut_s: [0.0; 2],
            width_s: 0.02,
            is_clamped: false,
        }
    }

    /// Each point is sent once, in order and before its time, and the last is the motion's.
    #[test]
    fn the_points_are_sent_ahead_of_their_time() {
        let (mut playback, approach) = Playback::begin(&taught(), 1_000_000);
        assert!(
            matches!(approach, Command::Follow(Motion::MinimumJerk { to_rad, .. })
            if (to_rad[0] - 0.2).abs() < 1e-6)
        );
        let on_the_way = record(Drive::Track, [0.1, 0.0]);
        assert_eq!(
            playback.advance(&on_the_way, 1_100_000),
            Progress::Due(vec![])
        );
        let there = record(Drive::Track, [0.2, -0.1]);
        assert_eq!(playback.advance(&there, 1_200_000), Progress::Due(vec![]));
        let (mut sent, mut now_us) = (Vec::new(), 1_200_000);
        loop {
            now_us += 66_000;
            match playback.advance(&there, now_us) {
                Progress::Due(commands) => sent.extend(commands.into_iter().map(|it| (now_us, it))),
                progress => {
                    assert_eq!(progress, Progress::Done);
                    break;
                }
            }
        }
        assert_eq!(sent.len(), 103_usize.div_ceil(SAMPLES) + 1);
        let mut before_us = 0;
        for (now_us, command) in &sent {
            let Command::Stream { at_us, .. } = command else {
                panic!("{command:?}");
            };
            assert!(*at_us > now_us + 50_000 && *at_us > before_us, "{at_us}");
            before_us = *at_us;
        }
        assert!(
            matches!(sent.last(), Some((_, Command::Stream { angle_rad, .. }))
            if (angle_rad[0] - 0.302).abs() < 1e-6)
        );
    }

    #[test]
    fn another_drive_ends_it() {
        let there = record(Drive::Track, [0.2, -0.1]);
        for other in [
            Mode::Idle,
            Mode::Running(Drive::Float),
            Mode::Running(Drive::Park),
        ] {
            let (mut playback, _) = Playback::begin(&taught(), 0);
            playback.advance(&there, 1_000);
            let other = Record {
                mode: other,
                ..there
            };
            assert_eq!(
                playback.advance(&other, 2_000),
                Progress::Ended,
                "{other:?}"
            );
        }
    }
}
