//! Keys of a plant file: names, ranges and meanings.
//!
//! The table checks every file, also where a scenario contains one, and is what
//! `armbridge plants --explain` prints.

use armbridge_client::params::{Range, Takes};
use armbridge_client::toml_file::keys::{Key, KeyTable, Kind};
use armbridge_servo::protocol2::model::MODELS;

use crate::plant::Friction;

const SCALE: Range = Range::reals(0.1, 10.0);
const COUNTS: Range = Range::reals(-500.0, 500.0);
const TORQUE_NM: Range = Range::reals(0.0, 10.0);
const LENGTH_M: Range = Range::reals(0.0, 1.0);
const MASS_KG: Range = Range::reals(0.0, 10.0);
const INERTIA: Range = Range::reals(1e-5, 10.0);
const SMALL_INERTIA: Range = Range::reals(0.0, 1.0);
const VISCOUS: Range = Range::reals(0.0, 10.0);
const DELAY_US: Range = Range::whole(0, 1_000_000);
/// Models of the X series.
const X_SERVOS: [&str; MODELS.len()] = {
    let mut names = [""; MODELS.len()];
    let mut model = 0;
    while model < names.len() {
        names[model] = MODELS[model].name;
        model += 1;
    }
    names
};
const PAPER: &str = "the paper's";

/// The keys.
pub const KEYS: KeyTable = KeyTable {
    prefix: "",
    keys: &[
        Key::new("friction", Kind::Switch, "Dry friction of the joints.").or("true"),
        Key::new(
            "dead_zone",
            Kind::Switch,
            "Both joints: true for the paper's dead zone, no torque for 950 < PWM < 1050, \
             false for none.",
        )
        .or("as `dead_zone_counts` of each joint"),
        Key::new(
            "held",
            Kind::Switch,
            "Whether the arm is held until the first servo receives a PWM other than 1000.",
        )
        .or("true"),
        Key::number(
            "inertia_scale",
            SCALE,
            "Factor on masses and moments of inertia, gravity apart.",
        )
        .or("1"),
        Key::number("gravity_scale", SCALE, "Factor on the gravity torque.").or("1"),
        Key::number(
            "torque_gain",
            SCALE,
            "Factor on the motors' torque: the supply voltage, or a wrong gain.",
        )
        .or("1"),
        Key::number(
            "pwm_offset_counts",
            COUNTS,
            "PWM counts by which the motors' true zero lies above `offset_counts`.",
        )
        .or("0"),
        Key::number(
            "torque_limit_nm",
            TORQUE_NM,
            "Largest torque of a motor; the default is that of an AX-12A stalled at 12 V.",
        )
        .unit("N m")
        .or("1.5"),
        Key::new(
            "x_servo",
            Kind::Value(Takes::OneOf(&X_SERVOS)),
            "Model of the servos if they are of the X series.",
        )
        .or("\"XL430-W250\""),
        Key::number(
            "input_delay_us",
            DELAY_US,
            "Both joints: time from a PWM's arrival in the servo to its torque.",
        )
        .unit("us")
        .or("as `input_delay_us` of each joint"),
        Key::number(
            "noise_lsb_rms",
            Range::reals(0.0, 100.0),
            "Noise of the encoders before rounding, in counts rms.",
        )
        .or("1"),
        Key::new(
            "arm",
            Kind::Table,
            "The arm as it truly is; the controller has a model of its own.",
        ),
        Key::number("arm.l1", LENGTH_M, "Length of link 1.")
            .unit("m")
            .or("0.095"),
        Key::number("arm.l2", LENGTH_M, "Length of link 2.")
            .unit("m")
            .or("0.1"),
        Key::number("arm.m1", MASS_KG, "Mass of link 1.")
            .unit("kg")
            .or("0.095"),
        Key::number("arm.m2", MASS_KG, "Mass of link 2.")
            .unit("kg")
            .or("0.37"),
        Key::number("arm.g", Range::reals(0.0, 100.0), "Gravity.")
            .unit("m/s²")
            .or("9.81"),
        Key::number("arm.i1x", INERTIA, "Inertia of link 1 about x.")
            .unit("kg m²")
            .or(PAPER),
        Key::number("arm.i1y", SMALL_INERTIA, "Not in the equations.")
            .unit("kg m²")
            .or(PAPER),
        Key::number("arm.i1z", SMALL_INERTIA, "Not in the equations.")
            .unit("kg m²")
            .or(PAPER),
        Key::number("arm.i2x", SMALL_INERTIA, "Inertia of link 2 about x.")
            .unit("kg m²")
            .or(PAPER),
        Key::number("arm.i2y", INERTIA, "Inertia of link 2 about y.")
            .unit("kg m²")
            .or(PAPER),
        Key::number("arm.i2z", SMALL_INERTIA, "Inertia of link 2 about z.")
            .unit("kg m²")
            .or(PAPER),
        Key::number("arm.b1", VISCOUS, "Viscous friction of joint 1.")
            .unit("N m s/rad")
            .or("0.24"),
        Key::number("arm.b2", VISCOUS, "Viscous friction of joint 2.")
            .unit("N m s/rad")
            .or("0.16"),
        Key::new(
            "arm.mounting",
            Kind::Value(Takes::OneOf(&["upright", "hanging"])),
            "Which way up it is: angles are 0 where both links point straight up, or straight \
             down.",
        )
        .or("\"upright\""),
        Key::new("joint1", Kind::Table, "Joint 1 and its servo."),
        initial_rad("joint1.initial_rad"),
        initial_rad_s("joint1.initial_rad_s"),
        stops_rad("joint1.stops_rad").or("[-1.571, 1.571], the table"),
        coulomb_nm("joint1.coulomb_nm"),
        static_nm("joint1.static_nm"),
        stribeck_rad_s("joint1.stribeck_rad_s"),
        friction_load("joint1.friction_load"),
        dead_zone_counts("joint1.dead_zone_counts"),
        input_delay_us("joint1.input_delay_us"),
        direction("joint1.direction"),
        zero_count("joint1.zero_count"),
        rad_per_count("joint1.rad_per_count"),
        gain_counts_per_nm("joint1.gain_counts_per_nm"),
        offset_counts("joint1.offset_counts"),
        Key::new("joint2", Kind::Table, "Joint 2 and its servo."),
        initial_rad("joint2.initial_rad"),
        initial_rad_s("joint2.initial_rad_s"),
        stops_rad("joint2.stops_rad").or("[-2.618, 2.618], the servo's own"),
        coulomb_nm("joint2.coulomb_nm"),
        static_nm("joint2.static_nm"),
        stribeck_rad_s("joint2.stribeck_rad_s"),
        friction_load("joint2.friction_load"),
        dead_zone_counts("joint2.dead_zone_counts"),
        input_delay_us("joint2.input_delay_us"),
        direction("joint2.direction"),
        zero_count("joint2.zero_count"),
        rad_per_count("joint2.rad_per_count"),
        gain_counts_per_nm("joint2.gain_counts_per_nm"),
        offset_counts("joint2.offset_counts"),
    ],
};

const fn initial_rad(path: &'static str) -> Key {
    let about = "Angle at the start.";
    Key::number(path, Range::reals(-1.5, 1.5), about)
        .unit("rad")
        .or("the command's or the scenario's")
}

const fn initial_rad_s(path: &'static str) -> Key {
    let about = "Speed at the start.";
    Key::number(path, Range::reals(-100.0, 100.0), about)
        .unit("rad/s")
        .or("0")
}

const fn stops_rad(path: &'static str) -> Key {
    let about = "Mechanical stops: the smallest angle, then the largest.";
    Key::numbers(path, 2, Range::reals(-3.2, 3.2), about).unit("rad")
}

const fn coulomb_nm(path: &'static str) -> Key {
    let about = "Sliding dry friction.";
    Key::number(path, TORQUE_NM, about).unit("N m").or("0.04")
}

const fn static_nm(path: &'static str) -> Key {
    let about = "Static friction; the default is 50 PWM counts.";
    Key::number(path, TORQUE_NM, about).unit("N m").or("0.06")
}

const fn stribeck_rad_s(path: &'static str) -> Key {
    let about = "Speed over which static friction turns into sliding friction; 0: at once.";
    Key::number(path, Range::reals(0.0, 100.0), about)
        .unit("rad/s")
        .or("0")
}

const fn friction_load(path: &'static str) -> Key {
    let about = "Dry friction per torque that the gears transmit.";
    Key::number(path, Range::reals(0.0, Friction::LOAD_MAX), about)
        .unit("N m/N m")
        .or("0")
}

const fn dead_zone_counts(path: &'static str) -> Key {
    let about = "PWM counts below and above off up to which there is no torque; the paper's are \
                 [49, 49].";
    Key::numbers(path, 2, Range::whole(0, 500), about).or("[0, 0]")
}

const fn input_delay_us(path: &'static str) -> Key {
    let about = "Time from a PWM's arrival in the servo to its torque.";
    Key::number(path, DELAY_US, about).unit("us").or("0")
}

const fn direction(path: &'static str) -> Key {
    let words = Kind::Value(Takes::OneOf(&["forward", "reverse"]));
    Key::new(path, words, "Whether counts grow or fall with the angle.").or("\"forward\"")
}

const fn zero_count(path: &'static str) -> Key {
    let about = "Encoder count at angle 0; an AX-12A has 0 to 1023.";
    Key::number(path, Range::reals(0.0, 4095.0), about).or("512")
}

const fn rad_per_count(path: &'static str) -> Key {
    let about = "Angle of a count; the default is 300 degrees over 1023.";
    Key::number(path, Range::reals(1e-4, 0.1), about)
        .unit("rad")
        .or("0.005118")
}

const fn gain_counts_per_nm(path: &'static str) -> Key {
    let about = "PWM counts per N m, as in the paper's equation (5).";
    Key::number(path, Range::reals(10.0, 1e5), about).or("834")
}

const fn offset_counts(path: &'static str) -> Key {
    let about = "PWM counts above off without torque, as in the paper's equation (5).";
    Key::number(path, COUNTS, about).or("15")
}
