//! `armbridge identify pendulum` as a user meets it, with recordings of a simulated servo whose
//! parameters are known.

use std::f64::consts::TAU;

use serde_json::{Value, json};

use crate::program::Program;

/// Parameters of the simulated servo.
const STALL_NM_V: f64 = 0.1;
const BACK_EMF: f64 = 0.035;
const ROTOR_KG_M2: f64 = 0.002;
const COULOMB_NM: f64 = 0.02;
const VISCOUS: f64 = 0.006;
const LOAD: f64 = 0.12;
const LOAD_STATIC: f64 = 0.1;
const STRIBECK_RAD_S: f64 = 0.4;
const DELAY_S: f64 = 0.005;

/// The pendulum.
const MASS_KG: f64 = 0.5;
const LENGTH_M: f64 = 0.1;
const SUPPLY_V: f64 = 7.4;

/// Length of a recording, and time between its samples.
const DURATION_S: f64 = 2.0;
const PERIOD_S: f64 = 0.005;

/// Goal in rad at a time, and whether the motor is driven.
fn goal(trajectory: &str, time_s: f64) -> (f64, bool) {
    match trajectory {
        "swing" => (1.2 * (TAU * (0.4 + 0.3 * time_s) * time_s).sin(), true),
        _ => (1.4 * (3.0 * time_s).sin(), time_s < 0.8),
    }
}

/// A recording in the public format, simulated by an explicit rule in steps of 20 µs.
fn recording(trajectory: &str, gain: f64) -> Value {
    const STEP_S: f64 = 2e-5;
    let duty_per_rad = 0.0028775 * gain;
    let inertia = MASS_KG * LENGTH_M.powi(2) + ROTOR_KG_M2;
    let gravity_nm = MASS_KG * LENGTH_M * 9.80665;
    let (mut angle, mut speed) = (0.0_f64, 0.0_f64);
    let per_sample = (PERIOD_S / STEP_S).round() as usize;
    let mut entries = Vec::new();
    for step in 0..(DURATION_S / STEP_S) as usize {
        let time_s = step as f64 * STEP_S;
        if step % per_sample == 0 {
            let (goal_rad, is_driven) = goal(trajectory, time_s);
            let counts = (angle / TAU * 4096.0).round();
            entries.push(json!({
                "timestamp": time_s, "position": counts * TAU / 4096.0, "speed": speed,
                "load": 0, "input_volts": SUPPLY_V, "temp": 25,
                "goal_position": goal_rad, "torque_enable": is_driven,
            }));
        }
        let (goal_rad, is_driven) = goal(trajectory, (time_s - DELAY_S).max(0.0));
        let duty = (duty_per_rad * (goal_rad - angle)).clamp(-1.0, 1.0);
        let motor_nm = if is_driven {
            STALL_NM_V * SUPPLY_V * duty - BACK_EMF * speed
        } else {
            0.0
        };
        let weight_nm = gravity_nm * angle.sin();
        let rest = (-(speed / STRIBECK_RAD_S).powi(2)).exp();
        let limit_nm = COULOMB_NM + (LOAD + LOAD_STATIC * rest) * (motor_nm + weight_nm).abs();
        let free = speed + STEP_S * (motor_nm - weight_nm - VISCOUS * speed) / inertia;
        let most = STEP_S * limit_nm / inertia;
        speed = free - free.clamp(-most, most);
        angle += STEP_S * speed;
    }
    json!({
        "mass": MASS_KG, "length": LENGTH_M, "kp": gain, "vin": SUPPLY_V, "motor": "xl330",
        "trajectory": trajectory, "entries": entries,
    })
}

#[test]
fn a_simulated_servo_is_identified_and_load_friction_told_from_coulomb_friction() {
    let program = Program::new("pendulum");
    let mut args = vec!["identify", "pendulum"];
    let names = ["a.json", "b.json", "c.json", "d.json"];
    for (name, (trajectory, gain)) in names.into_iter().zip([
        ("swing", 200.0),
        ("drop", 200.0),
        ("swing", 600.0),
        ("drop", 600.0),
    ]) {
        program.write(name, &recording(trajectory, gain).to_string());
        args.push(name);
    }
    let found = program.json(&[&args[..], &["--json"]].concat());
    println!("{found}");
    let errors: Vec<f64> = found["forms"]
        .as_array()
        .unwrap()
        .iter()
        .map(|form| form["fitted_deg"].as_f64().unwrap())
        .collect();
    // Half a count is 0.04 degrees.
    assert!(errors[0] > 3.0 * errors[2], "{errors:?}");
    assert!(errors[2] < 0.1, "{errors:?}");
    let torque_constant = BACK_EMF / STALL_NM_V;
    for (name, expected) in [
        ("torque constant / resistance", STALL_NM_V),
        ("back-EMF damping, driven", BACK_EMF),
        ("rotor and gear inertia", ROTOR_KG_M2),
        ("Coulomb friction", COULOMB_NM),
        ("viscous friction", VISCOUS),
        ("delay of goals", DELAY_S),
        ("load friction", LOAD),
        ("load friction at rest, more", LOAD_STATIC),
        ("Stribeck speed", STRIBECK_RAD_S),
        ("torque constant", torque_constant),
        ("winding resistance", torque_constant / STALL_NM_V),
    ] {
        let estimates = found["estimates"].as_array().unwrap();
        let estimate = estimates.iter().find(|it| it["name"] == name).unwrap();
        let [value, half_width] =
            ["value", "half_width_95"].map(|key| estimate[key].as_f64().unwrap());
        let error = (value - expected).abs();
        // The simulation's steps of 1 ms act as half a step of delay.
        let bias = if name == "delay of goals" {
            0.5e-3
        } else {
            0.0
        };
        assert!(half_width > 0.0, "{name} is never certain");
        assert!(
            error < (2.0 * half_width).max(0.05 * expected) + bias,
            "{name}: {value} ± {half_width}, not {expected}"
        );
    }
}

type Change = fn(&mut Value);

#[test]
fn files_that_are_no_recordings_are_named_with_what_is_wrong() {
    let program = Program::new("pendulum-refused");
    let good = || {
        json!({
            "mass": 0.5, "length": 0.1, "kp": 200, "vin": 7.4,
            "entries": (0..20).map(|i| json!({
                "timestamp": 0.005 * f64::from(i), "position": 0.0, "goal_position": 0.0,
                "torque_enable": true,
            })).collect::<Vec<_>>(),
        })
    };
    let changes: [(Change, &str); 9] = [
        (|run| *run = json!([1, 2]), "no key \"mass\""),
        (
            |run| run["mass"] = json!(-1.0),
            "\"mass\" is -1, not above 0",
        ),
        (
            |run| run["motor"] = json!("mx106"),
            "\"motor\" is \"mx106\"",
        ),
        (|run| run["entries"] = json!([]), "0 samples in \"entries\""),
        (|run| run["entries"] = json!(7), "\"entries\" is not a list"),
        (
            |run| run["entries"][7]["position"] = json!("far"),
            "\"entries[7].position\" is not a number",
        ),
        (
            |run| run["entries"][7]["goal_position"] = json!(1e9),
            "\"entries[7].goal_position\" is 1000000000",
        ),
        (
            |run| run["entries"][7]["timestamp"] = json!(0.01),
            "\"entries[7].timestamp\" is 0.01 s, after 0.03 s: not in order",
        ),
        (
            |run| run["entries"][19]["timestamp"] = json!(5000.0),
            "it lasts 5000 s",
        ),
    ];
    for (change, words) in changes {
        let mut run = good();
        change(&mut run);
        program.write("poor.json", &run.to_string());
        program.refuses(
            &["identify", "pendulum", "poor.json"],
            &["poor.json", words],
        );
    }
    for (text, words) in [
        ("{\"mass\": 0.5,", "not JSON"),
        ("{\"mass\": 1e999}", "\"mass\" is not a number"),
    ] {
        program.write("poor.json", text);
        program.refuses(
            &["identify", "pendulum", "poor.json"],
            &["poor.json", words],
        );
    }
    program.refuses(&["identify", "pendulum", "none.json"], &["none.json"]);
    program.write("good.json", &good().to_string());
    program.refuses(
        &["identify", "pendulum", "good.json"],
        &["at least 4 recordings are needed, not 1"],
    );
}
