//! References that a host sends while the arm moves.
//!
//! The host sends [`Point`]s ahead of time, each with the time of the board's clock
//! at which it holds; [`Stream`] keeps up to [`POINTS_MAX`] of them and, tick by tick,
//! makes a [`Reference`] of what it has. Network and host may be as uneven as they
//! like as long as points come before their time.
//!
//! # Between points
//!
//! A quintic leads from where the reference is to the next point, so angle, speed and
//! acceleration are continuous whatever the host sends. The speed at a point is the
//! one sent with it. Where none was sent, and for the acceleration always, it is that
//! of the parabola through this point and its two neighbours, so the *next but one*
//! must have arrived when the way to a point begins: a host should stay at least two
//! points ahead. A point without a successor and without a speed is taken for the
//! last, and approached to rest.
//!
//! # Starvation
//!
//! With no points left the reference brakes to rest, at no more than the bound on
//! acceleration, and stays there until points come again. Should braking lead past
//! the bound on angles, it ends there, by braking harder.
//!
//! ```text
//!             first point            none left                 at rest
//!  Resting ---------------> Following ---------> Braking ----------------> Resting
//!                               ^                   |
//!                               '---- next point ---'
//! ```
//!
//! # Bounds
//!
//! A point is refused beyond the bounds on angle and speed, and if the straight way
//! from the point before would exceed that on speed. Accelerations from point to
//! point are the host's business: they follow from how smooth its points are. The
//! way to the first point, though, after rest or braking, depends on how far ahead it
//! is, and is checked exactly: a point that cannot be reached within all bounds is
//! [skipped](Stream::skipped), one a tick, for the next may be far enough ahead. That
//! check is dear, some ten thousand instructions, and made only then.

use super::bounds::{Bounds, PeakTracker, Quantity};
use super::quintic::Quintic;
use super::range::check_start;
use crate::check_word::{CheckWord, Checked, checked};
use crate::control::Reference;
use crate::real::Real;
use heapless::Deque;
use nalgebra::{ComplexField, Vector2};

/// How many points are kept. At 50 Hz this is 160 ms for the network to be silent.
pub const POINTS_MAX: usize = 8;
/// Least time from one point to the next, and to the first: a tick.
pub const SPACING_MIN_US: u64 = 1000;

/// Where the arm shall be at a time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Point<T> {
    /// Of the board's clock.
    pub at_us: u64,
    /// In rad.
    pub q: Vector2<T>,
    /// In rad/s; `None` to have it made of the neighbours.
    pub dq: Option<Vector2<T>>,
}

/// Why a point is refused; those before it stay. Joints count from 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Error<T> {
    /// An angle or speed is not finite.
    NotFinite,
    /// Its time has passed, or is less than [`SPACING_MIN_US`] ahead.
    Late,
    /// It is less than [`SPACING_MIN_US`] after the point before.
    Order,
    /// There are [`POINTS_MAX`] already.
    Full,
    /// An angle or speed, or the speed from the point before, is beyond its bound.
    Exceeds {
        /// Of this joint.
        joint: usize,
        /// Angle or speed.
        quantity: Quantity,
        /// In its unit.
        value: T,
    },
}

/// What a stream is doing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Phase {
    /// On the way to a point.
    Following,
    /// Out of points, coming to rest.
    Braking,
    /// Out of points, at rest.
    Resting,
}

/// Points to come, and the way to the first of them.
#[derive(Clone, Debug)]
pub struct Stream<T> {
    bounds: Bounds<T>,
    points: Deque<Point<T>, POINTS_MAX>,
    skipped: u32,
    phase: Phase,
    way: Quintic<T>,
    starts_us: u64,
    /// Of the way; while resting it does not end.
    ends_us: u64,
}

checked!(Point<T> { at_us, q, dq });
checked!(Stream<T> { bounds, points, skipped, phase, way, starts_us, ends_us });

impl Checked for Phase {
    fn check(&self, sum: &mut CheckWord) {
        sum.word(match self {
            Self::Following => 0,
            Self::Braking => 1,
            Self::Resting => 2,
        });
    }
}

impl<T: Real> Stream<T> {
    /// An empty stream: brakes from `from`, the reference in force at `now_us`,
    /// unless points come first.
    ///
    /// # Errors
    ///
    /// [`NotFinite`](super::Error::NotFinite) and [`NoRoom`](super::Error::NoRoom).
    pub fn new(
        from: &Reference<T>,
        now_us: u64,
        bounds: &Bounds<T>,
    ) -> Result<Self, super::Error<T>> {
        check_start(from, bounds)?;
        let mut stream = Self {
            bounds: *bounds,
            points: Deque::new(),
            skipped: 0,
            phase: Phase::Resting,
            way: Quintic::resting(from.q),
            starts_us: now_us,
            ends_us: u64::MAX,
        };
        if *from != Reference::at_rest(from.q) {
            stream.brake(from, now_us);
        }
        Ok(stream)
    }

    /// What the stream was doing at the last [`advance`](Self::advance).
    pub fn phase(&self) -> Phase {
        self.phase
    }

    /// How many points there are to come.
    pub fn points(&self) -> usize {
        self.points.len()
    }

    /// How many points were too near in time to be reached within the bounds.
    pub fn skipped(&self) -> u32 {
        self.skipped
    }

    /// Takes a point that is still to come.
    ///
    /// # Errors
    ///
    /// See [`Error`].
    pub fn push(&mut self, now_us: u64, point: Point<T>) -> Result<(), Error<T>> {
        let finite = |v: &Vector2<T>| v.iter().all(ComplexField::is_finite);
        if !finite(&point.q) || !point.dq.as_ref().is_none_or(finite) {
            return Err(Error::NotFinite);
        }
        if point.at_us < now_us.saturating_add(SPACING_MIN_US) {
            return Err(Error::Late);
        }
        self.check(Quantity::Angle, point.q)?;
        self.check(Quantity::Speed, point.dq.unwrap_or_else(Vector2::zeros))?;
        if let Some(before) = self.points.back() {
            let way_us = point.at_us.saturating_sub(before.at_us);
            if way_us < SPACING_MIN_US {
                return Err(Error::Order);
            }
            let speed = (point.q - before.q) / seconds::<T>(way_us);
            self.check(Quantity::Speed, speed)?;
        }
        self.points.push_back(point).map_err(|_| Error::Full)
    }

    /// Whether [`advance`](Self::advance) goes over to another way at this time.
    pub fn is_to_change(&self, now_us: u64) -> bool {
        (self.phase != Phase::Resting && now_us >= self.ends_us)
            || (self.phase != Phase::Following && !self.points.is_empty())
    }

    /// One tick: the reference at `now_us`, which never goes back.
    pub fn advance(&mut self, now_us: u64) -> Reference<T> {
        // Each turn takes a point or a phase, so there are few.
        while self.phase != Phase::Resting && now_us >= self.ends_us {
            let (then_us, reached) = (self.ends_us, self.at(self.ends_us));
            if self.phase == Phase::Following {
                self.points.pop_front();
                match self.way_from(&reached, then_us) {
                    Some((way, ends_us)) => self.follow(way, then_us, ends_us),
                    None => self.brake(&reached, then_us),
                }
            } else {
                self.rest(reached.q, then_us);
            }
        }
        if self.phase != Phase::Following {
            self.join(now_us);
        }
        self.at(now_us)
    }

    /// The reference at a time until which the stream does not
    /// [change](Self::is_to_change).
    pub fn at(&self, now_us: u64) -> Reference<T> {
        let until_us = now_us.min(self.ends_us);
        self.way
            .at(seconds(until_us.saturating_sub(self.starts_us)))
    }

    /// Sets out for the first point from rest or braking, if the bounds permit.
    fn join(&mut self, now_us: u64) {
        let from = self.at(now_us);
        let Some((way, ends_us)) = self.way_from(&from, now_us) else {
            return;
        };
        let way_us = ends_us.saturating_sub(now_us);
        let mut tightest = PeakTracker::new(&self.bounds);
        way.show(T::zero(), seconds(way_us), &mut tightest);
        if way_us >= SPACING_MIN_US && tightest.verdict().is_ok() {
            self.follow(way, now_us, ends_us);
        } else {
            self.points.pop_front();
            self.skipped = self.skipped.saturating_add(1);
        }
    }

    /// The way to the first point, if there is one, and when it ends.
    fn way_from(&self, from: &Reference<T>, now_us: u64) -> Option<(Quintic<T>, u64)> {
        let mut points = self.points.iter();
        let next = points.next()?;
        let way_s = seconds::<T>(next.at_us.saturating_sub(now_us));
        let mut to = Reference::at_rest(next.q);
        if let Some(after) = points.next() {
            let after_s = seconds::<T>(after.at_us.saturating_sub(next.at_us));
            let (slope, slope_after) = ((next.q - from.q) / way_s, (after.q - next.q) / after_s);
            let both_s = way_s + after_s;
            to.dq = (slope * after_s + slope_after * way_s) / both_s;
            to.ddq = (slope_after - slope) * (T::lit(2.0) / both_s);
        }
        to.dq = next.dq.unwrap_or(to.dq);
        Some((Quintic::joining(from, &to, way_s), next.at_us))
    }

    fn follow(&mut self, way: Quintic<T>, starts_us: u64, ends_us: u64) {
        self.phase = Phase::Following;
        self.way = way;
        self.starts_us = starts_us;
        self.ends_us = ends_us;
    }

    /// Comes to rest with the speed falling as a cubic: its peak is
    /// `3/2 |dq| / T`, half the bound here, and with an acceleration within the
    /// bound to begin with the whole stays within.
    fn brake(&mut self, from: &Reference<T>, now_us: u64) {
        /// A rest of speed is no reason to stop within a tick, in us.
        const SHORTEST_US: u16 = 10_000;
        /// Far beyond any speed and bound that make sense, in s.
        const LONGEST_S: f64 = 10.0;

        let wanted_s = from.dq.amax() * T::lit(3.0) / self.bounds.acceleration_rad_s2;
        let wanted_s = wanted_s.min(T::lit(LONGEST_S));
        // In steps that a count can hold.
        let steps = (wanted_s * T::lit(1e6) / T::from_count(SHORTEST_US)).to_count();
        let brake_us = u64::from(SHORTEST_US) * (u64::from(steps) + 1);
        let brake_s = seconds::<T>(brake_us);
        let run =
            from.dq * (brake_s * T::lit(0.5)) + from.ddq * (brake_s * brake_s * T::lit(1.0 / 12.0));
        let limit = self.bounds.angle_rad;
        let stop = (from.q + run).map(|q| q.min(limit).max(-limit));
        self.phase = Phase::Braking;
        self.way = Quintic::joining(from, &Reference::at_rest(stop), brake_s);
        self.starts_us = now_us;
        self.ends_us = now_us.saturating_add(brake_us);
    }

    fn rest(&mut self, q: Vector2<T>, now_us: u64) {
        self.phase = Phase::Resting;
        self.way = Quintic::resting(q);
        self.starts_us = now_us;
        self.ends_us = u64::MAX;
    }

    /// Turns a bit of when the way begins: for tests of what becomes of it.
    pub fn inject_error(&mut self, bit: u32) {
        self.starts_us ^= 1 << bit;
    }

    fn check(&self, quantity: Quantity, values: Vector2<T>) -> Result<(), Error<T>> {
        let limit = self.bounds.of(quantity);
        for (joint, &value) in values.iter().enumerate() {
            if value.abs() > limit {
                return Err(Error::Exceeds {
                    joint,
                    quantity,
                    value,
                });
            }
        }
        Ok(())
    }
}

/// Microseconds in s, without the `f64` that a Cortex-M4F has not got. Saturates
/// after 71 minutes.
fn seconds<T: Real>(us: u64) -> T {
    let us = u32::try_from(us).unwrap_or(u32::MAX);
    let [high, low] = [us >> 16, us & 0xFFFF].map(|half| T::from_count(half as u16));
    (high * T::lit(65536.0) + low) * T::lit(1e-6)
}
