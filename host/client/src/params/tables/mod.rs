//! The table of all parameters. Ranges are those that the board checks; a test holds one
//! against the other.

mod arm;
mod control;
mod limits;

use armbridge_shared::JOINTS;
use armbridge_shared::actuator::Direction;
use armbridge_shared::arm::Mounting;
use armbridge_shared::bridge::limits::{PERIOD_MAX_US, PERIOD_MIN_US};
use armbridge_shared::link::message::Settings;

use super::access::{Access, Numbers};
use super::constraint::{Range, Shape, Takes};
use super::{Parameter, access};

/// All groups, each with what chooses its kind first.
pub(super) fn all() -> Vec<Parameter> {
    let groups: [&[Parameter]; 8] = [
        &SETUP,
        &control::CONTROLLER,
        &control::ESTIMATOR,
        &arm::ARM,
        &arm::MOUNTING,
        &arm::JOINT_1,
        &arm::JOINT_2,
        &limits::LIMITS,
    ];
    groups.concat()
}

const SETUP: [Parameter; 2] = [
    number(
        "setup.period_us",
        "µs",
        "Tick period.",
        Range::whole(PERIOD_MIN_US, PERIOD_MAX_US),
        |s| access::one(&mut s.setup.period_us),
    ),
    list(
        "setup.friction_nm",
        "N m",
        "Torque added against dry friction, joint by joint; 0 for none.",
        JOINTS,
        Range::reals(0.0, 1.0),
        |s| access::each(&mut s.setup.friction_nm),
    ),
];

type At = for<'a> fn(&'a mut Settings) -> Option<Numbers<'a>>;

const fn number(
    key: &'static str,
    unit: &'static str,
    about: &'static str,
    range: Range,
    at: At,
) -> Parameter {
    let shape = Shape::One;
    Parameter {
        key,
        unit,
        about,
        takes: Takes::Numbers { shape, range },
        access: Access::Numbers(at),
    }
}

const fn list(
    key: &'static str,
    unit: &'static str,
    about: &'static str,
    count: usize,
    range: Range,
    at: At,
) -> Parameter {
    let shape = Shape::List(count);
    Parameter {
        takes: Takes::Numbers { shape, range },
        ..number(key, unit, about, range, at)
    }
}

const fn rows(
    key: &'static str,
    unit: &'static str,
    about: &'static str,
    columns: usize,
    range: Range,
    at: At,
) -> Parameter {
    let shape = Shape::Rows(JOINTS, columns);
    Parameter {
        takes: Takes::Numbers { shape, range },
        ..number(key, unit, about, range, at)
    }
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

/// Words for [`Direction`].
const DIRECTIONS: [&str; 2] = ["forward", "reverse"];

fn direction(direction: Direction) -> &'static str {
    let [forward, reverse] = DIRECTIONS;
    match direction {
        Direction::Forward => forward,
        Direction::Reverse => reverse,
    }
}

fn direction_of(word: &str) -> Direction {
    if word == direction(Direction::Reverse) {
        Direction::Reverse
    } else {
        Direction::Forward
    }
}

/// Words for [`Mounting`].
const MOUNTINGS: [&str; 2] = ["upright", "hanging"];

fn mounting(mounting: Mounting) -> &'static str {
    let [upright, hanging] = MOUNTINGS;
    match mounting {
        Mounting::Upright => upright,
        Mounting::Hanging => hanging,
    }
}

fn mounting_of(word: &str) -> Mounting {
    if word == mounting(Mounting::Hanging) {
        Mounting::Hanging
    } else {
        Mounting::Upright
    }
}
