//! Where a run is on its timeline: which step is next, which point of a stream.

use armbridge_shared::link::message::Command;

use super::plan::{Act, Point, Step};

/// Points of a stream that are on the board ahead of time, of the eight it keeps: the
/// reference at a point is made of its neighbours, and the link may stutter.
const AHEAD: usize = 5;

/// What is to be done next.
#[derive(Debug)]
pub(super) enum Due {
    /// This.
    Step(Act),
    /// This point of a stream, which began so long after the run.
    Point(Point, u64),
}

/// A run's place on its timeline.
#[derive(Debug)]
pub(super) struct Timeline {
    pub(super) since_us: u64,
    next: usize,
    stream: Option<Streaming>,
}

#[derive(Debug)]
struct Streaming {
    points: Vec<Point>,
    next: usize,
    begun_us: u64,
}

impl Streaming {
    /// When the next point may be sent, in µs since the run began: the points before
    /// it leave room.
    fn due_us(&self) -> Option<u64> {
        self.points.get(self.next)?;
        let room = self
            .next
            .checked_sub(AHEAD)
            .and_then(|k| self.points.get(k));
        Some(self.begun_us + room.map_or(0, |point| point.after_us))
    }
}

impl Timeline {
    pub(super) fn new(since_us: u64) -> Self {
        Self {
            since_us,
            next: 0,
            stream: None,
        }
    }

    /// When something is to be done next, in µs since the run began.
    pub(super) fn due_us(&self, steps: &[Step]) -> Option<u64> {
        let step_us = steps.get(self.next).map(|step| step.at_us);
        let point_us = self.stream.as_ref().and_then(Streaming::due_us);
        step_us.into_iter().chain(point_us).min()
    }

    /// What is to be done so long after the beginning, once each.
    pub(super) fn take(&mut self, elapsed_us: u64, steps: &[Step]) -> Option<Due> {
        if let Some(step) = steps.get(self.next)
            && elapsed_us >= step.at_us
        {
            self.next += 1;
            // Whatever drives the arm from here on takes the stream's place.
            match &step.act {
                Act::Change(_) => {}
                Act::Stream(points) => {
                    self.stream = Some(Streaming {
                        points: points.clone(),
                        next: 0,
                        begun_us: step.at_us,
                    });
                    return self.take(elapsed_us, steps);
                }
                Act::Arm | Act::Tell(_) => self.stream = None,
            }
            return Some(Due::Step(step.act.clone()));
        }
        let stream = self.stream.as_mut()?;
        if stream.due_us()? > elapsed_us {
            return None;
        }
        let point = stream.points.get(stream.next)?;
        stream.next += 1;
        Some(Due::Point(*point, stream.begun_us))
    }
}

/// Board's clock less host's, in µs, by the records that come: the least delay seen
/// counts, and a drift is followed.
#[derive(Debug, Default)]
pub(super) struct Offset(Option<i64>);

impl Offset {
    pub(super) fn see(&mut self, now_us: u64, start_us: u64) {
        let seen = start_us as i64 - now_us as i64;
        let kept = self.0.get_or_insert(seen);
        // One part in 256 a tick: 50 ppm of drift lag behind by microseconds.
        *kept = seen.max(*kept - (*kept - seen) / 256);
    }

    /// The command that streams a point, for a run that began at `since_us`.
    pub(super) fn stream(&self, since_us: u64, begun_us: u64, point: &Point) -> Command {
        let at_us = since_us + begun_us + point.after_us;
        Command::Stream {
            at_us: at_us.saturating_add_signed(self.0.unwrap_or(0)),
            angle_rad: point.angle_rad,
            speed_rad_s: point.speed_rad_s,
        }
    }
}
