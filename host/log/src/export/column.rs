//! Columns of a record: one table for every file format.
//!
//! A quantity is one column, or one for each joint; values are those of the
//! [`Record`], to the bit. An enum or a set of bits is a word: an index into a list of
//! [`Words`], whose first is empty for no value.

use armbridge_client::enum_names;
use armbridge_shared::link::message::{Guards, Record};

/// A quantity of every tick.
#[derive(Clone, Copy, Debug)]
pub struct Quantity {
    /// Its name for both joints.
    pub name: &'static str,
    /// Names of its columns: one, or one for each joint.
    pub columns: &'static [&'static str],
    /// As `rad`, `N m`; empty for words and plain numbers.
    pub unit: &'static str,
    /// Meaning, as a sentence without a full stop.
    pub about: &'static str,
    /// Values.
    pub values: Values,
}

/// Access to the values of a quantity; with the index of the joint, where there is one
/// for each.
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
    /// Limiters that changed the torque, the first for none.
    Guards,
    /// Reasons for a missing sample, the first for none.
    Missing,
    /// A stock servo's alarms, the first for none.
    Alarms,
}

/// Number of combinations of limiters, and of alarms.
const GUARDS: usize = 1 << 4;
const ALARMS: usize = 1 << 7;

impl Words {
    /// All words of the list, in order.
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
                let text = |bits: usize| {
                    let set = guards.into_iter().filter(|g| bits & g.bits() as usize != 0);
                    enum_names::guards(set.fold(Guards::NONE, Guards::or))
                };
                (0..GUARDS).map(text).collect()
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

    /// Whether the first word is empty.
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
    enum_names::fault_of(record.mode).map_or(0, |fault| word_index(&enum_names::FAULTS, &fault))
}

fn missing(record: &Record, joint: usize) -> usize {
    let missing = record.samples[joint].missing();
    missing.map_or(0, |kind| word_index(&enum_names::MISSING, &kind))
}

/// Index in a list whose words begin with an empty one.
fn word_index<T: PartialEq>(list: &[T], value: &T) -> usize {
    list.iter()
        .position(|one| one == value)
        .map_or(0, |at| at + 1)
}

/// `"name" [columns] "unit" "meaning" values;` of each quantity.
macro_rules! quantities {
    ($($name:literal $columns:tt $unit:literal $about:literal $values:expr;)*) => {
        [$(Quantity {
            name: $name,
            columns: &$columns,
            unit: $unit,
            about: $about,
            values: $values,
        }),*]
    };
}

/// All quantities of a record.
pub const QUANTITIES: [Quantity; 21] = quantities! {
    "time_s" ["time_s"] "s"
        "start of the tick on the board's clock"
        Values::F64(|r| r.start_us as f64 / 1e6);
    "tick" ["tick"] ""
        "number of the tick since boot; it jumps where records are missing"
        Values::U32(|r| r.tick);
    "mode" ["mode"] ""
        "mode of the board"
        Values::Word(Words::Modes, mode);
    "fault" ["fault"] ""
        "fault, in mode fault"
        Values::Word(Words::Faults, fault);
    "guards" ["guards"] ""
        "limiters that changed the wanted torque"
        Values::Word(Words::Guards, |r, _| usize::from(r.guards.bits()) % GUARDS);
    "reference_rad" ["q1_ref_rad", "q2_ref_rad"] "rad"
        "reference angle, at the next tick"
        Values::F32(|r, j| r.reference_rad[j]);
    "reference_speed_rad_s" ["dq1_ref_rad_s", "dq2_ref_rad_s"] "rad/s"
        "reference speed, at the next tick"
        Values::F32(|r, j| r.reference_speed_rad_s[j]);
    "angle_rad" ["q1_rad", "q2_rad"] "rad"
        "estimated angle"
        Values::F32(|r, j| r.angle_rad[j]);
    "speed_rad_s" ["dq1_rad_s", "dq2_rad_s"] "rad/s"
        "estimated speed"
        Values::F32(|r, j| r.speed_rad_s[j]);
    "count" ["count1", "count2"] "encoder counts"
        "reading of the servo's encoder"
        Values::Sample(|r, j| r.samples[j].counts());
    "missing" ["missing1", "missing2"] ""
        "reason for a missing count"
        Values::Word(Words::Missing, missing);
    "alarms" ["alarms1", "alarms2"] ""
        "alarms of a stock servo"
        Values::Word(Words::Alarms, |r, j| usize::from(r.alarms[j]) % ALARMS);
    "torque_nm" ["torque1_nm", "torque2_nm"] "N m"
        "torque decided in this tick, without what is added against friction"
        Values::F32(|r, j| r.torque_nm[j]);
    "disturbance_nm" ["disturbance1_nm", "disturbance2_nm"] "N m"
        "estimated disturbance torque"
        Values::F32(|r, j| r.disturbance_nm[j]);
    "pwm_in_force" ["pwm1_in_force", "pwm2_in_force"] "PWM counts, 1000 is off"
        "PWM sent at the start of this tick"
        Values::U16(|r, j| r.pwm_in_force[j]);
    "pwm_next" ["pwm1_next", "pwm2_next"] "PWM counts, 1000 is off"
        "PWM decided in this tick, sent in the next"
        Values::U16(|r, j| r.pwm_next[j]);
    "start_error_us" ["start_error_us"] "us"
        "actual minus planned start of the tick"
        Values::U32(|r| r.timing.start_error_us);
    "bus_us" ["bus_us"] "us"
        "from the first bit of the request to the last of the replies"
        Values::U32(|r| r.timing.bus_us);
    "compute_ns" ["compute_ns"] "ns"
        "time that estimator, controller and supervisor took; 0 where not measured"
        Values::U32(|r| r.timing.compute_ns);
    "missed_ticks" ["missed_ticks"] ""
        "ticks skipped so far"
        Values::U32(|r| r.timing.missed);
    "dropped_records" ["dropped_records"] ""
        "records dropped so far because the host did not fetch them in time"
        Values::U32(|r| r.dropped);
};
