//! Hands on a simulated arm, by keys of the dashboard.

use armbridge_link::server::Touch;

/// A push by a key, which a standing arm takes without falling.
const PUSH_NM: f32 = 0.3;
const PUSH_US: u32 = 200_000;

/// A hand on a simulated arm.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Hand {
    /// Brings it back to where it began, and holds it until a motor drives it.
    Lift,
    /// Pushes this joint, 0.3 N m for 0.2 s.
    Push(u8),
}

impl From<Hand> for Touch {
    fn from(hand: Hand) -> Self {
        match hand {
            Hand::Lift => Self::Lift,
            Hand::Push(joint) => Self::Push {
                joint,
                torque_nm: PUSH_NM,
                duration_us: PUSH_US,
            },
        }
    }
}
