//! Streams as the board would take them: which point it would refuse, and the reference that
//! it makes of them.

use armbridge_board::bridge::limits::MOTION;
use armbridge_control::trajectory::stream::{self, Point, Stream};
use armbridge_control::trajectory::{Error, Reference};

use super::{mistake, peak_text};
use crate::plan_runner::plan::{self, STREAM_AHEAD};
use crate::scenario::mistake::{KeyPath, Mistake};

/// Computes the reference that the board makes of a stream's points, from rest at `start`,
/// every `step_us` until its end. Points are accepted: they have been checked.
pub(in crate::scenario) fn follow_stream(
    start: &Reference<f32>,
    points: &[plan::Point],
    step_us: u64,
    see: &mut impl FnMut(u64, &Reference<f32>),
) {
    let (Ok(mut stream), Some(end)) = (Stream::new(start, 0, &MOTION), points.last()) else {
        return;
    };
    let mut points = points.iter().peekable();
    for now_us in (0..=end.after_us).step_by(step_us as usize) {
        while let Some(point) = points.peek()
            && stream.points() < STREAM_AHEAD
        {
            let point = Point {
                at_us: point.after_us,
                q: point.angle_rad.into(),
                dq: point.speed_rad_s.map(Into::into),
            };
            if stream.push(now_us, point).is_err() {
                return;
            }
            points.next();
        }
        see(now_us, &stream.advance(now_us));
    }
}

/// Points of a stream with the runner's schedule: a few ahead of time.
pub(super) struct StreamSchedule<'a> {
    /// Reference at the step.
    pub(super) from: Reference<f32>,
    pub(super) at_us: u64,
    pub(super) points: &'a [plan::Point],
    pub(super) period_us: u32,
}

impl StreamSchedule<'_> {
    /// The stream on the board with all points, `delay_us` later than they are written.
    ///
    /// # Errors
    /// The index of the first point that the board would refuse, and the reason.
    pub(super) fn check(&self, delay_us: u64) -> Result<Stream<f32>, (usize, StreamError)> {
        /// Time of a command to the board and into its next tick, beside the tick's period.
        const LINK_US: u64 = 2_000;
        let latency_us = LINK_US + u64::from(self.period_us);
        let mut stream =
            Stream::new(&self.from, self.at_us, &MOTION).map_err(|error| (0, error.into()))?;
        for (number, point) in self.points.iter().enumerate() {
            let room = number
                .checked_sub(STREAM_AHEAD)
                .and_then(|k| self.points.get(k));
            let room_us = room.map_or(0, |room| room.after_us + delay_us);
            let pushed = stream.push(
                self.at_us + room_us + latency_us,
                Point {
                    at_us: self.at_us + point.after_us + delay_us,
                    q: point.angle_rad.into(),
                    dq: point.speed_rad_s.map(Into::into),
                },
            );
            pushed.map_err(|error| (number, error.into()))?;
        }
        Ok(stream)
    }

    /// The shortest time in s after the step at which the arm can reach the first point.
    fn soonest_s(&self) -> Option<f64> {
        /// Longest delay that is tried, in ms.
        const LONGEST_MS: u64 = 10_000;
        let is_reached = |delay_ms: u64| {
            let first = Self {
                points: self.points.get(..1).unwrap_or_default(),
                ..*self
            };
            first.check(delay_ms * 1_000).is_ok()
        };
        let delay_ms = (1..=LONGEST_MS).find(|delay_ms| is_reached(*delay_ms))?;
        let first = self.points.first()?;
        Some((first.after_us + delay_ms * 1_000) as f64 * 1e-6)
    }

    /// The mistake of a point that the board would refuse.
    pub(super) fn mistake(&self, place: &KeyPath, number: usize, error: &StreamError) -> Mistake {
        let point = place.nth(number);
        let soonest = || {
            let soonest_s = self.soonest_s().filter(|_| number == 0);
            soonest_s.map_or_else(String::new, |soonest_s| {
                format!(
                    "; the arm can be there {soonest_s:.3} s after the step: give this point an \
                     `after_s` of {soonest_s:.3} or more, and move the others with it"
                )
            })
        };
        match error {
            StreamError::Start(error) => mistake(place, error),
            StreamError::Point(stream::Error::NotFinite) => {
                Mistake::new(point, "a number in it is not finite")
            }
            StreamError::Point(stream::Error::Full) => {
                Mistake::new(point, "too many points at once")
            }
            StreamError::Point(stream::Error::Late { by_us }) => {
                let by_ms = *by_us as f64 * 1e-3;
                let message = if number == 0 {
                    format!(
                        "the point is {by_ms:.1} ms too soon after the step: the board has it one \
                         period and 2 ms later, and a point is 1 ms ahead{}",
                        soonest()
                    )
                } else {
                    format!(
                        "the point is {by_ms:.1} ms too soon after the one before it: the least \
                         distance is 1 ms"
                    )
                };
                Mistake::new(point.at("after_s"), message)
            }
            StreamError::Point(stream::Error::Exceeds(peak)) => {
                let message = format!(
                    "on the way to this point, or to rest after it, {}{}",
                    peak_text(peak),
                    soonest()
                );
                Mistake::new(point, message)
            }
        }
    }
}

/// Reason for which the board would refuse a stream.
pub(super) enum StreamError {
    Start(Error<f32>),
    Point(stream::Error<f32>),
}

impl From<Error<f32>> for StreamError {
    fn from(error: Error<f32>) -> Self {
        Self::Start(error)
    }
}

impl From<stream::Error<f32>> for StreamError {
    fn from(error: stream::Error<f32>) -> Self {
        Self::Point(error)
    }
}
