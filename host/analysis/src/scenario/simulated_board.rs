//! Settings of a simulated board for its bench: what `armbridge calibrate` and `armbridge setup` set on
//! a real one before the first run.
//!
//! A new board has the calibration of AX-12A and the paper's arm of two joints. Without the nominal calibration
//! of the model of its X servos, and their number, it refuses to be armed. The lengths and masses of another arm with
//! X servos, or of one joint, are known from ruler and scale: its own weight is what the estimates are scaled by.
//! The inertia of a joint is mostly that of the geared rotor, so that of an X servo is assumed to be an AX-12A's in
//! the ratio of their stall torques, 1.5 times that of the arms `xl330` and `xl430`. All else of the virtual arm
//! remains unknown to the board: friction, motors. A board whose settings have been read keeps those.

use armbridge_control::arm::Parameters;
use armbridge_control::encoder::Encoder;
use armbridge_servo::Firmware;
use armbridge_sim::plant::PlantConfig;
use toml::Value;

/// Changes of a new board's settings for the servos of this arm, in the order of their application.
pub(super) fn settings(plant: &PlantConfig) -> Vec<(String, Value)> {
    let mut changes = Vec::new();
    if plant.firmware() == Firmware::XSeries {
        let nominal = [
            ("zero_count", f64::from(Encoder::XSeries.middle_count())),
            ("rad_per_count", Encoder::XSeries.nominal_rad_per_count()),
            (
                "gain_counts_per_nm",
                plant.x_servo.pwm_counts_per_nm().into(),
            ),
            ("offset_counts", 0.0),
        ];
        for joint in ["joint1", "joint2"] {
            let values = nominal.map(|(name, value)| (format!("{joint}.{name}"), value.into()));
            changes.extend(values);
        }
    }
    changes.extend(
        arm_settings(plant)
            .into_iter()
            .map(|(name, value)| (name.into(), value.into())),
    );
    changes
}

/// What is known of an arm that is not the paper's.
fn arm_settings(plant: &PlantConfig) -> Vec<(&'static str, f64)> {
    let (arm, paper) = (&plant.arm, Parameters::paper());
    let measured = Parameters {
        l1: arm.l1,
        m1: arm.m1,
        l2: arm.l2,
        m2: arm.m2,
        ..paper
    };
    let has_x_servos = plant.firmware() == Firmware::XSeries;
    let has_one_joint = arm.joints() == 1;
    if measured == paper || !(has_x_servos || has_one_joint) {
        return Vec::new();
    }
    let mut settings = vec![
        ("arm.l1_m", arm.l1),
        ("arm.m1_kg", arm.m1),
        ("arm.l2_m", arm.l2),
        ("arm.m2_kg", arm.m2),
    ];
    if has_x_servos {
        let rotor = f64::from(plant.x_servo.stall_nm) / PlantConfig::default().torque_limit_nm;
        settings.extend([
            ("arm.i1x_kg_m2", paper.i1x * rotor),
            ("arm.i2y_kg_m2", paper.i2y * rotor),
        ]);
    }
    if has_one_joint {
        settings.extend([("arm.i2x_kg_m2", 0.0), ("arm.i2z_kg_m2", 0.0)]);
    }
    settings
}

#[cfg(test)]
mod tests {
    use armbridge_board::bridge::SERVO_IDS;
    use armbridge_control::arm::Parameters;
    use armbridge_link::experiment::Role;
    use armbridge_link::message::{Command, Settings, Setup};
    use armbridge_servo::{Firmware, JOINTS};
    use armbridge_sim::plant::PlantFile;
    use armbridge_sim::servo_kind::ServoKind;

    use super::super::{Overrides, Scenario};
    use crate::plan_runner::plan::Action;

    fn identify(plant: &str, board: Option<&Settings>) -> Scenario {
        let overrides = Overrides {
            plant: Some(PlantFile::load(plant).unwrap()),
            board: board.copied(),
            ..Overrides::default()
        };
        Scenario::load("identify", &overrides).unwrap()
    }

    #[test]
    fn a_new_board_has_the_nominal_calibration_of_the_servos_of_its_arm() {
        let [ax, x] = ["heavy", "xl430"].map(|plant| identify(plant, None).settings.setup);
        assert_eq!(
            (ax.joints, ax.arm),
            (Setup::best().joints, Setup::best().arm)
        );
        assert_eq!(x.joints.map(|joint| joint.zero_count as u16), [2048; 2]);
        let read = identify("xl430", Some(&Settings::default())).settings.setup;
        assert_eq!(
            read.joints,
            Setup::default().joints,
            "that of a board that was read"
        );
    }

    #[test]
    fn a_new_board_knows_lengths_and_masses_of_an_arm_of_other_servos() {
        let arm = |plant: &str| identify(plant, None).settings.setup.arm;
        let paper = Setup::best().arm;
        assert_eq!(arm("heavy"), paper);
        let rotor = 1.4 / 1.5;
        let (inertia, xl430) = (paper.i1x * rotor, arm("xl430"));
        assert!((xl430.i1x - inertia).abs() < 1e-6 && (xl430.i2y - inertia).abs() < 1e-6);
        let measured = Parameters {
            m1: 0.05827,
            m2: 0.227,
            i1x: xl430.i1x,
            i2y: xl430.i2y,
            ..paper
        };
        assert_eq!(xl430, measured);
        assert_eq!((arm("pendulum").m2, arm("pendulum").joints()), (0.0, 1));
    }

    #[test]
    fn servos_are_those_of_the_options_then_of_the_scenario_then_of_the_arm() {
        let servos = |name: &str, overrides: &Overrides| {
            Scenario::load(name, overrides).map(|scenario| scenario.bench.servos)
        };
        let of = |firmware, baud| {
            let ids = SERVO_IDS.iter();
            let kinds = ids.map(|id| ServoKind::new(firmware, id.get(), baud).unwrap());
            kinds.collect::<Vec<ServoKind>>()
        };
        let faster = Overrides {
            servo_baud: Some(2_000_000),
            ..Overrides::default()
        };
        let own = servos("pendulum", &faster).unwrap();
        assert_eq!(own, of(Firmware::XSeries, 2_000_000));
        let arm = Overrides {
            plant: Some(PlantFile::load("xl430").unwrap()),
            ..Overrides::default()
        };
        let of_arm = servos("demo", &arm).unwrap();
        assert_eq!(of_arm, of(Firmware::XSeries, 1_000_000));
        let others = Overrides {
            firmware: Some([Firmware::Stock; JOINTS]),
            ..arm
        };
        let others = servos("demo", &others).unwrap();
        assert_eq!(others, of(Firmware::Stock, 1_000_000));
        let unknown = Overrides {
            servo_baud: Some(750_000),
            ..Overrides::default()
        };
        let error = servos("demo", &unknown).unwrap_err().to_string();
        assert!(
            error.starts_with("--servo-baud: ") && error.contains("750000"),
            "{error}"
        );
    }

    #[test]
    fn servos_of_an_option_are_on_the_arm_and_known_to_the_board() {
        let overrides = Overrides {
            firmware: Some([Firmware::XSeries; 2]),
            ..Overrides::default()
        };
        let demo = Scenario::load("demo", &overrides).unwrap();
        let (board, plant) = (demo.settings.setup, demo.bench.plant);
        assert_eq!(board.joints, plant.board_setup(board).joints);
        assert_eq!(plant.firmware(), Firmware::XSeries);
    }

    #[test]
    fn a_plan_for_one_joint_leaves_out_the_other() {
        let (one, two) = (identify("pendulum", None), identify("xl430", None));
        assert_eq!(one.settings.setup.arm.joints(), 1);
        assert!(one.plan.stop.after_us < two.plan.stop.after_us);
        assert!(one.plan.steps.len() < two.plan.steps.len());
        for step in &one.plan.steps {
            let Action::Command(command) = &step.action else {
                continue;
            };
            if let Command::Experiment(plan) = **command {
                assert!(plan.roles[0] != Role::Hold && plan.roles[1] == Role::Hold);
            }
        }
    }
}
