//! Controller and estimator, whose numbers depend on their kind.

use armbridge_control::controller::{Lqr, WEIGHT_MAX};
use armbridge_control::estimate::{Config, Form, Tuning};
use armbridge_link::message::{Controller, Gains, Settings, Setup};
use armbridge_servo::JOINTS;

use super::access::{Access, Numbers};
use super::{Parameter, Range, Shape, Takes, access, choice, number, numbers, pair};

const LQR: &str = "lqr";
const GAIN: &str = "gain";
const PAPER: &str = "paper";
const COMPUTED_TORQUE: &str = "computed-torque";

pub(super) const CONTROLLER: [Parameter; 7] = [
    choice(
        "controller.kind",
        "Control law: an LQR designed on the board for the period, a gain of your own, the \
         paper's printed gain, or feedback linearisation.",
        &[LQR, GAIN, PAPER, COMPUTED_TORQUE],
        |s| Some(controller(&s.setup.controller)),
        |s, word| s.setup.controller = controller_of(word),
    ),
    numbers(
        "controller.q",
        "",
        "Diagonal of the LQR's Q, equation (8): both angles, both speeds.",
        Shape::List(2 * JOINTS),
        Range::reals(0.0, WEIGHT_MAX),
        |s| match &mut s.setup.controller {
            Controller::StateFeedback(Gains::Design { q, .. }) => access::each(q),
            Controller::StateFeedback(Gains::Paper | Gains::Given(_))
            | Controller::ComputedTorque { .. } => None,
        },
    ),
    pair(
        "controller.r",
        "",
        "Diagonal of the LQR's R, equation (8): both torques.",
        Range::above_0_to(WEIGHT_MAX),
        |s| match &mut s.setup.controller {
            Controller::StateFeedback(Gains::Design { r, .. }) => access::each(r),
            Controller::StateFeedback(Gains::Paper | Gains::Given(_))
            | Controller::ComputedTorque { .. } => None,
        },
    ),
    numbers(
        "controller.gain",
        "N m/rad, N m s/rad",
        "The gain K, one row a torque: on both angles, then on both speeds. Refused unless it \
         stabilises the arm upright.",
        Shape::Rows(JOINTS, 2 * JOINTS),
        Range::ANY,
        |s| match &mut s.setup.controller {
            Controller::StateFeedback(Gains::Given(gain)) => access::each(gain.as_flattened_mut()),
            Controller::StateFeedback(Gains::Paper | Gains::Design { .. })
            | Controller::ComputedTorque { .. } => None,
        },
    ),
    pair(
        "controller.natural_rad_s",
        "rad/s",
        "Natural frequency with which the error of each joint dies away.",
        Range::ABOVE_0,
        |s| match &mut s.setup.controller {
            Controller::ComputedTorque { natural_rad_s, .. } => access::each(natural_rad_s),
            Controller::StateFeedback(_) => None,
        },
    ),
    pair(
        "controller.damping",
        "",
        "Damping ratio of each joint; 1 is critical.",
        Range::ABOVE_0,
        |s| match &mut s.setup.controller {
            Controller::ComputedTorque { damping, .. } => access::each(damping),
            Controller::StateFeedback(_) => None,
        },
    ),
    pair(
        "controller.integral",
        "N m/(rad s)",
        "Integral action of each joint, beside any control law: torque per angle error and time; \
         0 for none. Refused unless the loop with it is stable upright.",
        Range::reals(0.0, 1e3),
        |s| access::each(&mut s.setup.integral),
    ),
];

fn controller(controller: &Controller) -> &'static str {
    match controller {
        Controller::StateFeedback(Gains::Design { .. }) => LQR,
        Controller::StateFeedback(Gains::Given(_)) => GAIN,
        Controller::StateFeedback(Gains::Paper) => PAPER,
        Controller::ComputedTorque { .. } => COMPUTED_TORQUE,
    }
}

/// Of this kind, with its default numbers.
fn controller_of(word: &str) -> Controller {
    /// Tracks well at 1 kHz, and stays quiet.
    const NATURAL_RAD_S: f32 = 20.0;

    match word {
        GAIN => {
            // Matrices are stored by columns: those of the transpose are the rows.
            Controller::StateFeedback(Gains::Given(Lqr::paper().gain.transpose().data.0))
        }
        PAPER => Controller::StateFeedback(Gains::Paper),
        COMPUTED_TORQUE => Controller::ComputedTorque {
            natural_rad_s: [NATURAL_RAD_S; JOINTS],
            damping: [1.0; JOINTS],
        },
        _ => Setup::default().controller,
    }
}

const DIFFERENCE: &str = "difference";
const LUENBERGER: &str = "luenberger";
const KALMAN: &str = "kalman";

const CURRENT: &str = "current";
const PREDICTION: &str = "prediction";

pub(super) const ESTIMATOR: [Parameter; 10] = [
    choice(
        "estimator.kind",
        "State estimator: the observer (11) with its poles placed or with a gain of your own, a \
         Kalman filter that also estimates disturbance torques, or a difference through a low \
         pass.",
        &[LUENBERGER, KALMAN, DIFFERENCE, GAIN],
        |s| Some(estimator(&s.setup.estimator)),
        |s, word| s.setup.estimator = estimator_of(word),
    ),
    choice(
        "estimator.form",
        "When a sample begins to show in the observer: at once, or one period later, as printed.",
        &[CURRENT, PREDICTION],
        |s| match s.setup.estimator {
            Config::Luenberger { form, .. } | Config::Gain { form, .. } => Some(match form {
                Form::Current => CURRENT,
                Form::Prediction => PREDICTION,
            }),
            Config::FiniteDifference { .. } | Config::Kalman(_) => None,
        },
        |s, word| match &mut s.setup.estimator {
            Config::Luenberger { form, .. } | Config::Gain { form, .. } => {
                *form = if word == PREDICTION {
                    Form::Prediction
                } else {
                    Form::Current
                }
            }
            Config::FiniteDifference { .. } | Config::Kalman(_) => {}
        },
    ),
    Parameter {
        key: "estimator.poles_45ms",
        unit: "",
        about: "Two poles for each joint's observer, in z, as at 45 ms, the period of the paper; \
                mapped to the running period.",
        takes: Takes::Poles,
        access: Access::Poles(|s| match &mut s.setup.estimator {
            Config::Luenberger { poles_45ms, .. } => Some(poles_45ms),
            Config::FiniteDifference { .. } | Config::Gain { .. } | Config::Kalman(_) => None,
        }),
    },
    numbers(
        "estimator.gain",
        "",
        "The observer's gain L for the running period, one row a joint: on its angle, and on its \
         speed (1/s). That of equation (11) if `estimator.form` is \"prediction\", else what a \
         sample corrects at once. Refused unless the error decays.",
        Shape::Rows(JOINTS, 2),
        Range::ANY,
        |s| match &mut s.setup.estimator {
            Config::Gain { gain, .. } => access::each(gain.as_flattened_mut()),
            Config::FiniteDifference { .. } | Config::Luenberger { .. } | Config::Kalman(_) => None,
        },
    ),
    number(
        "estimator.angle_noise_rad",
        "rad",
        "The Kalman filter's noise of an angle sample, rms, rounding included.",
        Range::reals(1e-5, 1.0),
        |s| access::one(&mut tuning(s)?.angle_rad),
    ),
    number(
        "estimator.acceleration_noise_rad_s2_rthz",
        "rad/s²/√Hz",
        "Acceleration that no torque explains, as white noise.",
        Range::reals(1e-4, 1e3),
        |s| access::one(&mut tuning(s)?.acceleration),
    ),
    number(
        "estimator.disturbance_walk_nm_rts",
        "N m/√s",
        "How fast a disturbance torque may change.",
        Range::reals(0.0, 10.0),
        |s| access::one(&mut tuning(s)?.disturbance),
    ),
    number(
        "estimator.coulomb_nm",
        "N m",
        "Coulomb friction in the filter's model; 0 leaves friction to the disturbance.",
        Range::reals(0.0, 1.0),
        |s| access::one(&mut tuning(s)?.coulomb_nm),
    ),
    number(
        "estimator.slide_rad_s",
        "rad/s",
        "Speed from which on that friction is fully there.",
        Range::reals(1e-3, 10.0),
        |s| access::one(&mut tuning(s)?.slide_rad_s),
    ),
    number(
        "estimator.filter_s",
        "s",
        "Time constant of the low pass behind the difference; 0 leaves the plain difference.",
        Range::FROM_0,
        filter,
    ),
];

fn filter(settings: &mut Settings) -> Option<Numbers<'_>> {
    match &mut settings.setup.estimator {
        Config::FiniteDifference { filter_s } => access::one(filter_s),
        Config::Luenberger { .. } | Config::Gain { .. } | Config::Kalman(_) => None,
    }
}

fn tuning(settings: &mut Settings) -> Option<&mut Tuning<f32>> {
    match &mut settings.setup.estimator {
        Config::Kalman(tuning) => Some(tuning),
        Config::FiniteDifference { .. } | Config::Luenberger { .. } | Config::Gain { .. } => None,
    }
}

fn estimator(config: &Config<f32>) -> &'static str {
    match config {
        Config::FiniteDifference { .. } => DIFFERENCE,
        Config::Luenberger { .. } => LUENBERGER,
        Config::Gain { .. } => GAIN,
        Config::Kalman(_) => KALMAN,
    }
}

/// Of this kind, with its default numbers.
fn estimator_of(word: &str) -> Config<f32> {
    /// Time constant in s that makes differences at 1 kHz usable.
    const FILTER_S: f32 = 0.02;

    match word {
        DIFFERENCE => Config::FiniteDifference { filter_s: FILTER_S },
        KALMAN => Config::kalman(),
        GAIN => Config::paper_gain(),
        _ => Config::standing(),
    }
}
