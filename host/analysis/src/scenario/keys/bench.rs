//! Keys of the simulated arm, its servos, and what acts on it.

use armbridge_client::params::Range;
use armbridge_client::toml_file::keys::{Key, KeyTable, Kind};
use armbridge_servo::JOINTS;

use super::{every_s, pair, seconds};

/// Angles in rad at which a hand holds the arm: inside the board's angle limit.
const HELD_RAD: Range = Range::reals(-1.4, 1.4);
/// Largest stiffness in N/m, and damping in N s/m, of a hand: the simulated arm moves in steps of
/// 0.1 ms.
const GRIP_N_M: Range = Range::reals(0.0, 10_000.0);
const GRIP_N_S_M: Range = Range::reals(0.0, 100.0);
/// Largest torque of a push in N m.
const PUSH_NM: Range = Range::reals(-10.0, 10.0);
const FIRMWARE: &[&str] = &["morpheus", "stock", "x"];

/// The keys.
pub(super) const KEYS: KeyTable = KeyTable {
    prefix: "",
    keys: &[
        Key::new(
            "bench",
            Kind::Table,
            "The simulated arm; without effect on a real one.",
        ),
        Key::number(
            "bench.seed",
            Range {
                whole: true,
                ..Range::FROM_0
            },
            "Seed of the encoder noise.",
        )
        .or("1"),
        pair(
            "bench.initial_rad",
            HELD_RAD,
            "Angles at which the arm is held until torque comes on.",
        )
        .unit("rad")
        .or("[0.30, -0.25]"),
        Key::new(
            "bench.friction",
            Kind::Switch,
            "Whether the joints have dry friction.",
        )
        .or("the arm's own"),
        Key::new(
            "bench.plant_file",
            Kind::Text,
            "Virtual arm: a file beside the scenario, or the name of one that ships.",
        ),
        Key::new(
            "bench.plant",
            Kind::Table,
            "The keys of a plant file, as `armbridge plants --explain` prints them.",
        ),
        Key::new(
            "bench.servos",
            Kind::Words(JOINTS, FIRMWARE),
            "Firmware of each servo.",
        )
        .or("[\"morpheus\", \"morpheus\"]"),
        Key::number(
            "bench.baud",
            Range::whole(1, 2_000_000),
            "Baud rate stored in the servos.",
        )
        .or("1000000"),
        Key::new("bench.push", Kind::Tables, "Pushes on the simulated arm."),
        seconds("bench.push.at_s", "Start. Required."),
        every_s("bench.push.every_s"),
        Key::number(
            "bench.push.joint",
            Range::whole(1, JOINTS as u32),
            "Joint. Required.",
        ),
        Key::number("bench.push.torque_nm", PUSH_NM, "Torque. Required.").unit("N m"),
        seconds("bench.push.duration_s", "Length. Required."),
        Key::new(
            "bench.hand",
            Kind::Tables,
            "Hands that lead the simulated arm, one at a time.",
        ),
        seconds(
            "bench.hand.at_s",
            "Start: it grasps the arm where it is. Required.",
        ),
        every_s("bench.hand.every_s"),
        Key::number(
            "bench.hand.link",
            Range::whole(1, JOINTS as u32),
            "Link that it holds at its end.",
        )
        .or("2"),
        Key::new(
            "bench.hand.path",
            Kind::Tables,
            "Points to which it leads the arm. Required.",
        ),
        seconds("bench.hand.path.after_s", "Time after `at_s`. Required."),
        pair(
            "bench.hand.path.angle_rad",
            HELD_RAD,
            "Angles at that time. Required.",
        )
        .unit("rad"),
        seconds(
            "bench.hand.release_s",
            "Time after `at_s` at which it lets go.",
        )
        .or("that of the last point"),
        Key::number(
            "bench.hand.stiffness_n_m",
            GRIP_N_M,
            "Spring by which it holds the link.",
        )
        .unit("N/m")
        .or("300"),
        Key::number(
            "bench.hand.damping_n_s_m",
            GRIP_N_S_M,
            "Damper beside the spring.",
        )
        .unit("N s/m")
        .or("10"),
    ],
};
