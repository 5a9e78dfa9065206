//! The table of all parameters. Ranges are those that the board checks; a test compares
//! them.

mod arm;
mod control;
mod limits;

use armbridge_board::bridge::limits::{PERIOD_MAX_US, PERIOD_MIN_US};
use armbridge_link::message::{FRICTION_LOAD_PERCENT_MAX, Settings};
use armbridge_servo::{ControlMode, JOINTS};

use super::access::{Access, Numbers};
use super::constraint::{Range, Shape, Takes};
use super::{Parameter, access};

/// All groups; in each, the parameter that selects its kind comes first.
pub(super) fn all() -> Vec<Parameter> {
    let groups: [&[Parameter]; 9] = [
        &SETUP,
        &control::CONTROLLER,
        &control::ESTIMATOR,
        &arm::ARM,
        &arm::MOUNTING,
        &arm::JOINT_1,
        &arm::JOINT_2,
        &limits::LIMITS,
        &limits::PARK,
    ];
    groups.concat()
}

/// Names of the control modes.
const PWM: &str = "pwm";
const CURRENT: &str = "current";

const SETUP: [Parameter; 4] = [
    number(
        "setup.period_us",
        "µs",
        "Tick period.",
        Range::whole(PERIOD_MIN_US, PERIOD_MAX_US),
        |s| access::one(&mut s.setup.period_us),
    ),
    pair(
        "setup.friction_nm",
        "N m",
        "Torque added against dry friction, joint by joint; 0 for none.",
        Range::reals(0.0, 1.0),
        |s| access::each(&mut s.setup.friction_nm),
    ),
    pair(
        "setup.friction_load_percent",
        "%",
        "Dry friction in percent of the torque that the gears transmit, joint by joint, beside \
         `setup.friction_nm`; 0 for none. A Kalman filter with Coulomb friction has it in its \
         model, too.",
        Range::whole(0, FRICTION_LOAD_PERCENT_MAX as u32),
        |s| access::each(&mut s.setup.friction_load_percent),
    ),
    choice(
        "setup.control_mode",
        "What the counts of a command are, of X servos: thousandths of full duty, or counts of the \
         goal current. Another mode needs another `gain_counts_per_nm`: `armbridge calibrate --mode`.",
        &[PWM, CURRENT],
        |s| {
            Some(match s.setup.control_mode {
                ControlMode::Pwm => PWM,
                ControlMode::Current => CURRENT,
            })
        },
        |s, word| {
            s.setup.control_mode = match word {
                CURRENT => ControlMode::Current,
                _ => ControlMode::Pwm,
            }
        },
    ),
];

type At = for<'a> fn(&'a mut Settings) -> Option<Numbers<'a>>;

const fn numbers(
    key: &'static str,
    unit: &'static str,
    about: &'static str,
    shape: Shape,
    range: Range,
    at: At,
) -> Parameter {
    Parameter {
        key,
        unit,
        about,
        takes: Takes::Numbers { shape, range },
        access: Access::Numbers(at),
    }
}

const fn number(
    key: &'static str,
    unit: &'static str,
    about: &'static str,
    range: Range,
    at: At,
) -> Parameter {
    numbers(key, unit, about, Shape::One, range, at)
}

/// One number for each joint.
const fn pair(
    key: &'static str,
    unit: &'static str,
    about: &'static str,
    range: Range,
    at: At,
) -> Parameter {
    numbers(key, unit, about, Shape::List(JOINTS), range, at)
}

const fn choice(
    key: &'static str,
    about: &'static str,
    words: &'static [&'static str],
    is: fn(&Settings) -> Option<&'static str>,
    choose: fn(&mut Settings, &str),
) -> Parameter {
    Parameter {
        key,
        unit: "",
        about,
        takes: Takes::OneOf(words),
        access: Access::Choice { is, choose },
    }
}
