//! What a record is made of, as columns: one table for every file format.
//!
//! A quantity is one column, or one for each joint; values are those of the
//! [`Record`], to the bit. What a record says by an enum or by bits is a word
//! here: a place in a list of [`Words`], whose first is empty where there is
//! nothing to say.

use armbridge_client::enum_names;
use armbridge_shared::link::message::{Guards, Record};

/// A quantity of every tick.
#[derive(Clone, Copy, Debug)]
pub struct Quantity {
    /// Its name where both joints are one thing.
    pub name: &'static str,
    /// Names of its columns: one, or one for each joint.
    pub columns: &'static [&'static str],
    /// As `rad`, `N m`; empty for words and plain numbers.
    pub unit: &'static str,
    /// In a sentence without a full stop.
    pub about: &'static str,
    /// How it is read.
    pub values: Values,
}

/// How the values of a quantity are read; where there is one for each joint, they
/// are told which.
#[derive(Clone, Copy, Debug)]
pub enum Values {
    /// Times.
    F64(fn(&Record) -> f64),
    /// Real numbers.
    F32(fn(&Record, usize) -> f32),
    /// Counters.
    U32(fn(&Record) -> u32),
    /// Register values.
    U16(fn(&Record, usize) -> u16),
    /// Samples, which may be missing.
    Sample(fn(&Record, usize) -> Option<u16>),
    /// Words.
    Word(Words, fn(&Record, usize) -> usize),
}

/// Lists of words.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Words {
    /// Modes; every fault is `fault`.
    Modes,
    /// Faults, the first for none.
    Faults,
    /// What the supervisor changed, the first for nothing.
    Guards,
    /// Why a sample is missing, the first for one that is not.
    Missing,
    /// A stock servo's alarms, the first for none.
    Alarms,
}

/// Combinations of guards, and of alarms, that there can be.
const GUARDS: usize = 1 << 4;
const ALARMS: usize = 1 << 7;

impl Words {
    /// All of the list, in order.
    pub fn all(self) -> Vec<String> {
        let none = || std::iter::once(String::new());
        match self {
            Self::Modes => {
                let modes = enum_names::MODES.into_iter().map(enum_names::mode);
                modes.chain(["fault"]).map(str::to_owned).collect()
            }
            Self::Faults => {
                let faults = enum_names::FAULTS.into_iter().map(enum_names::fault);
                none().chain(faults.map(str::to_owned)).collect()
            }
            Self::Guards => {
                let guards = [Guards::BRAKED, Guards::TORQUE, Guards::RATE, Guards::PWM];
                let of = |bits: usize| {
                    let set = guards.into_iter().filter(|g| bits & g.bits() as usize != 0);
                    enum_names::guards(set.fold(Guards::NONE, Guards::or))
                };
                (0..GUARDS).map(of).collect()
            }
            Self::Missing => {
                let kinds = enum_names::MISSING.into_iter().map(enum_names::missing);
                none().chain(kinds.map(str::to_owned)).collect()
            }
            Self::Alarms => (0..ALARMS)
                .map(|bits| enum_names::alarms(bits as u8))
                .collect(),
        }
    }

    /// Whether the first word says that there is nothing to say.
    pub fn may_be_empty(self) -> bool {
        match self {
            Self::Modes => false,
            Self::Faults | Self::Guards | Self::Missing | Self::Alarms => true,
        }
    }
}

fn mode(record: &Record, _: usize) -> usize {
    let known = enum_names::MODES
        .iter()
        .position(|mode| *mode == record.mode);
    // Every other mode is a fault.
    known.unwrap_or(enum_names::MODES.len())
}

fn fault(record: &Record, _: usize) -> usize {
    enum_names::fault_of(record.mode).map_or(0, |fault| place(&enum_names::FAULTS, &fault))
}

fn missing(record: &Record, joint: usize) -> usize {
    let missing = record.samples[joint].missing();
    missing.map_or(0, |kind| place(&enum_names::MISSING, &kind))
}

/// Where something stands in a list whose words begin with none.
fn place<T: PartialEq>(list: &[T], of: &T) -> usize {
    list.iter().position(|one| one == of).map_or(0, |at| at + 1)
}

/// All of a record.
pub const QUANTITIES: [Quantity; 21] = [
    Quantity {
        name: "time_s",
        columns: &["time_s"],
        unit: "s",
        about: "start of the tick on the board's clock",
        values: Values::F64(|record| record.start_us as f64 / 1e6),
    },
    Quantity {
        name: "tick",
        columns: &["tick"],
        unit: "",
        about: "number of the tick since boot; it jumps where records are missing",
        values: Values::U32(|record| record.tick),
    },
    Quantity {
        name: "mode",
        columns: &["mode"],
        unit: "",
        about: "what the board was doing",
        values: Values::Word(Words::Modes, mode),
    },
    Quantity {
        name: "fault",
        columns: &["fault"],
        unit: "",
        about: "why it was in mode fault",
        values: Values::Word(Words::Faults, fault),
    },
    Quantity {
        name: "guards",
        columns: &["guards"],
        unit: "",
        about: "what the supervisor changed of the wanted torque",
        values: Values::Word(Words::Guards, |r, _| usize::from(r.guards.bits()) % GUARDS),
    },
    Quantity {
        name: "reference_rad",
        columns: &["q1_ref_rad", "q2_ref_rad"],
        unit: "rad",
        about: "reference angle, at the next tick",
        values: Values::F32(|record, joint| record.reference_rad[joint]),
    },
    Quantity {
        name: "reference_speed_rad_s",
        columns: &["dq1_ref_rad_s", "dq2_ref_rad_s"],
        unit: "rad/s",
        about: "reference speed, at the next tick",
        values: Values::F32(|record, joint| record.reference_speed_rad_s[joint]),
    },
    Quantity {
        name: "angle_rad",
        columns: &["q1_rad", "q2_rad"],
        unit: "rad",
        about: "estimated angle",
        values: Values::F32(|record, joint| record.angle_rad[joint]),
    },
    Quantity {
        name: "speed_rad_s",
        columns: &["dq1_rad_s", "dq2_rad_s"],
        unit: "rad/s",
        about: "estimated speed",
        values: Values::F32(|record, joint| record.speed_rad_s[joint]),
    },
    Quantity {
        name: "count",
        columns: &["count1", "count2"],
        unit: "encoder counts",
        about: "what the servo's encoder said",
        values: Values::Sample(|record, joint| record.samples[joint].counts()),
    },
    Quantity {
        name: "missing",
        columns: &["missing1", "missing2"],
        unit: "",
        about: "why there is no count",
        values: Values::Word(Words::Missing, missing),
    },
    Quantity {
        name: "alarms",
        columns: &["alarms1", "alarms2"],
        unit: "",
        about: "alarms of a stock servo",
        values: Values::Word(Words::Alarms, |r, j| usize::from(r.alarms[j]) % ALARMS),
    },
    Quantity {
        name: "torque_nm",
        columns: &["torque1_nm", "torque2_nm"],
        unit: "N m",
        about: "torque decided in this tick, without what is added against friction",
        values: Values::F32(|record, joint| record.torque_nm[joint]),
    },
    Quantity {
        name: "disturbance_nm",
        columns: &["disturbance1_nm", "disturbance2_nm"],
        unit: "N m",
        about: "estimated disturbance torque",
        values: Values::F32(|record, joint| record.disturbance_nm[joint]),
    },
    Quantity {
        name: "pwm_in_force",
        columns: &["pwm1_in_force", "pwm2_in_force"],
        unit: "PWM counts, 1000 is off",
        about: "PWM sent at the start of this tick",
        values: Values::U16(|record, joint| record.pwm_in_force[joint]),
    },
    Quantity {
        name: "pwm_next",
        columns: &["pwm1_next", "pwm2_next"],
        unit: "PWM counts, 1000 is off",
        about: "PWM decided in this tick, sent in the next",
        values: Values::U16(|record, joint| record.pwm_next[joint]),
    },
    Quantity {
        name: "start_error_us",
        columns: &["start_error_us"],
        unit: "us",
        about: "actual minus planned start of the tick",
        values: Values::U32(|record| record.timing.start_error_us),
    },
    Quantity {
        name: "bus_us",
        columns: &["bus_us"],
        unit: "us",
        about: "from the first bit of the request to the last of the replies",
        values: Values::U32(|record| record.timing.bus_us),
    },
    Quantity {
        name: "compute_ns",
        columns: &["compute_ns"],
        unit: "ns",
        about: "time that estimator, controller and supervisor took; 0 where not measured",
        values: Values::U32(|record| record.timing.compute_ns),
    },
    Quantity {
        name: "missed_ticks",
        columns: &["missed_ticks"],
        unit: "",
        about: "ticks skipped so far",
        values: Values::U32(|record| record.timing.missed),
    },
    Quantity {
        name: "dropped_records",
        columns: &["dropped_records"],
        unit: "",
        about: "records dropped so far because the host did not fetch them in time",
        values: Values::U32(|record| record.dropped),
    },
];
