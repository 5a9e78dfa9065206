//! References that a host sends while the arm moves.
//!
//! The host sends [`Point`]s ahead of time, each with the time of the board's clock
//! at which it holds; [`Stream`] keeps up to [`POINTS_MAX`] of them and, tick by tick,
//! computes a [`Reference`] from them. Jitter of network and host has no effect as
//! long as points come before their time.
//!
//! # Between points
//!
//! A quintic leads from point to point, so angle, speed and acceleration are continuous
//! whatever the host sends. The speed at a point is the one sent with it. Where none was
//! sent, and for the acceleration always, it is that of the parabola through this point
//! and its two neighbours; the first has the slope to the next. So each point revises the one
//! before it, unless that would lead beyond a bound. A point without a successor is approached without acceleration, and
//! to rest if no speed was sent with it; where the bounds do not permit that, it is
//! passed, and braked after.
//!
//! # Starvation
//!
//! With no points left the reference brakes to rest within the bounds on acceleration and
//! jerk, and stays there until points come again.
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
//! At each time the points that a stream has lead to rest within all bounds, should no
//! other come. A point with which they would not is refused, with the value that would
//! exceed a bound, and those before it stay. So the reference is within the bounds on
//! angle, speed and acceleration always, and within that on jerk where the stream
//! begins, where it is revised under way, and where it comes to rest.
//!
//! A point costs some thousand instructions when it is taken, the change to the next way
//! some hundred.

mod way;

pub use self::way::Point;
use self::way::{Knot, Way};
use super::bounds::{Bounds, Peak};
use super::range::check_start;
use crate::check_word::{CheckWord, Checked, checked};
use crate::real::Real;
use crate::trajectory::Reference;
use heapless::Deque;
use nalgebra::{ComplexField, Vector2};

/// Number of points kept: at 50 Hz, 160 ms of silence of the network.
pub const POINTS_MAX: usize = 8;
/// Least time from one point to the next, and to the first: a tick.
pub const SPACING_MIN_US: u64 = 1000;

/// Reason for which a point is refused; those before it stay.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Error<T> {
    /// An angle or speed is not finite.
    NotFinite,
    /// It is less than [`SPACING_MIN_US`] after the point before, or after the present.
    Late {
        /// Time in µs by which it would have to be later.
        by_us: u64,
    },
    /// There are [`POINTS_MAX`] already.
    Full,
    /// The way to it, or to rest after it, would exceed a bound; times count from the
    /// beginning of that way.
    Exceeds(Peak<T>),
}

/// Phase of a stream.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "snapshot", derive(serde::Serialize, serde::Deserialize))]
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
#[cfg_attr(feature = "snapshot", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "snapshot", serde(bound = "T: crate::snapshot::Number"))]
pub struct Stream<T> {
    bounds: Bounds<T>,
    knots: Deque<Knot<T>, POINTS_MAX>,
    phase: Phase,
    /// To the first knot, to rest, or at rest.
    way: Way<T>,
    /// The knot that the way to the first comes from, if it comes from one.
    passed: Option<Knot<T>>,
}

checked!(Stream<T> { bounds, knots, phase, way, passed });

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
            knots: Deque::new(),
            phase: Phase::Resting,
            way: Way::resting(from.q, now_us),
            passed: None,
        };
        if *from != Reference::at_rest(from.q) {
            stream.brake(&Knot {
                at_us: now_us,
                reference: *from,
                has_speed: true,
            });
        }
        Ok(stream)
    }

    /// Phase at the last [`advance`](Self::advance).
    pub fn phase(&self) -> Phase {
        self.phase
    }

    /// Number of points to come.
    pub fn points(&self) -> usize {
        self.knots.len()
    }

    /// Takes a point that is still to come; `now_us` is the time of the next reference.
    ///
    /// # Errors
    ///
    /// See [`Error`].
    pub fn push(&mut self, now_us: u64, point: Point<T>) -> Result<(), Error<T>> {
        let finite = |v: &Vector2<T>| v.iter().all(ComplexField::is_finite);
        if !finite(&point.q) || !point.dq.as_ref().is_none_or(finite) {
            return Err(Error::NotFinite);
        }
        self.advance(now_us);
        let last = self.knots.back().copied();
        let before_us = last.map_or(now_us, |last| last.at_us);
        let by_us = before_us
            .saturating_add(SPACING_MIN_US)
            .saturating_sub(point.at_us);
        if by_us > 0 {
            return Err(Error::Late { by_us });
        }
        if self.knots.is_full() {
            return Err(Error::Full);
        }
        let here = Knot {
            at_us: now_us,
            reference: self.at(now_us),
            has_speed: true,
        };
        let Some(last) = last else {
            let knot = self
                .last_knot(&here, &point, true)
                .map_err(Error::Exceeds)?;
            self.follow(Way::between(&here, &knot));
            return self.knots.push_back(knot).map_err(|_| Error::Full);
        };
        let knot = match self.revised(&here, &last, &point) {
            Some((smooth, knot)) => {
                if self.knots.len() == 1 {
                    self.follow(Way::between(&here, &smooth));
                }
                if let Some(last) = self.knots.back_mut() {
                    *last = smooth;
                }
                knot
            }
            None => self
                .last_knot(&last, &point, false)
                .map_err(Error::Exceeds)?,
        };
        self.knots.push_back(knot).map_err(|_| Error::Full)
    }

    /// Whether [`advance`](Self::advance) goes over to another way at this time.
    pub fn is_to_change(&self, now_us: u64) -> bool {
        self.phase != Phase::Resting && now_us >= self.way.ends_us
    }

    /// One tick: the reference at `now_us`, which never goes back.
    pub fn advance(&mut self, now_us: u64) -> Reference<T> {
        // Each turn takes a point or a phase, so there are few.
        while self.is_to_change(now_us) {
            let reached = self.knots.pop_front();
            match (reached, self.knots.front()) {
                (Some(reached), Some(next)) => {
                    let way = Way::between(&reached, next);
                    self.follow(way);
                    self.passed = Some(reached);
                }
                (Some(reached), None) => self.brake(&reached),
                (None, _) => {
                    let then_us = self.way.ends_us;
                    self.phase = Phase::Resting;
                    self.way = Way::resting(self.at(then_us).q, then_us);
                }
            }
        }
        self.at(now_us)
    }

    /// The reference at a time until which the stream does not
    /// [change](Self::is_to_change).
    pub fn at(&self, now_us: u64) -> Reference<T> {
        self.way.at(now_us)
    }

    /// The last knot smoothed by its successor, and that, if the bounds permit both.
    fn revised(
        &self,
        here: &Knot<T>,
        last: &Knot<T>,
        point: &Point<T>,
    ) -> Option<(Knot<T>, Knot<T>)> {
        // The way to the first knot is under way.
        let is_first = self.knots.len() == 1;
        let before = self.knots.iter().rev().nth(1);
        let smooth = last.smoothed(before.or(self.passed.as_ref()), point);
        let from = before.unwrap_or(here);
        if last.at_us.saturating_sub(from.at_us) < SPACING_MIN_US {
            return None;
        }
        let way = Way::between(from, &smooth);
        way.check(&self.bounds, is_first).ok()?;
        let knot = self.last_knot(&smooth, point, false).ok()?;
        Some((smooth, knot))
    }

    /// The knot at a point without a successor: the way there and to rest is within the
    /// bounds.
    ///
    /// # Errors
    ///
    /// The quantity that exceeds a bound if the point is passed.
    fn last_knot(
        &self,
        from: &Knot<T>,
        point: &Point<T>,
        is_joining: bool,
    ) -> Result<Knot<T>, Peak<T>> {
        let permitted = |knot: Knot<T>, with_jerk| {
            Way::between(from, &knot).check(&self.bounds, with_jerk)?;
            let (brake, is_within) = Way::braking(&knot, &self.bounds);
            is_within?;
            brake.check(&self.bounds, false)?;
            Ok(knot)
        };
        let [gentle, passed] = Knot::last(point, from);
        permitted(gentle, true).or_else(|_| permitted(passed, is_joining))
    }

    fn follow(&mut self, way: Way<T>) {
        self.phase = Phase::Following;
        self.way = way;
    }

    /// Comes to rest.
    fn brake(&mut self, from: &Knot<T>) {
        self.phase = Phase::Braking;
        self.passed = None;
        self.way = Way::braking(from, &self.bounds).0;
    }

    /// Flips a bit of the segment's start time, for tests of error detection.
    pub fn inject_error(&mut self, bit: u32) {
        self.way.inject_error(bit);
    }
}
