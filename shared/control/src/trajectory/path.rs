//! Quintics one after another, then rest.

use super::bounds::{PeakTracker, Quantity};
use super::quintic::Quintic;
use super::waypoints::{self, Knot, Knots};
use super::{DURATION_MAX_S, DURATION_MIN_S, Error, WAYPOINTS_MAX, Waypoint};
use crate::check_word::checked;
use crate::real::Real;
use crate::trajectory::Reference;
use heapless::Vec;
use nalgebra::Vector2;

/// One quintic and when it begins.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "snapshot", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "snapshot", serde(bound = "T: crate::snapshot::Number"))]
struct Piece<T> {
    starts_s: T,
    quintic: Quintic<T>,
}

checked!(Piece<T> { starts_s, quintic });

/// All of them.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "snapshot", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "snapshot", serde(bound = "T: crate::snapshot::Number"))]
pub(super) struct Path<T> {
    pieces: Vec<Piece<T>, WAYPOINTS_MAX>,
    ends_s: T,
    rests_at: Vector2<T>,
}

checked!(Path<T> { pieces, ends_s, rests_at });

impl<T: Real> Path<T> {
    /// Rest from the start.
    pub(super) fn resting(q: Vector2<T>) -> Self {
        Self {
            pieces: Vec::new(),
            ends_s: T::zero(),
            rests_at: q,
        }
    }

    /// With least jerk to rest at `to`.
    pub(super) fn straight(from: &Reference<T>, to: Vector2<T>, duration_s: T) -> Self {
        let quintic = Quintic::joining(from, &Reference::at_rest(to), duration_s);
        let starts_s = T::zero();
        Self {
            pieces: Vec::from_iter([Piece { starts_s, quintic }]),
            ends_s: duration_s,
            rests_at: to,
        }
    }

    /// With least jerk through waypoints to rest at the last.
    pub(super) fn through(from: &Reference<T>, points: &[Waypoint<T>]) -> Result<Self, Error<T>> {
        let &[.., Waypoint { at_s: ends_s, q }] = points else {
            return Err(Error::NoWaypoints);
        };
        let mut at_s = T::zero();
        let mut knots: Knots<T> = Vec::new();
        let mut keep = |at_s, reference| {
            // There is room for the start and as many knots as waypoints.
            let _ = knots.push(Knot { at_s, reference });
        };
        keep(at_s, *from);
        for (waypoint, point) in points.iter().enumerate() {
            let way_s = point.at_s - at_s;
            if way_s < T::lit(DURATION_MIN_S) || point.at_s > T::lit(DURATION_MAX_S) {
                return Err(Error::WaypointTime { waypoint });
            }
            at_s = point.at_s;
            keep(at_s, Reference::at_rest(point.q));
        }
        waypoints::smooth(&mut knots).ok_or(Error::Uneven)?;
        let mut pieces = Vec::new();
        for two in knots.windows(2) {
            let [from, to] = two else { continue };
            // A way less than knots: there is room.
            let _ = pieces.push(Piece {
                starts_s: from.at_s,
                quintic: Quintic::joining(&from.reference, &to.reference, to.at_s - from.at_s),
            });
        }
        Ok(Self {
            pieces,
            ends_s,
            rests_at: q,
        })
    }

    /// When rest begins, in s.
    pub(super) fn ends_s(&self) -> T {
        self.ends_s
    }

    /// Where it rests in the end, in rad.
    pub(super) fn rests_at(&self) -> Vector2<T> {
        self.rests_at
    }

    /// The reference at `t_s >= 0`.
    pub(super) fn at(&self, t_s: T) -> Reference<T> {
        let piece = self.pieces.iter().rev().find(|p| p.starts_s <= t_s);
        match piece {
            Some(piece) if t_s < self.ends_s => piece.quintic.at(t_s - piece.starts_s),
            _ => Reference::at_rest(self.rests_at),
        }
    }

    /// Shows `tightest` the extremes of all of it.
    pub(super) fn show(&self, tightest: &mut PeakTracker<T>) {
        for (joint, &q) in self.rests_at.iter().enumerate() {
            tightest.see(joint, Quantity::Angle, q, self.ends_s);
        }
        let ends = self.pieces.iter().skip(1).map(|next| next.starts_s);
        let pieces = self.pieces.iter().zip(ends.chain([self.ends_s]));
        for (piece, ends_s) in pieces {
            let starts_s = piece.starts_s;
            piece.quintic.show(starts_s, ends_s - starts_s, tightest);
        }
    }
}
