//! Controller and integral action of a set-up, which are refused unless the loop with them decays.

use nalgebra::{Matrix2x4, SMatrix};

use armbridge_control::arm::Discrete;
use armbridge_control::controller::{
    ComputedTorque, Controller, IntegralAction, Lqr, Tuning, Weights, computed_torque,
};
use armbridge_control::design::stability;
use armbridge_link::message::{self, Gains, Refusal, Setup};
use armbridge_servo::JOINTS;

/// Controller of a set-up, for a model of the arm at its period.
///
/// # Errors
/// The reason why it has none.
pub(super) fn controller(
    setup: &Setup,
    model: &Discrete<f32>,
    period_s: f32,
) -> Result<Controller<f32>, Refusal> {
    match setup.controller {
        message::Controller::StateFeedback(gains) => {
            state_feedback(gains, model).map(Controller::StateFeedback)
        }
        message::Controller::ComputedTorque {
            natural_rad_s,
            damping,
        } => {
            let tuning = Tuning {
                natural_rad_s,
                damping,
            };
            ComputedTorque::new(&tuning, period_s)
                .map(Controller::ComputedTorque)
                .map_err(|error| match error {
                    computed_torque::Error::Unstable { radius, .. } => Refusal::Unstable {
                        re: radius,
                        im: 0.0,
                    },
                    computed_torque::Error::Period
                    | computed_torque::Error::Natural { .. }
                    | computed_torque::Error::Damping { .. } => Refusal::OutOfRange,
                })
        }
    }
}

/// State feedback with these gains, if it stabilises the model.
fn state_feedback(gains: Gains, model: &Discrete<f32>) -> Result<Lqr<f32>, Refusal> {
    let lqr = match gains {
        // Designed for one period, so it is checked for the running one.
        Gains::Paper => Lqr::paper(),
        Gains::Design { q, r } => {
            let weights = Weights { q, r };
            if !weights.is_valid() {
                return Err(Refusal::OutOfRange);
            }
            return Lqr::design(model, &weights).map_err(|_| Refusal::NoGains);
        }
        Gains::Given([first, second]) => Lqr::of_rows(first, second),
    };
    decays(&(model.a - model.b * lqr.gain))?;
    Ok(lqr)
}

/// Integral action with these gains, if any is not 0 and the loop with it is stable.
pub(super) fn integral(
    gains: [f32; JOINTS],
    feedback: &Matrix2x4<f32>,
    model: &Discrete<f32>,
    period_s: f32,
) -> Result<Option<IntegralAction<f32>>, Refusal> {
    if !gains.iter().all(|gain| *gain >= 0.0) {
        return Err(Refusal::OutOfRange);
    }
    if gains.iter().all(|gain| *gain <= 0.0) {
        return Ok(None);
    }
    let integral = IntegralAction::new(gains, period_s);
    decays(&integral.closed_loop(model, feedback))?;
    Ok(Some(integral))
}

/// Refuses a closed loop that grows.
fn decays<const N: usize>(closed: &SMatrix<f32, N, N>) -> Result<(), Refusal> {
    let eigenvalue = stability::dominant(closed).ok_or(Refusal::OutOfRange)?;
    if eigenvalue.radius() < 1.0 {
        Ok(())
    } else {
        Err(Refusal::Unstable {
            re: eigenvalue.re,
            im: eigenvalue.im,
        })
    }
}
