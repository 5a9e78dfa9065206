//! Reference of the arm at an instant.

use crate::arm::State;
use crate::check_word::checked;
use crate::real::Real;
use nalgebra::Vector2;

/// Reference angles, speeds and accelerations of both joints.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "snapshot", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "snapshot", serde(bound = "T: crate::snapshot::Number"))]
pub struct Reference<T> {
    /// Joint angles in rad; 0 is upright.
    pub q: Vector2<T>,
    /// Joint speeds in rad/s.
    pub dq: Vector2<T>,
    /// Joint accelerations in rad/s^2.
    pub ddq: Vector2<T>,
}

checked!(Reference<T> { q, dq, ddq });

impl<T: Real> Reference<T> {
    /// Rest at these angles.
    pub fn at_rest(q: Vector2<T>) -> Self {
        Self {
            q,
            dq: Vector2::zeros(),
            ddq: Vector2::zeros(),
        }
    }

    /// A reference at the present state of the arm.
    pub fn of_state(state: &State<T>) -> Self {
        Self {
            q: state.q,
            dq: state.dq,
            ddq: Vector2::zeros(),
        }
    }

    /// The angles and speeds alone.
    pub fn state(&self) -> State<T> {
        State {
            q: self.q,
            dq: self.dq,
        }
    }

    /// This reference a little later, were its acceleration to last.
    #[must_use]
    pub fn advanced(&self, by_s: T) -> Self {
        Self {
            q: self.q + (self.dq + self.ddq * (by_s * T::lit(0.5))) * by_s,
            dq: self.dq + self.ddq * by_s,
            ddq: self.ddq,
        }
    }

    /// Whether all of it is finite.
    pub fn is_finite(&self) -> bool {
        let finite = |v: &Vector2<T>| v.x.is_finite() && v.y.is_finite();
        finite(&self.q) && finite(&self.dq) && finite(&self.ddq)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn advances_at_constant_acceleration() {
        let reference = Reference {
            q: Vector2::new(1.0, -1.0),
            dq: Vector2::new(2.0, 0.5),
            ddq: Vector2::new(-4.0, 8.0),
        };
        let later = reference.advanced(0.5);
        assert_eq!(later.q, Vector2::new(1.5, 0.25));
        assert_eq!(later.dq, Vector2::new(0.0, 4.5));
        assert_eq!(later.ddq, reference.ddq);
        let state = reference.state();
        assert_eq!(Reference::of_state(&state).state(), state);
    }
}
