//! The same control for another arm.
//!
//! | controller                 | what becomes of it                                    |
//! |----------------------------|-------------------------------------------------------|
//! | weights, computed torque   | nothing: the board computes it from the arm it has    |
//! | a gain of one's own        | the gain that gives the other arm the same poles      |
//! | the same, joints coupled   | stays: no other gain is sure to be meant              |
//! | the paper's printed gain   | stays: it is printed                                  |

use armbridge_shared::JOINTS;
use armbridge_shared::link::message::{Controller, Gains, Setup};
use nalgebra::{Matrix2, Vector2};

use super::place::{PlaceError, joints, place};

/// What became of the gains.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Redesign {
    /// The board computes them from its arm.
    OnBoard,
    /// Placed where the poles were.
    Placed,
    /// They are as before, because they were set by hand.
    Kept,
}

impl Redesign {
    /// In words.
    pub fn in_words(self) -> &'static str {
        match self {
            Self::OnBoard => "the board designs its gains anew, for this arm",
            Self::Placed => "the gain is a new one, with the poles that the old one had",
            Self::Kept => "the gain stays as it was; `armbridge design` makes one for this arm",
        }
    }
}

/// `after`, whose controller is `before`'s, with gains for its own arm.
///
/// # Errors
/// If no gain moves a joint of it.
pub fn retune(before: &Setup, after: &Setup) -> Result<(Setup, Redesign), PlaceError> {
    let gain = match after.controller {
        Controller::ComputedTorque { .. } | Controller::StateFeedback(Gains::Design { .. }) => {
            return Ok((*after, Redesign::OnBoard));
        }
        Controller::StateFeedback(Gains::Paper) => return Ok((*after, Redesign::Kept)),
        Controller::StateFeedback(Gains::Given(gain)) => gain,
    };
    let couples = (0..JOINTS).any(|joint| {
        let other = 1 - joint;
        gain[joint][other] != 0.0 || gain[joint][JOINTS + other] != 0.0
    });
    if couples {
        return Ok((*after, Redesign::Kept));
    }
    let gain = place(after, poles(before, &gain))?;
    let controller = Controller::StateFeedback(Gains::Given(gain));
    Ok((
        Setup {
            controller,
            ..*after
        },
        Redesign::Placed,
    ))
}

/// Sum and product of each joint's poles under a gain that does not couple joints.
fn poles(setup: &Setup, gain: &[[f32; 2 * JOINTS]; JOINTS]) -> [(f64, f64); JOINTS] {
    let joints = joints(setup);
    core::array::from_fn(|joint| {
        let row = [gain[joint][joint], gain[joint][JOINTS + joint]].map(f64::from);
        let (a, b) = joints[joint];
        let closed: Matrix2<f64> = a - b * Vector2::from(row).transpose();
        (closed.trace(), closed.determinant())
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::design::Design;

    #[test]
    fn another_arm_gets_the_poles_of_the_first() {
        let wanted = [(1.96, 0.9605), (1.95, 0.9506)];
        let mut before = Setup::default();
        before.controller =
            Controller::StateFeedback(Gains::Given(place(&before, wanted).unwrap()));
        let mut after = before;
        after.arm.i1x *= 1.5;
        after.arm.m2 *= 1.3;
        let (after, what) = retune(&before, &after).unwrap();
        assert_eq!(what, Redesign::Placed);
        assert_ne!(before.controller, after.controller);
        let [old, new] = [before, after].map(|setup| Design::of(&setup).unwrap().poles.controller);
        for (old, new) in old.iter().zip(&new) {
            // What f32 gains leave.
            assert!((old.re - new.re).abs() < 1e-5 && (old.im - new.im).abs() < 1e-4);
        }
    }

    #[test]
    fn what_the_board_computes_is_left_to_it_and_what_is_nobodys_design_is_kept() {
        let mut other = Setup::default();
        other.arm.m2 *= 1.3;
        let with = |controller| {
            let mut setup = other;
            setup.controller = controller;
            let (after, what) = retune(&Setup::default(), &setup).unwrap();
            assert_eq!(after, setup);
            what
        };
        assert_eq!(with(Setup::default().controller), Redesign::OnBoard);
        let paper = Controller::StateFeedback(Gains::Paper);
        assert_eq!(with(paper), Redesign::Kept);
        let coupled = Gains::Given([[1.0; 4]; 2]);
        assert_eq!(with(Controller::StateFeedback(coupled)), Redesign::Kept);
    }
}
