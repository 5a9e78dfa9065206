//! Model of the arm, and calibration of its servos.

use armbridge_control::actuator::{Direction, bounds};
use armbridge_control::arm::Mounting;
use armbridge_control::encoder::Encoder;

use super::{Parameter, Range, access, choice, number};

const FORWARD: &str = "forward";
const REVERSE: &str = "reverse";

const UPRIGHT: &str = "upright";
const HANGING: &str = "hanging";

/// Of a length in m.
const LENGTH: Range = Range::reals(0.0, 1.0);
/// Of a mass in kg.
const MASS: Range = Range::reals(0.0, 10.0);
/// Of an inertia in kg m² that is divided by.
const INERTIA: Range = Range::reals(1e-5, 10.0);
/// Of one that is only added.
const SMALL_INERTIA: Range = Range::reals(0.0, 1.0);
/// Of viscous friction in N m s/rad.
const VISCOUS: Range = Range::reals(0.0, 10.0);

/// `key unit "meaning" range field;` of the arm.
macro_rules! arm {
    ($($key:literal $unit:literal $about:literal $range:ident $field:ident;)*) => {
        [$(number(concat!("arm.", $key), $unit, $about, $range, |s| {
            access::one(&mut s.setup.arm.$field)
        })),*]
    };
}

const GRAVITY: Range = Range::reals(0.0, 100.0);

pub(super) const ARM: [Parameter; 13] = arm! {
    "l1_m" "m" "Length from joint 1 to joint 2." LENGTH l1;
    "l2_m" "m" "Length from joint 2 to the end." LENGTH l2;
    "m1_kg" "kg" "Mass of link 1." MASS m1;
    "m2_kg" "kg" "Mass of link 2." MASS m2;
    "g_m_s2" "m/s²" "Gravitational acceleration." GRAVITY g;
    "i1x_kg_m2" "kg m²" "Inertia of link 1 about x, mostly that of the geared rotor." INERTIA i1x;
    "i1y_kg_m2" "kg m²" "Inertia of link 1 about y; not used by the equations." SMALL_INERTIA i1y;
    "i1z_kg_m2" "kg m²" "Inertia of link 1 about z; not used by the equations." SMALL_INERTIA i1z;
    "i2x_kg_m2" "kg m²" "Inertia of link 2 about x." SMALL_INERTIA i2x;
    "i2y_kg_m2" "kg m²" "Inertia of link 2 about y, mostly that of the geared rotor." INERTIA i2y;
    "i2z_kg_m2" "kg m²" "Inertia of link 2 about z." SMALL_INERTIA i2z;
    "b1_nm_s_rad" "N m s/rad" "Viscous friction of joint 1." VISCOUS b1;
    "b2_nm_s_rad" "N m s/rad" "Viscous friction of joint 2." VISCOUS b2;
};

pub(super) const MOUNTING: [Parameter; 1] = [choice(
    "arm.mounting",
    "Which way up the arm is: at joint angles 0, upright on the table or hanging from above.",
    &[UPRIGHT, HANGING],
    |s| {
        Some(match s.setup.arm.mounting {
            Mounting::Upright => UPRIGHT,
            Mounting::Hanging => HANGING,
        })
    },
    |s, word| {
        s.setup.arm.mounting = match word {
            HANGING => Mounting::Hanging,
            _ => Mounting::Upright,
        }
    },
)];

/// Least and largest encoder count at joint angle 0, of an AX-12A and of the X series.
const ZERO: [f64; 2] = [
    Encoder::Ax12a.middle_count() as f64 - Encoder::Ax12a.zero_off_counts(),
    Encoder::XSeries.middle_count() as f64 + Encoder::XSeries.zero_off_counts(),
];
/// Least and largest angle of a count in rad, the same way.
const RAD_PER_COUNT: [f64; 2] = [
    Encoder::XSeries.rad_per_count()[0],
    Encoder::Ax12a.rad_per_count()[1],
];

/// One servo's calibration.
macro_rules! joint {
    ($name:literal, $joint:literal) => {
        [
            number(
                concat!($name, ".zero_count"),
                "counts",
                "Encoder count at joint angle 0.",
                Range::reals(ZERO[0], ZERO[1]),
                |s| access::one(&mut s.setup.joints[$joint].zero_count),
            ),
            number(
                concat!($name, ".rad_per_count"),
                "rad",
                "Angle of one encoder count.",
                Range::reals(RAD_PER_COUNT[0], RAD_PER_COUNT[1]),
                |s| access::one(&mut s.setup.joints[$joint].rad_per_count),
            ),
            choice(
                concat!($name, ".direction"),
                "Mounting: whether encoder counts grow with the joint angle, or fall.",
                &[FORWARD, REVERSE],
                |s| {
                    Some(match s.setup.joints[$joint].direction {
                        Direction::Forward => FORWARD,
                        Direction::Reverse => REVERSE,
                    })
                },
                |s, word| {
                    s.setup.joints[$joint].direction = match word {
                        REVERSE => Direction::Reverse,
                        _ => Direction::Forward,
                    }
                },
            ),
            number(
                concat!($name, ".gain_counts_per_nm"),
                "counts/N m",
                "Counts of a command per N m, as `setup.control_mode` has them.",
                Range::reals(bounds::GAIN_COUNTS_PER_NM[0], bounds::GAIN_COUNTS_PER_NM[1]),
                |s| access::one(&mut s.setup.joints[$joint].gain_counts_per_nm),
            ),
            number(
                concat!($name, ".offset_counts"),
                "counts",
                "Counts of a command above off at which the motor gives no torque.",
                Range::reals(-bounds::OFFSET_COUNTS, bounds::OFFSET_COUNTS),
                |s| access::one(&mut s.setup.joints[$joint].offset_counts),
            ),
        ]
    };
}

pub(super) const JOINT_1: [Parameter; 5] = joint!("joint1", 0);
pub(super) const JOINT_2: [Parameter; 5] = joint!("joint2", 1);
