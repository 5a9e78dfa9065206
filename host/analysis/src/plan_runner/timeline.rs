//! Timeline of a run: the next step and the next point of a stream.

use super::plan::{Action, Point, STREAM_AHEAD, Step};

/// The item of the timeline that is due.
#[derive(Debug)]
pub(super) enum Due {
    /// Action of a step.
    Step(Action),
    /// Point of a stream, and the stream's start in µs since the run began.
    Point(Point, u64),
}

/// Position of a run on its timeline.
#[derive(Debug)]
pub(super) struct Timeline {
    pub(super) since_us: u64,
    next: usize,
    stream: Option<ActiveStream>,
}

#[derive(Debug)]
struct ActiveStream {
    points: Vec<Point>,
    next: usize,
    begun_us: u64,
}

impl ActiveStream {
    /// Time at which the board's buffer has room for the next point, in µs since the run
    /// began.
    fn due_us(&self) -> Option<u64> {
        self.points.get(self.next)?;
        let room = self
            .next
            .checked_sub(STREAM_AHEAD)
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

    /// Time of the next item in µs since the run began.
    pub(super) fn due_us(&self, steps: &[Step]) -> Option<u64> {
        let step_us = steps.get(self.next).map(|step| step.at_us);
        let point_us = self.stream.as_ref().and_then(ActiveStream::due_us);
        step_us.into_iter().chain(point_us).min()
    }

    /// Removes and returns the next item that is due `elapsed_us` after the beginning.
    pub(super) fn take(&mut self, elapsed_us: u64, steps: &[Step]) -> Option<Due> {
        if let Some(step) = steps.get(self.next)
            && elapsed_us >= step.at_us
        {
            self.next += 1;
            // The next action that drives the arm ends the stream.
            match &step.action {
                Action::Change(_) => {}
                Action::Stream(points) => {
                    self.stream = Some(ActiveStream {
                        points: points.clone(),
                        next: 0,
                        begun_us: step.at_us,
                    });
                    return self.take(elapsed_us, steps);
                }
                Action::Arm | Action::Command(_) => self.stream = None,
            }
            return Some(Due::Step(step.action.clone()));
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
