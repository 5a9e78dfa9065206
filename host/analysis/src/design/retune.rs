//! Transfer of a controller to another arm.
//!
//! | controller                    | gain for the other arm                          |
//! |-------------------------------|-------------------------------------------------|
//! | weights, computed torque      | computed by the board from its arm              |
//! | user gain, joints decoupled   | placed for the same poles                       |
//! | user gain, joints coupled     | unchanged: no other gain is certainly intended  |
//! | the paper's printed gain      | unchanged                                       |

use armbridge_link::message::{Controller, Gains, Setup};
use armbridge_servo::JOINTS;
use nalgebra::{Matrix2, Vector2};

use super::place::{PlaceError, joints, place};

/// Treatment of the gains.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Redesign {
    /// The board computes them from its arm.
    OnBoard,
    /// They are placed for the previous poles.
    Placed,
    /// They are unchanged, because they were set by hand.
    Kept,
}

impl Redesign {
    /// Sentence part for messages.
    pub fn in_words(self) -> &'static str {
        match self {
            Self::OnBoard => "the board computes new gains for this arm",
            Self::Placed => "a new gain gives this arm the previous poles",
            Self::Kept => "the gain is unchanged; `armbridge design` computes one for this arm",
        }
    }
}

/// Adapts the gains of `after`, whose controller is that of `before`, to its own arm.
///
/// # Errors
/// If a torque does not move its joint.
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

/// Sum and product of each joint's poles under a gain without coupling.
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
        let poles = [(1.96, 0.9605), (1.95, 0.9506)];
        let mut before = Setup::default();
        before.controller = Controller::StateFeedback(Gains::Given(place(&before, poles).unwrap()));
        let mut after = before;
        after.arm.i1x *= 1.5;
        after.arm.m2 *= 1.3;
        let (after, redesign) = retune(&before, &after).unwrap();
        assert_eq!(redesign, Redesign::Placed);
        assert_ne!(before.controller, after.controller);
        let [old, new] =
            [before, after].map(|setup| Design::from_setup(&setup).unwrap().poles.controller);
        for (old, new) in old.iter().zip(&new) {
            // Rounding of f32 gains.
            assert!((old.re - new.re).abs() < 1e-5 && (old.im - new.im).abs() < 1e-4);
        }
    }

    #[test]
    fn gains_that_the_board_computes_and_coupled_or_printed_gains_are_unchanged() {
        let mut other = Setup::default();
        other.arm.m2 *= 1.3;
        let redesign = |controller| {
            let mut setup = other;
            setup.controller = controller;
            let (after, redesign) = retune(&Setup::default(), &setup).unwrap();
            assert_eq!(after, setup);
            redesign
        };
        assert_eq!(redesign(Setup::default().controller), Redesign::OnBoard);
        let paper = Controller::StateFeedback(Gains::Paper);
        assert_eq!(redesign(paper), Redesign::Kept);
        let coupled = Gains::Given([[1.0; 4]; 2]);
        assert_eq!(redesign(Controller::StateFeedback(coupled)), Redesign::Kept);
    }
}
