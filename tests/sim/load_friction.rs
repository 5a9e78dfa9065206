//! Friction that grows with the load on the gears: control with and without it in the board's model, on
//! the arm of two XL330, by the true motion of the arm.
//!
//! `cargo test --release -p armbridge-tests --test sim load_friction -- --nocapture` prints the table of
//! the book.

use armbridge_analysis::monte_carlo::{Joints, Maneuver, Outcome, Trial, for_seeds};
use armbridge_control::estimate::{Config, Tuning};
use armbridge_link::message::{Controller, Setup};
use armbridge_servo::JOINTS;
use armbridge_sim::plant::{PlantConfig, PlantFile};

/// Seeds of the encoders' noise.
const SEEDS: [u64; 5] = [1, 2, 3, 4, 5];
/// Angles in rad at which the arm is held: it leans, and its gears carry it.
const LEANING: &str = "step:0.7,-0.6";
/// Both joints swing by 0.7 rad, through postures with little load and with much.
const SWING: &str = "sine:0.7,0.7,0.4";
/// Coulomb friction in N m of which the best is compared: from the plant's own to beyond the most that
/// its load adds.
const COULOMB_NM: [f32; 6] = [0.01, 0.02, 0.03, 0.04, 0.05, 0.06];

fn arm() -> PlantConfig {
    PlantFile::load("xl330").unwrap().config([0.0; JOINTS])
}

/// The board knows the arm, and this much of its friction.
fn setup(coulomb_nm: f32, load_percent: u8, estimator: Option<Config<f32>>) -> Setup {
    let tuning = Tuning {
        // Half a count of noise, and its rounding.
        angle_rad: 0.0009,
        coulomb_nm,
        ..Tuning::standing()
    };
    Setup {
        friction_nm: [coulomb_nm; JOINTS],
        friction_load_percent: [load_percent; JOINTS],
        estimator: estimator.unwrap_or(Config::Kalman(tuning)),
        ..arm().board_setup(Setup::best())
    }
}

fn worst(outcomes: &[Outcome], figure: impl Fn(&Outcome) -> Joints) -> f64 {
    let figures = outcomes.iter().flat_map(figure);
    figures.map(f64::abs).fold(0.0, f64::max)
}

fn outcomes(setup: Setup, maneuver: &str) -> Vec<Outcome> {
    let maneuver: Maneuver = maneuver.parse().unwrap();
    let trial = Trial::new(arm(), maneuver.script(setup, 10.0).unwrap());
    let one = |seed| {
        let run = trial.run(seed);
        run.map(|run| Outcome::from_run(&trial, seed, &run))
    };
    let outcomes = for_seeds(&SEEDS, one, |_| ()).unwrap();
    for outcome in &outcomes {
        assert_eq!(outcome.fault, None, "{outcome:?}");
    }
    outcomes
}

/// Errors in mrad of the worst joint and seed.
#[derive(Clone, Copy, Debug)]
struct Errors {
    /// Mean at rest, leaning.
    rest: f64,
    /// Peak to peak at rest.
    peak_to_peak: f64,
    /// Root mean square while it swings.
    swing: f64,
}

fn errors(setup: Setup) -> Errors {
    let leaning = outcomes(setup, LEANING);
    let tracking = Setup {
        controller: Controller::ComputedTorque {
            natural_rad_s: [20.0; JOINTS],
            damping: [1.0; JOINTS],
        },
        ..setup
    };
    let swinging = outcomes(tracking, SWING);
    Errors {
        rest: worst(&leaning, |it| it.mean_error_mrad),
        peak_to_peak: worst(&leaning, |it| it.peak_to_peak_mrad),
        swing: worst(&swinging, |it| it.tracking_rms_mrad.unwrap()),
    }
}

#[test]
fn with_the_load_in_the_model_an_arm_of_small_servos_follows_closer() {
    let observer = Some(Config::standing());
    let mut rows = Vec::new();
    for (name, estimator) in [("Kalman", None), ("Luenberger", observer)] {
        let row = |friction: &str, coulomb_nm, load_percent| {
            let errors = errors(setup(coulomb_nm, load_percent, estimator));
            let Errors {
                rest,
                peak_to_peak,
                swing,
            } = errors;
            println!("{name:10} {friction:20} {rest:6.2} {peak_to_peak:6.2} {swing:6.2} mrad");
            errors
        };
        let none = row("none", 0.0, 0);
        let coulomb = COULOMB_NM.map(|nm| row(&format!("Coulomb {nm} N m"), nm, 0));
        let load = row("Coulomb and load", 0.01, 17);
        rows.push((none, coulomb, load));
    }
    for (none, coulomb, load) in rows {
        let best_swing = coulomb.iter().map(|it| it.swing).fold(f64::MAX, f64::min);
        assert!(load.swing < none.swing);
        assert!(load.swing < 0.8 * coulomb[0].swing, "{load:?}");
        assert!(load.swing < best_swing, "{load:?}, {best_swing}");
    }
}
