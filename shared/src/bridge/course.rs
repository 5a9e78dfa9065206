//! What the arm shall do, tick by tick.
//!
//! A motion is planned on the link's side, which takes milliseconds, from the
//! reference that will be in force when it begins; until then the course before
//! it goes on. So the two join without a step, however long planning takes, or
//! the motion is refused for being late.

use super::limits::MOTION;
use crate::control::Reference;
use crate::control::trajectory::stream::{self, Point, Stream};
use crate::control::trajectory::{self, Trajectory};
use crate::link::message::Refusal;
use nalgebra::Vector2;

/// Time in µs from asking for a motion to its beginning: for planning, in thread
/// mode, below a tick that leaves it some 40 % of each period.
const LEAD_US: u64 = 50_000;

/// How far from this course a motion may begin, in rad: ten counts, for an arm
/// whose motors are off is where its noisy encoders say.
const GAP_MAX_RAD: f32 = 0.05;

/// Where a motion is to begin.
#[derive(Clone, Copy, Debug)]
pub(super) struct Departure {
    /// What is asked of the arm then.
    pub(super) from: Reference<f32>,
    /// In µs.
    pub(super) at_us: u64,
}

/// A motion that is planned.
#[derive(Clone, Debug)]
pub(super) struct Leg {
    pub(super) trajectory: Trajectory<f32>,
    pub(super) starts_us: u64,
}

/// The reference and where it comes from.
#[derive(Clone, Debug)]
pub(super) struct Course {
    way: Way,
    /// The motion to change to when its time comes.
    then: Option<Leg>,
}

#[derive(Clone, Debug)]
enum Way {
    Planned(Leg),
    Streamed(Stream<f32>),
}

impl Leg {
    fn at(&self, at_us: u64) -> Reference<f32> {
        let elapsed_us = at_us.saturating_sub(self.starts_us);
        // Motions end within ten minutes: 32 bits of µs.
        let elapsed_us = u32::try_from(elapsed_us).unwrap_or(u32::MAX);
        self.trajectory.at(elapsed_us as f32 * 1e-6)
    }
}

impl Course {
    /// Rest at these angles.
    pub(super) fn hold(q: Vector2<f32>) -> Self {
        Self {
            way: Way::Planned(Leg {
                trajectory: Trajectory::hold(q),
                starts_us: 0,
            }),
            then: None,
        }
    }

    /// What is asked of the arm at a time that never goes back.
    pub(super) fn at(&mut self, at_us: u64) -> Reference<f32> {
        if let Some(leg) = self.then.take_if(|leg| leg.starts_us <= at_us) {
            self.way = Way::Planned(leg);
        }
        match &mut self.way {
            Way::Planned(leg) => leg.at(at_us),
            Way::Streamed(stream) => stream.advance(at_us),
        }
    }

    /// Where a motion that is asked for now would begin.
    pub(super) fn departure(&self, now_us: u64) -> Departure {
        let at_us = now_us + LEAD_US;
        // A stream may change until then: the motion begins from its braking.
        let from = self.clone().at(at_us);
        Departure { from, at_us }
    }

    /// Changes to a motion when its time comes.
    ///
    /// # Errors
    /// [`Refusal::Busy`] if that has passed, or if the motion would begin
    /// elsewhere than this course will be: it is to be planned again.
    pub(super) fn change_to(&mut self, leg: Leg, now_us: u64) -> Result<(), Refusal> {
        let apart = self.clone().at(leg.starts_us).q - leg.at(leg.starts_us).q;
        if leg.starts_us <= now_us || apart.amax() > GAP_MAX_RAD {
            return Err(Refusal::Busy);
        }
        self.then = Some(leg);
        Ok(())
    }

    /// Comes to rest as soon as the bounds allow, and stays there.
    pub(super) fn brake(&mut self, at_us: u64) {
        *self = Self::braking(&self.at(at_us), at_us);
    }

    /// From this reference to rest, as soon as the bounds allow.
    pub(super) fn braking(from: &Reference<f32>, at_us: u64) -> Self {
        match Stream::new(from, at_us, &MOTION) {
            Ok(stream) => Self {
                way: Way::Streamed(stream),
                then: None,
            },
            // From beyond the bounds, where no course leads: at once.
            Err(_) => Self::hold(from.q),
        }
    }

    /// Where it leads, if nothing else is asked for, in rad.
    pub(super) fn end(&self) -> Vector2<f32> {
        self.clone().at(u64::MAX).q
    }

    /// Takes a streamed point, and leaves whatever motion there was for it.
    pub(super) fn push(&mut self, now_us: u64, point: Point<f32>) -> Result<(), Refusal> {
        if let Way::Streamed(stream) = &mut self.way {
            if self.then.is_some() {
                return Err(Refusal::Busy);
            }
            return stream
                .push(now_us, point)
                .map_err(|error| stream_refusal(&error));
        }
        let from = self.at(now_us);
        let mut stream = Stream::new(&from, now_us, &MOTION).map_err(|error| refusal(&error))?;
        stream
            .push(now_us, point)
            .map_err(|error| stream_refusal(&error))?;
        *self = Self {
            way: Way::Streamed(stream),
            then: None,
        };
        Ok(())
    }
}

/// What the host is told of a motion that cannot be.
pub(super) fn refusal(error: &trajectory::Error<f32>) -> Refusal {
    match error {
        trajectory::Error::Exceeds(peak) | trajectory::Error::NoDuration(peak) => Refusal::Beyond {
            joint: peak.joint as u8,
            quantity: peak.quantity,
            value: peak.value,
        },
        _ => Refusal::OutOfRange,
    }
}

fn stream_refusal(error: &stream::Error<f32>) -> Refusal {
    match *error {
        stream::Error::NotFinite => Refusal::OutOfRange,
        stream::Error::Late | stream::Error::Order => Refusal::Late,
        stream::Error::Full => Refusal::Busy,
        stream::Error::Exceeds {
            joint,
            quantity,
            value,
        } => Refusal::Beyond {
            joint: joint as u8,
            quantity,
            value,
        },
    }
}
