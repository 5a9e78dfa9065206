//! Conversion of a scenario file to a plan, with all checks that are possible before
//! anything moves.

use std::path::Path;

use armbridge_board::bridge::SERVO_IDS;
use armbridge_client::params;
use armbridge_client::toml_file::DocumentError;
use armbridge_control::arm::State;
use armbridge_link::message::{Fault, Settings};
use armbridge_servo::{Firmware, JOINTS};
use armbridge_sim::plant::{BuiltinPlant, KeyConflict, PlantConfig, PlantError, PlantFile, Push};
use armbridge_sim::servo_kind::ServoKind;
use nalgebra::Vector2;
use toml::Value;

use super::file::{BenchKeys, File, Pair, PushKeys, ServoName, StepKeys, StopKeys};
use super::leads::leads;
use super::mistake::{KeyPath, Mistake};
use super::narrowing::{leave_out_joint_2, narrow};
use super::simulated_board;
use super::steps::{self, microseconds, pairs, times};
use super::{BenchSpec, Overrides, Scenario, ScenarioError, Success};
use crate::plan_runner::plan::{Base, Change, InitialSettings, Plan, Stop};

/// A mistake in the file, or in an option of the command line.
#[derive(Debug)]
pub(super) enum Wrong {
    File(Mistake),
    Option(&'static str, String),
}

impl Wrong {
    /// The error, a mistake in the file with its place.
    pub(super) fn located(self, locate: impl FnOnce(Mistake) -> DocumentError) -> ScenarioError {
        match self {
            Self::File(mistake) => locate(mistake).into(),
            Self::Option(option, message) => ScenarioError::Option { option, message },
        }
    }
}

impl From<Mistake> for Wrong {
    fn from(mistake: Mistake) -> Self {
        Self::File(mistake)
    }
}

/// Converts a file; files that it names are in `folder`.
pub(super) fn scenario(
    file: &File,
    name: &str,
    folder: Option<&Path>,
    overrides: &Overrides,
) -> Result<Scenario, Wrong> {
    let (mut stop, success) = stop(&file.stop, overrides)?;
    let base = overrides.control.unwrap_or(file.control.into());
    let bench = bench(&file.bench, folder, overrides)?;
    let (change, settings) = settings(base, &pairs(&file.set), &bench.plant, overrides)?;
    let initial_rad: Pair = bench.plant.initial.q.map(|q| q as f32).into();
    // A shortened run omits its last steps.
    let is_kept = |step: &&StepKeys| overrides.duration_s.is_none_or(|end_s| step.at_s < end_s);
    let kept = file.step.iter().take_while(is_kept).count();
    if kept == 0 {
        let message = "no `[[step]]` begins before the end of the run: without one the arm is \
                       armed and falls";
        return Err(Mistake::new(KeyPath::top("step").nth(0).at("at_s"), message).into());
    }
    let mut keys = file.step[..kept].to_vec();
    let mut notes = notes(base, overrides);
    if file.is_narrowed && settings.setup.arm.joints() == 1 {
        let saved_s = leave_out_joint_2(&mut keys, stop.after_us as f64 * 1e-6);
        stop.after_us -= (saved_s * 1e6).round() as u64;
        notes.push(format!(
            "note: the arm has one joint: what the plan does with joint 2 is left out, {saved_s:.0} s"
        ));
    }
    if file.is_narrowed {
        notes.extend(narrowed(narrow(&mut keys, &settings)));
    }
    let plan = Plan {
        begin: InitialSettings::Changed(change),
        steps: steps::steps(&keys, stop.after_us, &settings, initial_rad)?,
        pushes: pushes(&file.bench, stop.after_us, overrides)?,
        leads: leads(&file.bench.hand, stop.after_us, overrides)?,
        stop,
        is_clearing: false,
        is_releasing: false,
    };
    Ok(Scenario {
        name: name.into(),
        title: file.title.clone(),
        about: file.about.clone(),
        plan,
        settings,
        baseline: file.baseline.map(Base::from),
        bench,
        success,
        expect: file.expect,
        notes,
    })
}

/// The change of the board's settings, and the settings that it makes. The configuration
/// file's parameters are in force below the scenario's where the control is the board's own, and above
/// those of a simulated board with this arm.
pub(super) fn settings(
    base: Base,
    set: &[(String, Value)],
    plant: &PlantConfig,
    overrides: &Overrides,
) -> Result<(Change, Settings), Wrong> {
    let board = overrides.board.unwrap_or_default();
    let place = KeyPath::top("set");
    let configured = if base == Base::Board {
        overrides.configured.clone()
    } else {
        Vec::new()
    };
    let of_bench = match overrides.board {
        Some(_) => Vec::new(),
        None => simulated_board::settings(plant),
    };
    let mut change = Change {
        base,
        groups: vec![of_bench, configured, set.to_vec()],
    };
    let of_file = change
        .apply(&board)
        .map_err(|error| Mistake::new(place.key(error.key()), &error))?;
    if overrides.set.is_empty() {
        params::check(&of_file).map_err(|error| Mistake::new(place, error))?;
        return Ok((change, of_file));
    }
    change.groups.push(overrides.set.clone());
    let settings = change
        .apply(&board)
        .map_err(|error| Wrong::Option("--set", error.to_string()))?;
    params::check(&settings).map_err(|error| Wrong::Option("--set", error.to_string()))?;
    Ok((change, settings))
}

/// Remarks before the run begins.
pub(super) fn notes(base: Base, overrides: &Overrides) -> Vec<String> {
    let Some((first, _)) = overrides.configured.first() else {
        return Vec::new();
    };
    if base == Base::Board {
        return Vec::new();
    }
    let more = match overrides.configured.len() - 1 {
        0 => String::new(),
        count => format!(" and {count} more"),
    };
    vec![format!(
        "note: the run has a control of its own: `{first}`{more} in armbridge.toml is not in force; \
         `--control board` puts it in force"
    )]
}

/// A remark for each joint with another factor than 1.
fn narrowed(factors: Pair) -> impl Iterator<Item = String> {
    let joints = (1..).zip(factors).filter(|(_, factor)| *factor < 1.0);
    joints.map(|(joint, factor)| {
        format!(
            "note: this board brakes joint {joint} before it is as far as the plan's envelopes: its \
             angles are {:.0} % of the plan's",
            factor * 100.0
        )
    })
}

fn stop(keys: &StopKeys, overrides: &Overrides) -> Result<(Stop, Vec<Success>), Mistake> {
    let place = KeyPath::top("stop");
    let after_s = overrides.duration_s.unwrap_or(keys.after_s);
    let after_us = microseconds(&place.at("after_s"), after_s)?;
    if after_us == 0 {
        return Err(Mistake::new(place.at("after_s"), "expected more than 0 s"));
    }
    let stop = Stop {
        after_us,
        angle_rad: keys.angle_beyond_rad,
        error_rad: keys.error_beyond_rad,
        error_for_us: microseconds(&place.at("error_for_s"), keys.error_for_s)?,
    };
    let place = place.at("success");
    let Some(names) = &keys.success else {
        return Ok((stop, vec![Success::Time]));
    };
    let success = names.iter().enumerate();
    let success = success.map(|(number, name)| {
        Success::from_name(name).ok_or_else(|| {
            let ends = ["time", "angle", "error", "fault"].into_iter();
            let known = ends.chain(Fault::ALL.map(Fault::name));
            let meant = params::nearest(name, known)
                .map_or_else(String::new, |known| format!(" Is it `{known}`?"));
            let message = format!(
                "`{name}` is no end of a run.{meant} Expected time, angle, error, fault or the \
                 name of a fault"
            );
            Mistake::new(place.nth(number), message)
        })
    });
    Ok((stop, success.collect::<Result<_, _>>()?))
}

pub(super) fn bench(
    keys: &BenchKeys,
    folder: Option<&Path>,
    overrides: &Overrides,
) -> Result<BenchSpec, Wrong> {
    let place = KeyPath::top("bench");
    let initial_rad = keys
        .initial_rad
        .unwrap_or(armbridge_sim::plant::INITIAL_RAD);
    let initial_rad = overrides.initial_rad.unwrap_or(initial_rad);
    let mut plant = match (overrides.plant, &keys.plant_file, &keys.plant) {
        (Some(file), ..) => file.config(initial_rad),
        (None, Some(_), Some(_)) => {
            let message = "a scenario has one arm: `plant_file` or `[bench.plant]`";
            return Err(Mistake::new(place.at("plant_file"), message).into());
        }
        (None, Some(name), None) => {
            let at = place.at("plant_file");
            let file = plant_file(name, folder).map_err(|error| Mistake::new(at, error))?;
            file.config(initial_rad)
        }
        (None, None, Some(file)) => match file.conflict() {
            Some(KeyConflict { key, message }) => {
                return Err(Mistake::new(place.at("plant").key(&key), message).into());
            }
            None => file.config(initial_rad),
        },
        (None, None, None) => PlantConfig {
            initial: State::at_rest(Vector2::from(initial_rad)),
            ..PlantConfig::default()
        },
    };
    if overrides.plant.is_none() {
        plant.friction_on = keys.friction.unwrap_or(plant.friction_on);
    }
    plant.friction_on = overrides.friction.unwrap_or(plant.friction_on);
    let firmware = |name| match name {
        ServoName::Morpheus => Firmware::Morpheus,
        ServoName::Stock => Firmware::Stock,
        ServoName::X => Firmware::XSeries,
    };
    let firmwares = keys.servos.map(|names| names.map(firmware));
    let firmwares = overrides.firmware.or(firmwares);
    let firmwares = firmwares.unwrap_or([plant.firmware(); JOINTS]);
    let plant = plant.with_servos(firmwares[0]);
    let baud = overrides.servo_baud.or(keys.baud).unwrap_or(1_000_000);
    let servos = SERVO_IDS.iter().zip(firmwares);
    let servos = servos.map(|(id, firmware)| ServoKind::new(firmware, id.get(), baud));
    let servos: Result<Vec<ServoKind>, _> = servos.collect();
    let servos = servos.map_err(|error| match overrides.servo_baud {
        Some(_) => Wrong::Option("--servo-baud", error.to_string()),
        None => Mistake::new(place.at("baud"), error).into(),
    })?;
    Ok(BenchSpec {
        plant,
        seed: overrides.seed.or(keys.seed).unwrap_or(1),
        servos,
    })
}

/// The virtual arm of a file in the scenario's folder, or of one that ships.
fn plant_file(name: &str, folder: Option<&Path>) -> Result<PlantFile, PlantError> {
    let beside = folder.unwrap_or(Path::new("")).join(name);
    if !beside.is_file() && BuiltinPlant::find(name).is_some() {
        return PlantFile::load(name);
    }
    Ok(PlantFile::read(&beside)?)
}

fn pushes(keys: &BenchKeys, end_us: u64, overrides: &Overrides) -> Result<Vec<Push>, Mistake> {
    // A shortened run omits its last pushes.
    let is_kept = |push: &PushKeys| overrides.duration_s.is_none_or(|end_s| push.at_s < end_s);
    let mut pushes = Vec::new();
    for (number, key) in keys.push.iter().enumerate() {
        if !is_kept(key) {
            continue;
        }
        let place = KeyPath::top("bench").at("push").nth(number);
        let joint = key.joint.saturating_sub(1);
        let duration_us = microseconds(&place.at("duration_s"), key.duration_s)?;
        let at_us = microseconds(&place.at("at_s"), key.at_s)?;
        let times = times(&place, at_us, key.every_s, end_us)?;
        pushes.extend(times.into_iter().map(|at_us| Push {
            joint,
            torque_nm: key.torque_nm,
            start_ns: at_us * 1_000,
            duration_ns: duration_us * 1_000,
        }));
    }
    pushes.sort_by_key(|push| push.start_ns);
    Ok(pushes)
}
