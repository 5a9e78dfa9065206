//! The requested set-up: defaults overridden by options.

use armbridge_control::estimate::{Config, Form, Tuning};
use armbridge_link::message::{Controller, Gains, Setup};
use armbridge_servo::JOINTS;

use super::args::{ControlArgs, ControllerName, EstimateArgs, EstimatorName};

/// Time constant of the low pass in s that makes differences at 1 kHz usable.
const FILTER_S: f32 = 0.02;
/// Computed torque that tracks well at 1 kHz and stays quiet.
const NATURAL_RAD_S: f32 = 20.0;

/// The requested control law.
pub(super) fn controller(args: &ControlArgs) -> Result<Controller, String> {
    use ControllerName::{ComputedTorque, Lqr, Paper};
    let is = |name| args.controller == name;
    belongs(
        args.q.is_some() || args.r.is_some(),
        is(Lqr),
        "--q and --r",
        "lqr",
    )?;
    let is_told = args.natural.is_some() || args.damping.is_some();
    let options = "--natural and --damping";
    belongs(is_told, is(ComputedTorque), options, "computed-torque")?;
    Ok(match args.controller {
        Paper => Controller::StateFeedback(Gains::Paper),
        Lqr => match Setup::best().controller {
            Controller::StateFeedback(Gains::Design { q, r }) => {
                Controller::StateFeedback(Gains::Design {
                    q: args.q.unwrap_or(q),
                    r: args.r.unwrap_or(r),
                })
            }
            other => other,
        },
        ComputedTorque => Controller::ComputedTorque {
            natural_rad_s: args.natural.unwrap_or([NATURAL_RAD_S; JOINTS]),
            damping: args.damping.unwrap_or([1.0; JOINTS]),
        },
    })
}

/// The requested estimator.
pub(super) fn estimator(args: &EstimateArgs) -> Result<Config<f32>, String> {
    use EstimatorName::{Difference, Filtered, Kalman, Luenberger};
    let is = |name| args.estimator == name;
    belongs(args.filter.is_some(), is(Filtered), "--filter", "filtered")?;
    let is_told = args.poles.is_some() || args.prediction;
    belongs(
        is_told,
        is(Luenberger),
        "--poles and --prediction",
        "luenberger",
    )?;
    let kalman = [
        args.angle_noise,
        args.acceleration_noise,
        args.walk,
        args.coulomb,
        args.slide,
    ];
    let options = "--angle-noise, --acceleration-noise, --walk, --coulomb and --slide";
    belongs(
        kalman.iter().any(Option::is_some),
        is(Kalman),
        options,
        "kalman",
    )?;
    Ok(match args.estimator {
        Difference => Config::FiniteDifference { filter_s: 0.0 },
        Filtered => Config::FiniteDifference {
            filter_s: args.filter.unwrap_or(FILTER_S),
        },
        Luenberger => match Config::standing() {
            Config::Luenberger { form, poles_45ms } => Config::Luenberger {
                form: if args.prediction {
                    Form::Prediction
                } else {
                    form
                },
                poles_45ms: args.poles.unwrap_or(poles_45ms),
            },
            other => other,
        },
        Kalman => {
            let standing = Tuning::standing();
            Config::Kalman(Tuning {
                angle_rad: args.angle_noise.unwrap_or(standing.angle_rad),
                acceleration: args.acceleration_noise.unwrap_or(standing.acceleration),
                disturbance: args.walk.unwrap_or(standing.disturbance),
                coulomb_nm: args.coulomb.unwrap_or(standing.coulomb_nm),
                slide_rad_s: args.slide.unwrap_or(standing.slide_rad_s),
            })
        }
    })
}

/// An option that would have no effect is a mistake.
fn belongs(is_told: bool, is_chosen: bool, options: &str, to: &str) -> Result<(), String> {
    if is_told && !is_chosen {
        return Err(format!("{options} go with `{to}`, which is not chosen"));
    }
    Ok(())
}
