//! Numbers that the paper prints and the library does not use: the only numbers of
//! the report that do not come from the run.
//!
//! (7) is [`Discrete::paper`](armbridge_control::arm::Discrete::paper), (10)
//! [`Lqr::paper`](armbridge_control::controller::Lqr::paper), Table 1
//! [`Parameters::table_1`](armbridge_control::arm::Parameters::table_1), (5)
//! [`Joint::paper`](armbridge_control::actuator::Joint::paper).

use armbridge_servo::JOINTS;

/// Sampling period in s.
pub(crate) const PERIOD_S: f64 = 0.045;

/// Sampling period in µs.
pub(crate) const PERIOD_US: u32 = 45_000;

/// Observer gain (12): on angle and speed, for each joint.
pub(crate) const OBSERVER: [[f64; 2]; JOINTS] = [[0.29, 0.72], [0.34, 0.34]];

/// The poles for which (12) is designed according to the text.
pub(crate) const POLES: [f64; 4] = [0.05, 0.14, 0.1, 0.03];

/// b1 by the free fall, Fig. 5, in N m s/rad.
pub(crate) const B1_FALL: f64 = 0.421;

/// b1 by the constant input, Fig. 6, in N m s/rad.
pub(crate) const B1_PUSH: f64 = 0.239;

/// The constant input of Fig. 6 in N m.
pub(crate) const PUSH_NM: f64 = -0.3924;

/// Start angle of joint 1 in Fig. 6, in rad.
pub const PUSH_FROM_RAD: f64 = 0.49;

/// The dead zone's edges in PWM counts.
pub(crate) const DEAD_ZONE: [u16; 2] = [950, 1050];

/// Decimals of (7), which is rounded.
pub(crate) const MODEL_DECIMALS: u8 = 4;

/// Decimals of (10) and (12), which are cut off.
pub(crate) const GAIN_DECIMALS: u8 = 2;
