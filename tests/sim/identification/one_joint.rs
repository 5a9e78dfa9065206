//! The plan that ships, for an arm of one joint: what it does with joint 2 is left out, and the
//! estimates are those of joint 1.
//!
//! Length and mass are known to the board, as by ruler and scale; inertia, friction and motor are not.

use armbridge_analysis::identify::{ArmFit, FitData};
use armbridge_control::arm::Parameters;
use armbridge_link::message::{Settings, Setup};
use armbridge_servo::Firmware;
use armbridge_sim::plant::{PlantConfig, PlantFile};
use armbridge_tests::random_arms::plan::{perform, shipped};
use armbridge_tests::{calibrations, plant};

/// Identifies this arm by a board that knows its length and mass.
fn identified(config: &PlantConfig) -> (Settings, ArmFit) {
    let known = Parameters {
        l1: config.arm.l1 as f32,
        m1: config.arm.m1 as f32,
        l2: 0.0,
        m2: 0.0,
        i2x: 0.0,
        i2z: 0.0,
        ..Parameters::paper()
    };
    let setup = shipped(Setup {
        arm: known,
        joints: calibrations(config.firmware()),
        ..Setup::best()
    });
    let settings = Settings {
        setup,
        ..Settings::default()
    };
    let records = perform(setup, config, 3);
    let data = FitData::from_records(&settings, &records);
    (settings, ArmFit::new(data, 0.01).unwrap())
}

/// Estimate of joint 1 over its true value.
fn ratio(fit: &ArmFit, name: &str, truth: f64) -> f64 {
    let named = |estimate: &&armbridge_analysis::identify::Estimate| estimate.name == name;
    let estimate = fit.report.estimates.iter().find(named);
    estimate.expect("an estimate of that name").value / truth
}

fn is_identified(config: &PlantConfig) {
    let (before, fit) = identified(config);
    println!("{}", fit.report.table());
    assert!(
        fit.report
            .estimates
            .iter()
            .all(|estimate| estimate.joint == 1)
    );
    let arm = &config.arm;
    let truths = [
        ("inertia", arm.i1x + arm.m1 * arm.l1 * arm.l1 / 4.0),
        ("gravity", arm.g * arm.m1 * arm.l1 / 2.0),
        ("viscous friction", arm.b1),
        ("motor gain", config.joints[0].gain_counts_per_nm),
    ];
    for (name, truth) in truths {
        let ratio = ratio(&fit, name, truth);
        assert!(
            (ratio - 1.0).abs() < 0.05,
            "{name}: {ratio:.3} of the true one"
        );
    }
    assert_eq!(fit.report.too_uncertain(), []);
    let (after, _) = fit.adopted_by(&before).unwrap();
    assert_eq!(after.setup.arm.joints(), 1);
    assert_eq!(after.setup.joints[1], before.setup.joints[1]);
}

#[test]
fn an_arm_of_one_morpheus_servo_is_identified_by_the_plan_that_ships() {
    let config = plant([0.0, 0.0], true);
    assert_eq!(config.firmware(), Firmware::Morpheus);
    is_identified(&PlantConfig {
        arm: Parameters {
            l1: 0.2,
            m1: 0.3,
            i1x: 0.016,
            b1: 0.3,
            l2: 0.0,
            m2: 0.0,
            i2x: 0.0,
            i2z: 0.0,
            ..Parameters::paper()
        },
        ..config
    });
}

#[test]
fn the_pendulum_of_one_x_servo_is_identified_by_the_plan_that_ships() {
    let config = PlantFile::load("pendulum").unwrap().config([0.0, 0.0]);
    is_identified(&config);
}
