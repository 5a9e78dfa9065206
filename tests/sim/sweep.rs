//! Every controller with every estimator, at three periods on four arms, let go
//! at 0.49 and -0.3 rad: one table, kept in `data/sweep.txt`.
//!
//! The bench repeats to the bit, so the table changes when the code's behaviour
//! does, and a change is either meant or a mistake. `UPDATE_SNAPSHOT=1` rewrites
//! it; the difference belongs into the commit.

use std::fmt::Write;
use std::path::Path;

use armbridge_analysis::monte_carlo::{Joints, Maneuver, Outcome, Trial, for_seeds};
use armbridge_control::estimate::Config;
use armbridge_link::message::{Controller, Setup};
use armbridge_servo::JOINTS;
use armbridge_sim::plant::PlantConfig;
use armbridge_tests::{computed_torque, plant};

const INITIAL_RAD: [f64; JOINTS] = [0.49, -0.3];
const DURATION_S: f64 = 4.0;
const SEED: u64 = 1;

const HEADING: &str = "\
# Worse joint of each run: settled within 20 mrad in s, then over the last 2 s
# mean error and peak to peak in mrad, and torque in N m rms. A fault's name if
# there was one. Written by `UPDATE_SNAPSHOT=1 cargo test -p armbridge-tests --test sim sweep`.
controller      estimator   period ms  arm         settled     mean       pp  torque
";

fn controllers() -> [(&'static str, Controller); 2] {
    [
        ("lqr", Setup::best().controller),
        ("computed-torque", computed_torque(20.0).controller),
    ]
}

fn estimators() -> [(&'static str, Config<f32>); 4] {
    let difference = |filter_s| Config::FiniteDifference { filter_s };
    [
        ("difference", difference(0.0)),
        ("filtered", difference(0.02)),
        ("luenberger", Config::standing()),
        ("kalman", Config::kalman()),
    ]
}

fn arms() -> [(&'static str, PlantConfig); 4] {
    let default = plant(INITIAL_RAD, true);
    let smooth = plant(INITIAL_RAD, false);
    let dead_zone = PlantConfig {
        dead_zone_counts: [PlantConfig::PAPER_DEAD_ZONE_COUNTS; JOINTS],
        ..smooth
    };
    let weak = PlantConfig {
        torque_gain: 0.8,
        pwm_offset_counts: 15.0,
        ..default
    };
    [
        ("default", default),
        ("smooth", smooth),
        ("dead zone", dead_zone),
        ("weak motor", weak),
    ]
}

fn cases() -> Vec<(String, Trial)> {
    let mut cases = Vec::new();
    for (controller_name, controller) in controllers() {
        for (estimator_name, estimator) in estimators() {
            for period_us in [1_000, 5_000, 20_000] {
                for (arm_name, arm) in arms() {
                    let setup = Setup {
                        period_us,
                        controller,
                        estimator,
                        ..Setup::best()
                    };
                    let script = Maneuver::UPRIGHT.script(setup, DURATION_S).unwrap();
                    let period_ms = period_us / 1_000;
                    let name = format!(
                        "{controller_name:<16}{estimator_name:<12}{period_ms:>9}  {arm_name:<11}"
                    );
                    cases.push((name, Trial::new(arm, script)));
                }
            }
        }
    }
    cases
}

fn row(name: &str, outcome: &Outcome) -> String {
    let worse = |[a, b]: Joints| a.abs().max(b.abs());
    let settled = outcome
        .settling_time_s
        .map_or_else(|| "never".into(), |s| format!("{s:.2}"));
    let (mean, pp) = (outcome.mean_error_mrad, outcome.peak_to_peak_mrad);
    let fault = outcome
        .fault
        .map_or_else(String::new, |fault| format!("  {fault}"));
    format!(
        "{name}{settled:>8}{:>9.1}{:>9.1}{:>8.3}{fault}",
        worse(mean),
        worse(pp),
        worse(outcome.torque_rms_nm),
    )
}

#[test]
fn the_table_is_as_it_was() {
    let cases = cases();
    let indices: Vec<u64> = (0..cases.len() as u64).collect();
    let run = |index| {
        let (name, trial) = &cases[index as usize];
        let run = trial.run(SEED)?;
        Ok::<_, armbridge_analysis::monte_carlo::TrialError>(row(
            name,
            &Outcome::from_run(trial, SEED, &run),
        ))
    };
    let rows = for_seeds(&indices, run, |_| ()).unwrap();
    let table = format!("{HEADING}{}\n", rows.join("\n"));

    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("data/sweep.txt");
    if std::env::var_os("UPDATE_SNAPSHOT").is_some() {
        std::fs::write(&path, &table).unwrap();
    }
    let kept = std::fs::read_to_string(&path).unwrap_or_default();
    let mut changes = String::new();
    for (was, is) in kept
        .lines()
        .zip(table.lines())
        .filter(|(was, is)| was != is)
    {
        writeln!(changes, "- {was}\n+ {is}").unwrap();
    }
    assert!(
        kept == table,
        "the table has changed; if that is meant, run again with UPDATE_SNAPSHOT=1\n{changes}"
    );
}
