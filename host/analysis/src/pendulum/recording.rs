//! Recordings of a servo on a pendulum: the public JSON format of the project BAM, one file a
//! run.
//!
//! | key                       | content                                                  |
//! |---------------------------|----------------------------------------------------------|
//! | `mass`, `length`          | load in kg, its distance from the axis in m              |
//! | `arm_mass`                | mass of the rod in kg; 0 if left out                     |
//! | `kp`                      | gain of the servo's position controller, register units  |
//! | `vin`                     | nominal supply in V                                      |
//! | `motor`                   | `xl330`, which may be left out                           |
//! | `trajectory`              | name of the goals' course; may be left out               |
//! | `entries[].timestamp`     | s, strictly increasing                                   |
//! | `entries[].position`      | rad, 0 hanging                                           |
//! | `entries[].goal_position` | rad                                                      |
//! | `entries[].speed`         | rad/s; of the first sample only, 0 if left out           |
//! | `entries[].torque_enable` | whether the motor is driven                              |
//! | `entries[].input_volts`   | V at the servo; `vin` if left out                        |
//!
//! Other keys are ignored. Whatever a file contains, reading it ends in a recording whose
//! numbers are finite and in order, or in an error that names the file and the key.

use std::path::Path;

use serde_json::Value;

/// Servo whose position controller the model has.
const MOTOR: &str = "xl330";
/// Longest recording in s: a time in another unit would be simulated for hours.
const DURATION_MAX_S: f64 = 600.0;
/// Fewest samples.
const SAMPLES_MIN: usize = 10;
/// Largest magnitude of an angle in rad, a speed in rad/s, and of all other numbers: beyond it a
/// file has another unit.
const MAGNITUDE_MAX: f64 = 1e4;

/// A run of a servo on a pendulum.
#[derive(Clone, Debug, PartialEq)]
pub struct Recording {
    /// Name of the file.
    pub name: String,
    /// Name of the goals' course; empty if the file has none.
    pub trajectory: String,
    /// Gain of the servo's position controller in register units.
    pub gain: f64,
    /// Largest torque of gravity in N m.
    pub gravity_nm: f64,
    /// Inertia of load and rod about the axis in kg m².
    pub inertia_kg_m2: f64,
    /// Speed at the first sample in rad/s.
    pub initial_speed_rad_s: f64,
    /// Samples in the order of time.
    pub samples: Vec<Sample>,
}

/// A sample of a recording.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample {
    /// Time since the first sample in s.
    pub time_s: f64,
    /// Measured angle in rad.
    pub angle_rad: f64,
    /// Goal of the position controller in rad.
    pub goal_rad: f64,
    /// Whether the motor is driven.
    pub is_driven: bool,
    /// Supply in V.
    pub supply_v: f64,
}

/// Reason for which a file is no recording.
#[derive(Debug, thiserror::Error)]
#[error("{file}: {fault}")]
pub struct RecordingError {
    /// The file as it was named.
    pub file: String,
    /// What is wrong with it.
    pub fault: Fault,
}

/// What is wrong with a file.
#[derive(Debug, thiserror::Error)]
pub enum Fault {
    /// It cannot be read.
    #[error("cannot be read: {0}")]
    Unreadable(std::io::Error),
    /// It is not JSON, or has a number beyond the range of its type.
    #[error("not JSON: {0}")]
    Json(serde_json::Error),
    /// A key is missing.
    #[error("no key {0:?}")]
    Missing(String),
    /// A value has another type.
    #[error("{key:?} is not {expected}")]
    Type {
        /// Its key.
        key: String,
        /// What it should be.
        expected: &'static str,
    },
    /// A number is out of range.
    #[error("{key:?} is {value}, not {expected}")]
    Range {
        /// Its key.
        key: String,
        /// The number.
        value: f64,
        /// What it should be.
        expected: &'static str,
    },
    /// The servo is another one.
    #[error("\"motor\" is {0:?}; the model has the position controller of \"xl330\"")]
    Motor(String),
    /// There are too few samples.
    #[error("{0} samples in \"entries\", at least {SAMPLES_MIN} are needed")]
    TooFew(usize),
    /// A time is not after the one before.
    #[error("\"entries[{index}].timestamp\" is {time_s} s, after {before_s} s: not in order")]
    Unordered {
        /// Index of the sample.
        index: usize,
        /// Its time in s.
        time_s: f64,
        /// Time of the sample before in s.
        before_s: f64,
    },
    /// It lasts too long.
    #[error("it lasts {0} s, at most {DURATION_MAX_S} s are simulated: are the times in seconds?")]
    TooLong(f64),
}

impl Recording {
    /// Name of the goals' course, in words if the file has none.
    pub fn trajectory(&self) -> &str {
        if self.trajectory.is_empty() {
            "unnamed"
        } else {
            &self.trajectory
        }
    }

    /// Reads a file.
    ///
    /// # Errors
    /// If the file cannot be read, or is not in the format.
    pub fn load(path: &Path) -> Result<Self, RecordingError> {
        let in_file = |fault| RecordingError {
            file: path.display().to_string(),
            fault,
        };
        let text =
            std::fs::read_to_string(path).map_err(|error| in_file(Fault::Unreadable(error)))?;
        let name = path.file_name().unwrap_or(path.as_os_str());
        Self::parse(&name.to_string_lossy(), &text).map_err(in_file)
    }

    /// Reads the text of a file of this name.
    ///
    /// # Errors
    /// If the text is not in the format.
    pub fn parse(name: &str, text: &str) -> Result<Self, Fault> {
        let run: Value = serde_json::from_str(text).map_err(Fault::Json)?;
        let mass_kg = positive(&run, "mass")?;
        let length_m = positive(&run, "length")?;
        let rod_kg = match run.get("arm_mass") {
            Some(_) => number(&run, "", "arm_mass")?.max(0.0),
            None => 0.0,
        };
        if let Some(motor) = run.get("motor")
            && motor != MOTOR
        {
            return Err(Fault::Motor(motor.as_str().unwrap_or("?").to_owned()));
        }
        let entries = run
            .get("entries")
            .ok_or_else(|| Fault::Missing("entries".to_owned()))?;
        let entries = entries.as_array().ok_or_else(|| Fault::Type {
            key: "entries".to_owned(),
            expected: "a list",
        })?;
        if entries.len() < SAMPLES_MIN {
            return Err(Fault::TooFew(entries.len()));
        }
        let trajectory = run.get("trajectory").and_then(Value::as_str);
        Ok(Self {
            name: name.to_owned(),
            trajectory: trajectory.unwrap_or_default().to_owned(),
            gain: positive(&run, "kp")?,
            gravity_nm: (mass_kg + rod_kg / 2.0) * length_m * super::model::GRAVITY_M_S2,
            inertia_kg_m2: (mass_kg + rod_kg / 3.0) * length_m.powi(2),
            initial_speed_rad_s: match entries[0].get("speed") {
                Some(_) => number(&entries[0], "entries[0].", "speed")?,
                None => 0.0,
            },
            samples: samples(entries, positive(&run, "vin")?)?,
        })
    }
}

/// The samples, their times from the first one on.
fn samples(entries: &[Value], nominal_v: f64) -> Result<Vec<Sample>, Fault> {
    let mut samples: Vec<Sample> = Vec::with_capacity(entries.len());
    let mut begin_s = 0.0;
    let mut before_s = f64::NEG_INFINITY;
    for (index, entry) in entries.iter().enumerate() {
        let place = format!("entries[{index}].");
        // A time may be that of a clock that began decades ago.
        let time_s = finite(entry, &place, "timestamp")?;
        if index == 0 {
            begin_s = time_s;
        }
        if time_s <= before_s {
            return Err(Fault::Unordered {
                index,
                time_s,
                before_s,
            });
        }
        before_s = time_s;
        let duration_s = time_s - begin_s;
        if duration_s > DURATION_MAX_S {
            return Err(Fault::TooLong(duration_s));
        }
        let is_driven = value(entry, &place, "torque_enable")?;
        samples.push(Sample {
            time_s: duration_s,
            angle_rad: number(entry, &place, "position")?,
            goal_rad: number(entry, &place, "goal_position")?,
            is_driven: is_driven.as_bool().ok_or_else(|| Fault::Type {
                key: format!("{place}torque_enable"),
                expected: "true or false",
            })?,
            supply_v: match entry.get("input_volts") {
                Some(_) => number(entry, &place, "input_volts")?.max(0.0),
                None => nominal_v,
            },
        });
    }
    Ok(samples)
}

/// The value of a key.
fn value<'a>(object: &'a Value, place: &str, key: &str) -> Result<&'a Value, Fault> {
    let missing = || Fault::Missing(format!("{place}{key}"));
    object.get(key).ok_or_else(missing)
}

/// A finite number.
fn finite(object: &Value, place: &str, key: &str) -> Result<f64, Fault> {
    let number = value(object, place, key)?.as_f64();
    number
        .filter(|number| number.is_finite())
        .ok_or_else(|| Fault::Type {
            key: format!("{place}{key}"),
            expected: "a number",
        })
}

/// A number of a plausible magnitude.
fn number(object: &Value, place: &str, key: &str) -> Result<f64, Fault> {
    let value = finite(object, place, key)?;
    if value.abs() <= MAGNITUDE_MAX {
        return Ok(value);
    }
    Err(Fault::Range {
        key: format!("{place}{key}"),
        value,
        expected: "within 10000 either way",
    })
}

/// A number of the run that is above zero.
fn positive(run: &Value, key: &str) -> Result<f64, Fault> {
    let value = number(run, "", key)?;
    if value > 1e-6 {
        return Ok(value);
    }
    Err(Fault::Range {
        key: key.to_owned(),
        value,
        expected: "above 0",
    })
}
