//! Conversion of a scenario file to a plan, with all checks that are possible before
//! anything moves.

use std::path::Path;

use armbridge_client::enum_names;
use armbridge_client::params;
use armbridge_shared::JOINTS;
use armbridge_shared::arm::State;
use armbridge_shared::bridge::SERVO_IDS;
use armbridge_shared::servo::Firmware;
use armbridge_sim::plant::{KeyConflict, PlantConfig, PlantFile, Push};
use armbridge_sim::servo_kind::ServoKind;
use nalgebra::Vector2;

use super::file::{BenchKeys, Expect, File, Pair, PushKeys, ServoName, StepKeys, StopKeys};
use super::mistake::{KeyPath, Mistake};
use super::steps::{self, microseconds, pairs, times};
use super::{BenchSpec, Overrides, Scenario, Success};
use crate::plan_runner::plan::{Base, Change, InitialSettings, Plan, Stop};

/// Default initial angles of the arm in rad.
pub(super) const INITIAL_RAD: [f64; JOINTS] = [0.30, -0.25];
/// Largest initial angle: inside the board's angle limit.
const INITIAL_MAX_RAD: f64 = 1.4;
/// Largest torque of a push in N m.
const PUSH_MAX_NM: f64 = 10.0;

/// Converts a file; files that it names are in `folder`.
pub(super) fn scenario(
    file: &File,
    name: &str,
    folder: Option<&Path>,
    overrides: &Overrides,
) -> Result<Scenario, Mistake> {
    let (stop, success) = stop(&file.stop, overrides)?;
    let mut change = Change {
        base: overrides.control.unwrap_or(file.control.into()),
        set: pairs(&file.set),
    };
    change.set.extend(overrides.set.iter().cloned());
    let set = KeyPath::top("set");
    let settings = change
        .apply(&overrides.board.unwrap_or_default())
        .map_err(|error| Mistake::new(set.key(error.key()), &error))?;
    params::check(&settings).map_err(|error| Mistake::new(set, error))?;
    let bench = bench(&file.bench, folder, overrides)?;
    let initial_rad: Pair = bench.plant.initial.q.map(|q| q as f32).into();
    // A shortened run omits its last steps.
    let is_kept = |step: &&StepKeys| overrides.duration_s.is_none_or(|end_s| step.at_s < end_s);
    let kept = file.step.iter().take_while(is_kept).count();
    let plan = Plan {
        begin: InitialSettings::Changed(change),
        steps: steps::steps(&file.step[..kept], stop.after_us, &settings, initial_rad)?,
        pushes: pushes(&file.bench, stop.after_us, overrides)?,
        stop,
        is_clearing: false,
        is_releasing: false,
    };
    check_expectations(&file.expect)?;
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
    })
}

fn stop(keys: &StopKeys, overrides: &Overrides) -> Result<(Stop, Vec<Success>), Mistake> {
    let place = KeyPath::top("stop");
    let after_s = overrides.duration_s.unwrap_or(keys.after_s);
    let after_us = microseconds(&place.at("after_s"), after_s)?;
    if after_us == 0 {
        return Err(Mistake::new(place.at("after_s"), "expected more than 0 s"));
    }
    for (name, angles) in [
        ("angle_beyond_rad", keys.angle_beyond_rad),
        ("error_beyond_rad", keys.error_beyond_rad),
    ] {
        let is_wrong = |angle: &f32| !(*angle > 0.0 && angle.is_finite());
        if angles.is_some_and(|angles| angles.iter().any(is_wrong)) {
            return Err(Mistake::new(place.at(name), "expected two angles above 0"));
        }
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
            let known = ends.chain(enum_names::FAULTS.map(enum_names::fault));
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

fn bench(
    keys: &BenchKeys,
    folder: Option<&Path>,
    overrides: &Overrides,
) -> Result<BenchSpec, Mistake> {
    let place = KeyPath::top("bench");
    let initial_rad = keys.initial_rad.unwrap_or(INITIAL_RAD);
    if !initial_rad.iter().all(|q| q.abs() <= INITIAL_MAX_RAD) {
        let message =
            format!("expected two angles from -{INITIAL_MAX_RAD} to {INITIAL_MAX_RAD} rad");
        return Err(Mistake::new(place.at("initial_rad"), message));
    }
    let initial_rad = overrides.initial_rad.unwrap_or(initial_rad);
    let mut plant = match (overrides.plant, &keys.plant_file, &keys.plant) {
        (Some(file), ..) => file.config(initial_rad),
        (None, Some(_), Some(_)) => {
            let message = "a scenario has one arm: `plant_file` or `[bench.plant]`";
            return Err(Mistake::new(place.at("plant_file"), message));
        }
        (None, Some(name), None) => {
            let path = folder.map_or_else(|| name.into(), |folder| folder.join(name));
            let at = place.at("plant_file");
            let file = PlantFile::read(&path).map_err(|error| Mistake::new(at, error))?;
            file.config(initial_rad)
        }
        (None, None, Some(file)) => match file.conflict() {
            Some(KeyConflict { key, message }) => {
                return Err(Mistake::new(place.at("plant").at(key), message));
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
    };
    let firmwares = keys
        .servos
        .unwrap_or([ServoName::Morpheus; JOINTS])
        .map(firmware);
    let baud = keys.baud.unwrap_or(1_000_000);
    let servos = SERVO_IDS.iter().zip(firmwares);
    let servos = servos.map(|(id, firmware)| ServoKind::new(firmware, id.get(), baud));
    let servos: Result<Vec<ServoKind>, _> = servos.collect();
    let servos = servos.map_err(|error| Mistake::new(place.at("baud"), error))?;
    Ok(BenchSpec {
        plant,
        seed: overrides.seed.or(keys.seed).unwrap_or(1),
        servos: overrides.servos.clone().unwrap_or(servos),
    })
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
        let joint = key.joint.wrapping_sub(1);
        if joint >= JOINTS {
            return Err(Mistake::new(place.at("joint"), "expected joint 1 or 2"));
        }
        if key.torque_nm.is_nan() || key.torque_nm.abs() > PUSH_MAX_NM {
            let message = format!("expected a torque from -{PUSH_MAX_NM} to {PUSH_MAX_NM} N m");
            return Err(Mistake::new(place.at("torque_nm"), message));
        }
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

fn check_expectations(expect: &Expect) -> Result<(), Mistake> {
    for (name, value) in [
        ("settles_within_s", expect.settles_within_s),
        ("rests_within_rad", expect.rests_within_rad),
        ("tracks_within_rad", expect.tracks_within_rad),
        ("recovers_within_s", expect.recovers_within_s),
        ("torque_within_nm", expect.torque_within_nm),
    ] {
        if value.is_some_and(|value| !(value > 0.0 && value.is_finite())) {
            let place = KeyPath::top("expect").at(name);
            return Err(Mistake::new(place, "expected a number above 0"));
        }
    }
    Ok(())
}
