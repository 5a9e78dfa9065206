//! Keys of a scenario file: names, ranges and meanings.
//!
//! The table checks every file before it is parsed, and is what `armbridge run --explain`
//! prints. Ranges of motions depend on where the arm is: the board's planner checks them.

mod bench;

use armbridge_client::params::{Range, Shape, Takes};
use armbridge_client::toml_file::keys::{Key, KeyTable, Kind};
use armbridge_servo::JOINTS;
use armbridge_sim::plant;

/// Largest time in s: a day.
const DAY_S: f64 = 86_400.0;
const TIME_S: Range = Range::reals(0.0, DAY_S);
/// The board's range of setpoints in rad, `REFERENCE_MAX_RAD`.
pub(super) const REFERENCE_RAD: Range = Range::reals(-1.2, 1.2);
/// The board's range of torques in N m, `hard::TORQUE_NM`.
pub(super) const TORQUE_NM: Range = Range::reals(-1.25, 1.25);
const CONTROLS: &[&str] = &["board", "paper", "compensated"];

/// Tables of a scenario file; the virtual arm has the keys of a plant file.
pub(super) const TABLES: [KeyTable; 3] = [
    RUN,
    bench::KEYS,
    KeyTable {
        prefix: "bench.plant.",
        keys: plant::KEYS.keys,
    },
];

const fn pair(path: &'static str, range: Range, about: &'static str) -> Key {
    Key::numbers(path, JOINTS, range, about)
}

const fn angles(path: &'static str, about: &'static str) -> Key {
    pair(path, Range::ANY, about).unit("rad")
}

const fn hertz(path: &'static str, about: &'static str) -> Key {
    pair(path, Range::ANY, about).unit("Hz")
}

const fn length_s(path: &'static str, about: &'static str) -> Key {
    Key::number(path, Range::ANY, about).unit("s")
}

const fn seconds(path: &'static str, about: &'static str) -> Key {
    Key::number(path, TIME_S, about).unit("s")
}

const fn every_s(path: &'static str) -> Key {
    let about = "Repeats it at this interval until the run ends.";
    Key::number(path, Range::reals(1e-3, DAY_S), about).unit("s")
}

/// The keys, but for those of a plant file.
pub const KEYS: [KeyTable; 2] = [RUN, bench::KEYS];

const RUN: KeyTable = KeyTable {
    prefix: "",
    keys: &[
        Key::new(
            "title",
            Kind::Text,
            "One line for lists and plots. Required.",
        ),
        Key::new("about", Kind::Text, "More words."),
        Key::new(
            "control",
            Kind::Value(Takes::OneOf(CONTROLS)),
            "Controller, estimator, friction and period before `[set]`: the board's own, the \
             paper's weights and observer, or a Kalman filter with stiffer gains and friction \
             fed forward.",
        )
        .or("\"board\""),
        Key::new(
            "baseline",
            Kind::Value(Takes::OneOf(CONTROLS)),
            "Control of a second run on the same simulated arm, for comparison.",
        ),
        Key::new(
            "set",
            Kind::Parameters,
            "Parameters of the board in force before the arm is armed.",
        ),
        Key::new(
            "narrow",
            Kind::Switch,
            "Scales all angles of a joint down where the board would refuse an experiment's \
             envelope: its servo's zero is off the middle, or its angle limit is near.",
        )
        .or("false"),
        Key::new(
            "step",
            Kind::Tables,
            "The timeline. A step has a time and one action.",
        ),
        seconds(
            "step.at_s",
            "Time of the step since the arm was armed. Required.",
        ),
        every_s("step.every_s"),
        pair(
            "step.regulate_rad",
            REFERENCE_RAD,
            "Setpoint, as a step; held.",
        )
        .unit("rad"),
        pair(
            "step.torque_nm",
            TORQUE_NM,
            "Constant torque; the board ends it after `limits.torque_age_ms`.",
        )
        .unit("N m"),
        Key::new(
            "step.minimum_jerk",
            Kind::Table,
            "Action: motion to a point.",
        ),
        angles("step.minimum_jerk.to_rad", "End angles. Required."),
        length_s("step.minimum_jerk.duration_s", "Its length.")
            .or("as short as the board's bounds allow"),
        Key::new(
            "step.waypoints",
            Kind::Tables,
            "Action: motion through at most 8 points.",
        ),
        seconds("step.waypoints.after_s", "Time after the step. Required."),
        angles("step.waypoints.angle_rad", "Angles at that time. Required."),
        pair(
            "step.waypoints.speed_rad_s",
            Range::ANY,
            "Not for waypoints: the planner chooses their speeds.",
        )
        .unit("rad/s"),
        Key::new(
            "step.sinusoid",
            Kind::Table,
            "Action: sinusoid about a centre.",
        ),
        angles("step.sinusoid.centre_rad", "Centre.").or("[0, 0]"),
        angles("step.sinusoid.amplitude_rad", "Amplitude. Required."),
        hertz("step.sinusoid.frequency_hz", "Frequency. Required."),
        angles("step.sinusoid.phase_rad", "Phase.").or("[0, 0]"),
        length_s(
            "step.sinusoid.ramp_s",
            "Fade in and fade out, at most half of `duration_s`. Required.",
        ),
        length_s("step.sinusoid.duration_s", "Its length. Required."),
        Key::new(
            "step.chirp",
            Kind::Table,
            "Action: the same with a frequency that changes linearly.",
        ),
        angles("step.chirp.centre_rad", "Centre.").or("[0, 0]"),
        angles("step.chirp.amplitude_rad", "Amplitude. Required."),
        hertz("step.chirp.from_hz", "First frequency. Required."),
        hertz("step.chirp.to_hz", "Last frequency. Required."),
        length_s("step.chirp.ramp_s", "Fade in and fade out. Required."),
        length_s("step.chirp.duration_s", "Its length. Required."),
        Key::new(
            "step.stream",
            Kind::Tables,
            "Action: points that the host sends one by one, each ahead of its time.",
        ),
        seconds("step.stream.after_s", "Time after the step. Required."),
        angles("step.stream.angle_rad", "Angles at that time. Required."),
        pair(
            "step.stream.speed_rad_s",
            Range::ANY,
            "Speeds at that time.",
        )
        .unit("rad/s")
        .or("computed from the neighbours"),
        Key::new(
            "step.experiment",
            Kind::Table,
            "Action: excitation that ends when a joint leaves the envelope.",
        ),
        Key::new(
            "step.experiment.roles",
            Kind::List(JOINTS),
            "Each joint: \"off\", \"hold\", or a table with one of pwm, bias, torque and angle, \
             which is a table with one signal: constant, triangle, staircase, steps, sinusoid, \
             chirp, multisine or prbs. Required.",
        ),
        length_s("step.experiment.duration_s", "Its length. Required."),
        Key {
            unit: "rad",
            ..Key::new(
                "step.experiment.angle_rad",
                Kind::Value(Takes::Numbers {
                    shape: Shape::Rows(JOINTS, 2),
                    range: Range::ANY,
                }),
                "Envelope: smallest and largest angle of each joint. Required.",
            )
        },
        pair(
            "step.experiment.speed_rad_s",
            Range::ANY,
            "Envelope: largest speed of each joint. Required.",
        )
        .unit("rad/s"),
        Key::new(
            "step.float",
            Kind::Switch,
            "Action: make the arm weightless, for a hand to lead. Only true.",
        ),
        Key::new(
            "step.park",
            Kind::Switch,
            "Action: move the arm to the pose of `park.angle_rad`, lower it there, and disarm. Only \
             true.",
        ),
        Key::new(
            "step.set",
            Kind::Parameters,
            "Action: change of parameters under torque, as one group; not `limits.*`, \
             `park.*` and `setup.period_us`, which belong into `[set]`.",
        ),
        Key::new(
            "step.idle",
            Kind::Switch,
            "Action: disarm, motors off. Only true.",
        ),
        Key::new(
            "step.arm",
            Kind::Switch,
            "Action: arm again after `idle` or `park`. Only true.",
        ),
        Key::new("stop", Kind::Table, "The end of the run. Required."),
        seconds(
            "stop.after_s",
            "Length of the run; `--duration` takes precedence. Required.",
        ),
        pair(
            "stop.angle_beyond_rad",
            Range::ABOVE_0,
            "Ends the run when a joint is beyond this angle.",
        )
        .unit("rad"),
        pair(
            "stop.error_beyond_rad",
            Range::ABOVE_0,
            "Ends the run when a joint is this far from its reference.",
        )
        .unit("rad"),
        seconds("stop.error_for_s", "How long that error must last.").or("0"),
        Key::new(
            "stop.success",
            Kind::Texts,
            "Ends that count as success: time, angle, error, fault, or the name of a fault.",
        )
        .or("[\"time\"]"),
        Key::new(
            "expect",
            Kind::Table,
            "The expected result; a run that misses it has failed.",
        ),
        expectation(
            "expect.settles_within_s",
            "Both joints are within 20 mrad of every setpoint after this time, for good.",
        )
        .unit("s"),
        expectation(
            "expect.rests_within_rad",
            "Mean error of either joint over the last 0.5 s at every setpoint.",
        )
        .unit("rad"),
        expectation(
            "expect.tracks_within_rad",
            "Rms error of either joint while the reference moves.",
        )
        .unit("rad"),
        expectation(
            "expect.recovers_within_s",
            "After every push both joints are within 20 mrad of the reference after this time, \
             for good or until the next push.",
        )
        .unit("s"),
        expectation(
            "expect.stays_within_rad",
            "After every hand has let go both joints stay this near to where it left them, until \
             the next hand, or for as long as the arm floats.",
        )
        .unit("rad"),
        expectation(
            "expect.parks_within_s",
            "Every park, of which there is at least one, ends after this time, without a fault.",
        )
        .unit("s"),
        expectation("expect.torque_within_nm", "Largest torque of either joint.").unit("N m"),
        Key::new(
            "expect.experiments_end",
            Kind::Value(Takes::OneOf(&["finished", "angle", "speed"])),
            "There are experiments, and each ends so.",
        ),
    ],
};

const fn expectation(path: &'static str, about: &'static str) -> Key {
    Key::number(path, Range::ABOVE_0, about)
}
