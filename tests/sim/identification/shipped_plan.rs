//! The plan that ships, for virtual arms: of one joint, for which what it does with joint 2 is left out;
//! of a half of the inertia that the board believes in; of noisy encoders.
//!
//! Lengths and masses are known to the board, as by ruler and scale, and the nominal calibration of the
//! servos; inertia, friction and motors are not.

use armbridge_analysis::identify::{ArmFit, Estimate, FitData, Quantity};
use armbridge_analysis::scenario::{Overrides, Scenario};
use armbridge_control::arm::Parameters;
use armbridge_link::message::{Settings, Setup};
use armbridge_servo::{Firmware, JOINTS};
use armbridge_sim::plant::{PlantConfig, PlantFile};
use armbridge_tests::plant;
use armbridge_tests::random_arms::plan::{perform, shipped};

/// A simulated board for an arm that ships, as `armbridge identify run` starts it.
fn board_for(plant: &PlantFile) -> Setup {
    let overrides = Overrides {
        plant: Some(*plant),
        ..Overrides::default()
    };
    let scenario = Scenario::load("identify", &overrides).unwrap();
    scenario.settings.setup
}

/// Identifies this arm by a board that had this set-up.
fn identified(config: &PlantConfig, board: Setup) -> (Settings, ArmFit) {
    let setup = shipped(board);
    let settings = Settings {
        setup,
        ..Settings::default()
    };
    let records = perform(setup, config, 3);
    let data = FitData::from_records(&settings, &records);
    (settings, ArmFit::new(data, 0.01).unwrap())
}

/// True value of a parameter beside the delays.
fn true_value(config: &PlantConfig, joint: usize, quantity: Quantity) -> f64 {
    quantity.nominal(&config.board_setup(Setup::default()), joint)
}

/// Estimate of a joint over its true value.
fn ratio(fit: &ArmFit, joint: usize, name: &str, truth: f64) -> f64 {
    let named = |estimate: &&Estimate| estimate.joint == joint + 1 && estimate.name == name;
    let estimate = fit.report.estimates.iter().find(named);
    estimate.expect("an estimate of that name").value / truth
}

fn is_identified(config: &PlantConfig, board: Setup) -> ArmFit {
    let (before, fit) = identified(config, board);
    println!("{}", fit.report.table());
    let joints = config.arm.joints();
    let estimates = &fit.report.estimates;
    assert!(estimates.iter().all(|estimate| estimate.joint <= joints));
    for joint in 0..joints {
        let truths = [
            (Quantity::Inertia, "inertia"),
            (Quantity::Gravity, "gravity"),
            (Quantity::Viscous, "viscous friction"),
            (Quantity::Gain, "motor gain"),
        ];
        for (quantity, name) in truths {
            let truth = true_value(config, joint, quantity);
            let ratio = ratio(&fit, joint, name, truth);
            assert!(
                (ratio - 1.0).abs() < 0.05,
                "{name} of joint {}: {ratio:.3} of the true one",
                joint + 1
            );
        }
    }
    assert_eq!(fit.report.too_uncertain(), []);
    let (after, _) = fit.adopted_by(&before).unwrap();
    assert_eq!(after.setup.arm.joints(), joints);
    for absent in joints..JOINTS {
        assert_eq!(after.setup.joints[absent], before.setup.joints[absent]);
    }
    fit
}

#[test]
fn an_arm_of_one_morpheus_servo_is_identified_by_the_plan_that_ships() {
    let config = plant([0.0, 0.0], true);
    assert_eq!(config.firmware(), Firmware::Morpheus);
    let arm = Parameters {
        l1: 0.2,
        m1: 0.3,
        l2: 0.0,
        m2: 0.0,
        i2x: 0.0,
        i2z: 0.0,
        ..Parameters::paper()
    };
    let board = Setup {
        arm: arm.map(|number| number as f32),
        ..Setup::best()
    };
    let arm = Parameters {
        i1x: 0.016,
        b1: 0.3,
        ..arm
    };
    is_identified(&PlantConfig { arm, ..config }, board);
}

#[test]
fn the_pendulum_of_one_x_servo_is_identified_by_the_plan_that_ships() {
    let plant = PlantFile::load("pendulum").unwrap();
    is_identified(&plant.config([0.0, 0.0]), board_for(&plant));
}

#[test]
fn a_light_arm_of_x_servos_is_identified_by_the_plan_that_ships() {
    let plant = PlantFile::load("xl330").unwrap();
    let (config, mut board) = (plant.config([0.0, 0.0]), board_for(&plant));
    board.arm.i1x = 2.0 * config.arm.i1x as f32;
    board.arm.i2y = 2.0 * config.arm.i2y as f32;
    let fit = is_identified(&config, board);
    for joint in 0..JOINTS {
        let ratio = ratio(&fit, joint, "load friction", 0.17);
        assert!((ratio - 1.0).abs() < 0.02, "load friction: {ratio:.3}");
    }
}

#[test]
fn an_arm_of_noisy_encoders_is_identified_by_the_plan_that_ships() {
    let plant = PlantFile::load("rough").unwrap();
    let config = plant.config([0.0, 0.0]);
    let fit = is_identified(&config, board_for(&plant));
    let (noise, rounding) = (config.noise_lsb_rms, 1.0 / 12.0);
    let expected = (noise * noise + rounding).sqrt();
    assert!((fit.result.noise_counts / expected - 1.0).abs() < 0.05);
    // The noise is that of the encoders, and no fault of the model.
    assert_eq!(fit.checks.warnings, Vec::<String>::new());
}
