//! Reference source: angles, speeds and accelerations for the arm in each tick.
//!
//! A motion is planned on the link's side, which takes milliseconds, from the
//! reference that will be in force when it begins; until then the previous source
//! continues. The two join without a step, however long planning takes, or
//! the motion is refused as late.
//!
//! The numbers of the source lie under a [`CheckWord`], which every tick compares before
//! the arm follows them, and which is updated only if it was right before.

use super::limits::MOTION;
use super::lowering::Lowering;
use armbridge_control::check_word::{CheckWord, Checked, checked};
use armbridge_control::trajectory::stream::{self, Phase, Point, Stream};
use armbridge_control::trajectory::{self, Peak, Reference, Trajectory};
use armbridge_link::message::Refusal;
use nalgebra::Vector2;

/// Time in µs from the request of a motion to its beginning: for planning, in thread
/// mode, which has some 40 % of each period beside the tick.
pub const LEAD_US: u64 = 50_000;

/// Largest distance from this reference at which a motion may begin, in rad: ten counts,
/// because the angle of an arm whose motors are off has the noise of its encoders.
const GAP_MAX_RAD: f32 = 0.05;

/// Start point of a motion.
#[derive(Clone, Copy, Debug)]
#[cfg_attr(feature = "snapshot", derive(serde::Serialize, serde::Deserialize))]
pub struct StartPoint {
    /// Reference at that time.
    pub from: Reference<f32>,
    /// Time in µs.
    pub at_us: u64,
}

/// A planned motion, with its start time.
#[derive(Clone, Debug)]
#[cfg_attr(feature = "snapshot", derive(serde::Serialize, serde::Deserialize))]
pub struct TimedTrajectory {
    /// The motion.
    pub trajectory: Trajectory<f32>,
    /// Start time, in µs.
    pub starts_us: u64,
}

/// Source of the reference. Its numbers lie under a [`CheckWord`].
#[derive(Clone, Debug)]
#[cfg_attr(feature = "snapshot", derive(serde::Serialize, serde::Deserialize))]
pub struct ReferenceSource {
    plan: Plan,
    check: CheckWord,
}

#[derive(Clone, Debug)]
#[cfg_attr(feature = "snapshot", derive(serde::Serialize, serde::Deserialize))]
struct Plan {
    source: Source,
    /// The motion that replaces the source at its start time.
    next: Option<TimedTrajectory>,
}

#[derive(Clone, Debug)]
#[cfg_attr(feature = "snapshot", derive(serde::Serialize, serde::Deserialize))]
enum Source {
    /// Rest at these angles.
    Setpoint(Vector2<f32>),
    Planned(TimedTrajectory),
    Streamed(Stream<f32>),
    Lowered(Lowering),
}

checked!(TimedTrajectory {
    trajectory,
    starts_us
});
checked!(Plan { source, next });

impl Checked for Source {
    fn check(&self, sum: &mut CheckWord) {
        match self {
            Self::Setpoint(q) => {
                sum.word(0);
                q.check(sum);
            }
            Self::Planned(motion) => {
                sum.word(1);
                motion.check(sum);
            }
            Self::Streamed(stream) => {
                sum.word(2);
                stream.check(sum);
            }
            Self::Lowered(lowering) => {
                sum.word(3);
                lowering.check(sum);
            }
        }
    }
}

impl TimedTrajectory {
    fn at(&self, at_us: u64) -> Reference<f32> {
        let elapsed_us = at_us.saturating_sub(self.starts_us);
        // Motions end within ten minutes: 32 bits of µs.
        let elapsed_us = u32::try_from(elapsed_us).unwrap_or(u32::MAX);
        self.trajectory.at(elapsed_us as f32 * 1e-6)
    }
}

impl ReferenceSource {
    fn new(source: Source) -> Self {
        let plan = Plan { source, next: None };
        let check = plan.check_word();
        Self { plan, check }
    }

    /// A source of rest at these angles.
    pub fn hold(q: Vector2<f32>) -> Self {
        Self::new(Source::Setpoint(q))
    }

    /// A source that brakes from this reference to rest, as soon as the bounds allow.
    pub fn braking(from: &Reference<f32>, at_us: u64) -> Self {
        match Stream::new(from, at_us, &MOTION) {
            Ok(stream) => Self::new(Source::Streamed(stream)),
            // From beyond the bounds no bounded motion exists: rest at once.
            Err(_) => Self::hold(from.q),
        }
    }

    /// A source that lowers a joint.
    pub(super) fn lowering(lowering: Lowering) -> Self {
        Self::new(Source::Lowered(lowering))
    }

    /// The joint that this source lowers, if it does.
    pub(super) fn lowered_joint(&self) -> Option<usize> {
        match &self.plan.source {
            Source::Lowered(lowering) => Some(lowering.joint()),
            Source::Setpoint(_) | Source::Planned(_) | Source::Streamed(_) => None,
        }
    }

    /// Whether the reference rests from this time on, if nothing else is requested.
    pub(super) fn is_at_rest(&mut self, at_us: u64) -> bool {
        let _ = self.at(at_us);
        self.plan.next.is_none()
            && match &self.plan.source {
                Source::Setpoint(_) => true,
                Source::Streamed(stream) => stream.phase() == Phase::Resting,
                Source::Planned(_) | Source::Lowered(_) => false,
            }
    }

    /// Whether the numbers are those that were planned.
    pub fn is_intact(&self) -> bool {
        self.plan.check_word() == self.check
    }

    /// Updates plan and check word; a corruption before it remains detected.
    fn update<R>(&mut self, edit: impl FnOnce(&mut Plan) -> R) -> R {
        let was_intact = self.is_intact();
        let result = edit(&mut self.plan);
        if was_intact {
            self.check = self.plan.check_word();
        }
        result
    }

    /// The reference at a time that never goes back.
    pub fn at(&mut self, at_us: u64) -> Reference<f32> {
        if self.plan.is_to_change(at_us) {
            self.update(|plan| plan.advance(at_us));
        }
        self.plan.at(at_us)
    }

    /// The reference at a time to come, if nothing else is requested until then.
    pub fn ahead(&self, at_us: u64) -> Reference<f32> {
        match (&self.plan.next, &self.plan.source) {
            (Some(motion), _) if motion.starts_us <= at_us => motion.at(at_us),
            (_, Source::Streamed(stream)) => stream.clone().advance(at_us),
            (_, Source::Setpoint(_) | Source::Planned(_) | Source::Lowered(_)) => {
                self.plan.at(at_us)
            }
        }
    }

    /// Replaces the source.
    pub fn replace(&mut self, source: &Self) {
        self.update(|plan| plan.clone_from(&source.plan));
    }

    /// Schedules a motion that replaces the source at its start time.
    ///
    /// # Errors
    /// [`Refusal::Busy`] if that time has passed, or if the motion would begin
    /// away from this source: it must be planned again.
    pub fn change_to(&mut self, motion: &TimedTrajectory, now_us: u64) -> Result<(), Refusal> {
        let gap = self.ahead(motion.starts_us).q - motion.at(motion.starts_us).q;
        if motion.starts_us <= now_us || gap.amax() > GAP_MAX_RAD {
            return Err(Refusal::Busy);
        }
        self.update(|plan| plan.next = Some(motion.clone()));
        Ok(())
    }

    /// Brakes the reference to rest as soon as the bounds allow.
    pub fn brake(&mut self, at_us: u64) {
        let source = Self::braking(&self.ahead(at_us), at_us);
        self.replace(&source);
    }

    /// Whether the host streams the reference.
    pub fn is_streamed(&self) -> bool {
        matches!(self.plan.source, Source::Streamed(_))
    }

    /// Final angles of the present source, in rad.
    pub fn end(&self) -> Vector2<f32> {
        self.ahead(u64::MAX).q
    }

    /// Takes a streamed point; a stream replaces any motion. The next reference is that at
    /// `acts_us`.
    ///
    /// # Errors
    /// The reason for the refusal of the point.
    pub fn push(&mut self, acts_us: u64, point: Point<f32>) -> Result<(), Refusal> {
        self.update(|plan| plan.push(acts_us, point))
    }

    /// Turns a bit of a number, chosen by `draw`: for tests.
    pub fn inject_error(&mut self, draw: u32) {
        let bit = draw % u32::BITS;
        match &mut self.plan.source {
            Source::Setpoint(q) => q.x = f32::from_bits(q.x.to_bits() ^ 1 << bit),
            Source::Planned(motion) => motion.starts_us ^= 1 << bit,
            Source::Streamed(stream) => stream.inject_error(bit),
            Source::Lowered(lowering) => lowering.inject_error(bit),
        }
    }
}

impl Plan {
    // One copy: long for a motion, short for a setpoint.
    #[inline(never)]
    fn check_word(&self) -> CheckWord {
        CheckWord::compute(self)
    }

    /// Whether another motion, or another segment of the stream, begins until this time.
    fn is_to_change(&self, at_us: u64) -> bool {
        let is_due = |motion: &TimedTrajectory| motion.starts_us <= at_us;
        self.next.as_ref().is_some_and(is_due)
            || matches!(&self.source, Source::Streamed(stream) if stream.is_to_change(at_us))
    }

    fn advance(&mut self, at_us: u64) {
        if let Some(motion) = self.next.take_if(|motion| motion.starts_us <= at_us) {
            self.source = Source::Planned(motion);
        }
        if let Source::Streamed(stream) = &mut self.source {
            stream.advance(at_us);
        }
    }

    fn at(&self, at_us: u64) -> Reference<f32> {
        match &self.source {
            Source::Setpoint(q) => Reference::at_rest(*q),
            Source::Planned(motion) => motion.at(at_us),
            Source::Streamed(stream) => stream.at(at_us),
            Source::Lowered(lowering) => lowering.at(at_us),
        }
    }

    fn push(&mut self, acts_us: u64, point: Point<f32>) -> Result<(), Refusal> {
        let push = |stream: &mut Stream<f32>| {
            let pushed = stream.push(acts_us, point);
            pushed.map_err(|error| stream_refusal(&error))
        };
        match &mut self.source {
            Source::Streamed(_) if self.next.is_some() => Err(Refusal::Busy),
            Source::Streamed(stream) => push(stream),
            Source::Setpoint(_) | Source::Planned(_) | Source::Lowered(_) => {
                self.advance(acts_us);
                let from = self.at(acts_us);
                let mut stream =
                    Stream::new(&from, acts_us, &MOTION).map_err(|error| refusal(&error))?;
                push(&mut stream)?;
                self.source = Source::Streamed(stream);
                self.next = None;
                Ok(())
            }
        }
    }
}

/// The refusal of a motion for this planning error.
pub fn refusal(error: &trajectory::Error<f32>) -> Refusal {
    match error {
        trajectory::Error::Exceeds(peak) | trajectory::Error::NoDuration(peak) => beyond(peak),
        _ => Refusal::OutOfRange,
    }
}

fn beyond(peak: &Peak<f32>) -> Refusal {
    Refusal::Beyond {
        joint: peak.joint as u8,
        quantity: peak.quantity,
        value: peak.value,
        limit: peak.limit,
    }
}

fn stream_refusal(error: &stream::Error<f32>) -> Refusal {
    match error {
        stream::Error::NotFinite => Refusal::OutOfRange,
        stream::Error::Late { by_us } => Refusal::Late {
            by_us: u32::try_from(*by_us).unwrap_or(u32::MAX),
        },
        stream::Error::Full => Refusal::Busy,
        stream::Error::Exceeds(peak) => beyond(peak),
    }
}
