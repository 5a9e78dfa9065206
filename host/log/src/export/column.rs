//! Columns of a tick: one table for every file format, and for the fields of `/telemetry` and
//! `/simulation/state` in a log. [`markdown`] is the same table in the book.
//!
//! A quantity is one column, or one for each joint, numbered from 1; values are those of the
//! [`Record`] or of the [`TrueState`], to the bit. An enum or a set of bits is a word: an index
//! into a list of [`Words`], whose first is empty for no value.

use std::fmt::Write as _;

use armbridge_client::enum_names;
use armbridge_client::simulation::TrueState;
use armbridge_link::message::{Fault, Guards, Record};

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
    /// Real numbers of a simulated arm, which no board measures; missing where its true state
    /// is not known.
    Truth(fn(&TrueState, usize) -> f32),
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
                let faults = Fault::ALL.into_iter().map(Fault::name);
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
    enum_names::fault_of(record.mode).map_or(0, |fault| word_index(&Fault::ALL, &fault))
}

fn missing(record: &Record, joint: usize) -> usize {
    let missing = record.input.samples[joint].missing();
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

/// All quantities of a tick; those of a simulated arm last.
pub const QUANTITIES: [Quantity; 26] = quantities! {
    "time_s" ["time_s"] "s"
        "start of the tick on the board's clock"
        Values::F64(|r| r.input.start_us as f64 / 1e6);
    "tick" ["tick"] ""
        "number of the tick since boot; it jumps where records are missing"
        Values::U32(|r| r.tick);
    "board_mode" ["board_mode"] ""
        "mode of the board"
        Values::Word(Words::Modes, mode);
    "fault" ["fault"] ""
        "fault, in mode fault"
        Values::Word(Words::Faults, fault);
    "guards" ["guards"] ""
        "limiters that changed the wanted torque"
        Values::Word(Words::Guards, |r, _| usize::from(r.output.guards.bits()) % GUARDS);
    "reference_rad" ["reference_rad_1", "reference_rad_2"] "rad"
        "reference angle, at the next tick"
        Values::F32(|r, j| r.output.reference_rad[j]);
    "reference_speed_rad_s" ["reference_speed_rad_s_1", "reference_speed_rad_s_2"] "rad/s"
        "reference speed, at the next tick"
        Values::F32(|r, j| r.output.reference_speed_rad_s[j]);
    "angle_rad" ["angle_rad_1", "angle_rad_2"] "rad"
        "estimated angle"
        Values::F32(|r, j| r.output.angle_rad[j]);
    "speed_rad_s" ["speed_rad_s_1", "speed_rad_s_2"] "rad/s"
        "estimated speed"
        Values::F32(|r, j| r.output.speed_rad_s[j]);
    "encoder_counts" ["encoder_counts_1", "encoder_counts_2"] "encoder counts"
        "reading of the servo's encoder"
        Values::Sample(|r, j| r.input.samples[j].counts());
    "missing" ["missing_1", "missing_2"] ""
        "reason for a missing count"
        Values::Word(Words::Missing, missing);
    "alarms" ["alarms_1", "alarms_2"] ""
        "alarms of a stock servo"
        Values::Word(Words::Alarms, |r, j| usize::from(r.input.alarms[j]) % ALARMS);
    "torque_nm" ["torque_nm_1", "torque_nm_2"] "N m"
        "torque decided in this tick, without what is added against friction"
        Values::F32(|r, j| r.output.torque_nm[j]);
    "disturbance_nm" ["disturbance_nm_1", "disturbance_nm_2"] "N m"
        "estimated disturbance torque"
        Values::F32(|r, j| r.output.disturbance_nm[j]);
    "pwm_counts" ["pwm_counts_1", "pwm_counts_2"] "PWM counts, 1000 is off"
        "PWM sent at the start of this tick"
        Values::U16(|r, j| r.input.pwm_in_force[j]);
    "pwm_next_counts" ["pwm_next_counts_1", "pwm_next_counts_2"] "PWM counts, 1000 is off"
        "PWM decided in this tick, sent in the next"
        Values::U16(|r, j| r.output.pwm[j]);
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
    "true_angle_rad" ["true_angle_rad_1", "true_angle_rad_2"] "rad"
        "true angle at the start of the tick"
        Values::Truth(|state, j| state.angle_rad[j]);
    "true_speed_rad_s" ["true_speed_rad_s_1", "true_speed_rad_s_2"] "rad/s"
        "true speed at the start of the tick"
        Values::Truth(|state, j| state.speed_rad_s[j]);
    "true_torque_nm" ["true_torque_nm_1", "true_torque_nm_2"] "N m"
        "true torque of the motor at the start of the tick"
        Values::Truth(|state, j| state.torque_nm[j]);
    "true_friction_nm" ["true_friction_nm_1", "true_friction_nm_2"] "N m"
        "torque of dry friction, with the sign of its effect"
        Values::Truth(|state, j| state.friction_nm[j]);
    "true_push_nm" ["true_push_nm_1", "true_push_nm_2"] "N m"
        "torque of pushes and hands"
        Values::Truth(|state, j| state.push_nm[j]);
};

/// Fields of `/telemetry` that are no columns: name, unit and meaning.
pub const TELEMETRY_ONLY: [[&str; 3]; 5] = [
    [
        "measured_rad_1",
        "rad",
        "angle of the sample, by the settings in force",
    ],
    [
        "measured_rad_2",
        "rad",
        "angle of the sample, by the settings in force",
    ],
    ["host_ns", "ns", "when the host read the record"],
    ["sequence", "", "number of its frame, modulo 65 536"],
    [
        "replay",
        "",
        "inputs and outputs that only a replay needs, in the encoding of the link",
    ],
];

/// A column of a file.
#[derive(Clone, Copy, Debug)]
pub struct Column {
    /// Its name.
    pub name: &'static str,
    /// Its unit.
    pub unit: &'static str,
    /// Meaning, as a sentence without a full stop.
    pub about: &'static str,
    /// Its values.
    pub values: Values,
    /// Index of the joint.
    pub joint: usize,
}

impl Column {
    /// All columns in order; those of a simulated arm only where its true states are known.
    pub fn all(has_true_states: bool) -> Vec<Self> {
        let is_known =
            |quantity: &&Quantity| has_true_states || !matches!(quantity.values, Values::Truth(_));
        let columns = QUANTITIES.iter().filter(is_known).flat_map(|quantity| {
            let names = quantity.columns.iter().enumerate();
            names.map(|(joint, name)| Self {
                name,
                unit: quantity.unit,
                about: quantity.about,
                values: quantity.values,
                joint,
            })
        });
        columns.collect()
    }
}

/// The columns as a table in Markdown, ending in a line feed.
pub fn markdown() -> String {
    let mut text = String::from("| column | unit | meaning |\n|---|---|---|\n");
    let mut row = |names: &[&str], unit: &str, about: &str| {
        let names: Vec<_> = names.iter().map(|name| format!("`{name}`")).collect();
        // Writing to a string cannot fail.
        let _ = writeln!(text, "| {} | {unit} | {about} |", names.join(", "));
    };
    for quantity in &QUANTITIES {
        let about = match quantity.values {
            Values::Truth(_) => format!("simulated arm: {}", quantity.about),
            _ => quantity.about.to_owned(),
        };
        row(quantity.columns, quantity.unit, &about);
    }
    for [name, unit, about] in TELEMETRY_ONLY {
        row(&[name], unit, &format!("MCAP only: {about}"));
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_book_has_the_same_table() {
        let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../doc/src/logs.md");
        let book = std::fs::read_to_string(path).unwrap();
        let table = markdown();
        let start = book.find(table.lines().next().unwrap()).unwrap();
        let end = book[start..].find("\n\n").unwrap() + start + 1;
        if std::env::var_os("UPDATE_SNAPSHOT").is_some() {
            let book = format!("{}{table}{}", &book[..start], &book[end..]);
            std::fs::write(path, book).unwrap();
        } else {
            assert_eq!(&book[start..end], table, "run again with UPDATE_SNAPSHOT=1");
        }
    }

    #[test]
    fn a_name_has_its_unit_and_stands_once() {
        let columns = Column::all(true);
        assert_eq!(columns.len(), 42);
        let mut names: Vec<_> = columns.iter().map(|column| column.name).collect();
        names.sort_unstable();
        names.dedup();
        assert_eq!(names.len(), columns.len());
        for Column { name, unit, .. } in columns {
            let suffix = match unit {
                "rad" => "_rad",
                "rad/s" => "_rad_s",
                "N m" => "_nm",
                "s" => "_s",
                "us" => "_us",
                "ns" => "_ns",
                "encoder counts" | "PWM counts, 1000 is off" => "_counts",
                _ => continue,
            };
            let quantity = name.trim_end_matches("_1").trim_end_matches("_2");
            assert!(quantity.ends_with(suffix), "{name} in {unit}");
        }
    }
}
