//! Estimators that the claims compare, built by the library.

use armbridge_control::arm::{Discrete, Parameters};
use armbridge_control::design::placement::{self, Poles, current_gain, prediction_gain};
use armbridge_control::estimate::{
    Config, Estimator, FiniteDifference, Form, Luenberger, Model, Tuning,
};
use armbridge_servo::JOINTS;
use nalgebra::{Matrix2, Vector2};

use super::DesignError;
use super::printed::{PERIOD_S, POLES};

/// Speeds as differences of two samples: the paper's first method.
pub(crate) fn difference() -> Estimator<f64> {
    let model = Model::of_arm(&Parameters::paper(), PERIOD_S);
    Estimator::FiniteDifference(FiniteDifference::new(model, PERIOD_S, 0.0))
}

/// (11) with (7) and (12), all as printed.
pub(crate) fn printed() -> Result<Estimator<f64>, DesignError> {
    Ok(Estimator::Luenberger(Luenberger::paper()?))
}

/// An observer with the printed poles on (7), or on the exact model.
pub(crate) fn placed(exact: bool, form: Form) -> Result<Estimator<f64>, DesignError> {
    let model = if exact {
        exact_model()
    } else {
        Discrete::paper()
    };
    let gains = gains_of_poles(&model, current_gain)?;
    let observer = Luenberger::new(Model::linear(&model), gains, form);
    Ok(Estimator::Luenberger(observer))
}

/// The board's observer: exact model, exact gravity, default poles.
pub(crate) fn standing(period_s: f64) -> Result<Estimator<f64>, DesignError> {
    Ok(Config::standing().build(&Parameters::paper(), period_s)?)
}

/// The board's Kalman filter. Its input is the full torque, so its disturbance estimate
/// contains friction; samples 45 ms apart need slower tuning than samples at 1 ms.
pub(crate) fn kalman(period_s: f64) -> Result<Estimator<f64>, DesignError> {
    let tuning = Tuning {
        disturbance: 0.1,
        acceleration: 0.1,
        coulomb_nm: 0.0,
        ..Tuning::standing()
    };
    Ok(Config::Kalman(tuning).build(&Parameters::paper(), period_s)?)
}

/// The arm that made (7), discretised exactly.
pub(crate) fn exact_model() -> Discrete<f64> {
    let upright = Vector2::zeros();
    Parameters::paper()
        .linearise(upright)
        .zero_order_hold(PERIOD_S)
}

/// Prediction-form gains of the printed poles on (7): angle and speed of each
/// joint.
pub(crate) fn placed_gain() -> Result<[[f64; 2]; JOINTS], DesignError> {
    Ok(gains_of_poles(&Discrete::paper(), prediction_gain)?.map(Into::into))
}

/// Gains for the poles in the printed order: two for joint 1, two for joint 2.
fn gains_of_poles<G>(model: &Discrete<f64>, gain: G) -> Result<[Vector2<f64>; JOINTS], DesignError>
where
    G: Fn(&Matrix2<f64>, Poles<f64>) -> Result<Vector2<f64>, placement::Error>,
{
    let [first, second] = model.joints();
    let [p1, p2, p3, p4] = POLES;
    Ok([
        gain(&first, Poles::Real(p1, p2))?,
        gain(&second, Poles::Real(p3, p4))?,
    ])
}
