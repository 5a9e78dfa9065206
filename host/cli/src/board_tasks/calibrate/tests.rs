//! Calibration of an arm on the bench that is moved by pushes, as by hands.

use std::cell::RefCell;
use std::collections::VecDeque;
use std::rc::Rc;
use std::sync::mpsc::{Sender, channel};

use armbridge_board::bridge::Channels;
use armbridge_board::store::Store;
use armbridge_client::Host;
use armbridge_control::actuator::{Direction, Joint};
use armbridge_control::encoder::Encoder;
use armbridge_link::message::{Settings, Setup};
use armbridge_servo::protocol2::model;
use armbridge_servo::{ControlMode, Firmware, JOINTS};
use armbridge_sim::Bench;
use armbridge_sim::board::{VirtualBoard, blank_flash};
use armbridge_sim::cosim::{Cosim, CosimError, Interaction};
use armbridge_sim::plant::{Plant, PlantConfig, Push};
use armbridge_sim::servo_kind::ServoKind;

use super::{Calibrate, CalibrationOptions, Guide};
use crate::board_tasks::{TaskError, TaskHost};

/// Torque of a hand in N m: more than friction holds.
const HAND_NM: f64 = 0.45;

/// Lines shown to the person, and the person's answers.
#[derive(Clone, Default)]
struct Talk(Rc<RefCell<(Vec<String>, VecDeque<String>)>>);

impl Guide for Talk {
    fn say(&mut self, line: &str) {
        self.0.borrow_mut().0.push(line.into());
    }

    fn show(&mut self, _line: &str) {}

    fn answer(&mut self) -> Result<Option<String>, TaskError> {
        Ok(self.0.borrow_mut().1.pop_front())
    }
}

/// Follows the instructions, an instant later; where the arm is to be turned, pushes joint
/// `turns[joint]` and answers when it has come to rest.
struct Person {
    host: TaskHost<Calibrate<Talk>>,
    talk: Talk,
    turns: [usize; JOINTS],
    model: &'static str,
    seen: usize,
    hands: Sender<Interaction>,
    answer_at_us: Option<u64>,
}

impl Person {
    fn do_as_told(&mut self, now_us: u64) {
        let next = self.talk.0.borrow().0.get(self.seen).cloned();
        if let Some(line) = next {
            self.seen += 1;
            if line.contains("turn it alone") {
                let joint = usize::from(line.starts_with("Joint 2"));
                let push = Push {
                    joint: self.turns[joint],
                    torque_nm: HAND_NM,
                    start_ns: now_us * 1_000,
                    duration_ns: 150_000_000,
                };
                self.hands.send(Interaction::Push(push)).unwrap();
                self.answer_at_us = Some(now_us + 3_000_000);
            } else if line.contains("Model of these") {
                self.talk.0.borrow_mut().1.push_back(self.model.into());
            } else if line.contains("press Enter") || line.contains("[y/N]") {
                self.answer_at_us = Some(now_us + 10_000);
            }
        }
        if self
            .answer_at_us
            .take_if(|at_us| now_us >= *at_us)
            .is_some()
        {
            self.talk.0.borrow_mut().1.push_back("y".into());
        }
    }
}

impl Host for Person {
    type Error = TaskError;

    fn transmit(&mut self, now_us: u64) -> Result<&[u8], TaskError> {
        self.do_as_told(now_us);
        self.host.transmit(now_us)
    }

    fn receive(&mut self, now_us: u64, bytes: &[u8]) -> Result<(), TaskError> {
        self.host.receive(now_us, bytes)
    }

    fn wake_at_us(&self) -> u64 {
        self.host.wake_at_us()
    }

    fn is_done(&self) -> bool {
        self.host.is_done()
    }
}

/// Joints, servos and motions of a calibration.
struct Case {
    joints: [Joint<f64>; JOINTS],
    firmware: Firmware,
    /// Joint that a person turns who is asked for each.
    turns: [usize; JOINTS],
    checks_motors: bool,
    /// Settings of the board that are no defaults.
    setup: Setup,
    mode: Option<ControlMode>,
    /// Name of the servos' model.
    model: &'static str,
}

impl Default for Case {
    fn default() -> Self {
        Self {
            joints: [Joint::paper(); JOINTS],
            firmware: Firmware::Morpheus,
            turns: [0, 1],
            checks_motors: false,
            setup: Setup::default(),
            mode: None,
            model: "xl430",
        }
    }
}

/// Calibrates an arm that lies on a table: no gravity, much friction, not held.
fn calibrated(case: &Case) -> (Person, Result<(), TaskError>) {
    let config = PlantConfig {
        arm: case.setup.arm.map(f64::from),
        gravity_scale: 0.0,
        held: false,
        joints: case.joints,
        x_servo: model::find(1200).unwrap(),
        ..PlantConfig::default()
    };
    let talk = Talk::default();
    let (hands, interactions) = channel();
    let calibration = CalibrationOptions {
        mode: case.mode,
        joints: [true; JOINTS],
        checks_motors: case.checks_motors,
        is_sure: false,
    };
    let person = Person {
        host: TaskHost::new(Calibrate::new(talk.clone(), calibration)),
        talk,
        turns: case.turns,
        model: case.model,
        seen: 0,
        hands,
        answer_at_us: None,
    };
    let servos = [1, 2].map(|id| ServoKind::new(case.firmware, id, 1_000_000).unwrap());
    let bench = Bench::with_servos(Plant::new(config, 1), &servos);
    let mut store = Store::new(blank_flash());
    store
        .save(&Settings {
            setup: case.setup,
            ..Settings::default()
        })
        .unwrap();
    let mut channels = Channels::new();
    let board = VirtualBoard::with_flash(channels.split(), store.flash().clone()).unwrap();
    let mut cosim = Cosim::new(board, bench, person).with_interactions(interactions);
    let result = cosim.run().map_err(|error| match error {
        CosimError::Host(error) => error,
        CosimError::Board(never) => match never {},
    });
    (cosim.host, result)
}

fn mounted(zero_count: f64, direction: Direction) -> Joint<f64> {
    Joint {
        zero_count,
        direction,
        ..Joint::paper()
    }
}

#[test]
fn zeros_and_signs_are_found_and_saved() {
    let joints = [
        mounted(530.0, Direction::Forward),
        mounted(490.0, Direction::Reverse),
    ];
    let (person, result) = calibrated(&Case {
        joints,
        checks_motors: true,
        ..Case::default()
    });
    let dialogue = person.talk.0.borrow().0.join("\n");
    result.unwrap_or_else(|error| panic!("{error}\n{dialogue}"));
    let [before, after] = person.host.task.result().unwrap();
    assert_eq!(before, [Joint::paper(); JOINTS]);
    assert_found(&after, &joints);
    // The board reports its settings in force.
    let settings = person.host.session.status().settings.unwrap();
    assert_eq!(settings.setup.joints, after);
    assert_eq!(dialogue.matches("as it should").count(), 2, "{dialogue}");
}

#[track_caller]
fn assert_found(found: &[Joint<f32>], there: &[Joint<f64>]) {
    for (found, there) in found.iter().zip(there) {
        let off = f64::from(found.zero_count) - there.zero_count;
        assert!(off.abs() < 1.0, "{off} counts off");
        assert_eq!(found.direction, there.direction);
        assert!((f64::from(found.rad_per_count) - there.rad_per_count).abs() < 1e-9);
        let gain = f64::from(found.gain_counts_per_nm);
        assert!(
            (gain / there.gain_counts_per_nm - 1.0).abs() < 1e-3,
            "{gain}"
        );
    }
}

/// Joints of two XL430.
fn x_joints() -> [Joint<f64>; JOINTS] {
    let mounted = |zero_count, direction| Joint {
        zero_count,
        direction,
        rad_per_count: Encoder::XSeries.nominal_rad_per_count(),
        gain_counts_per_nm: 714.286,
        offset_counts: 0.0,
    };
    [
        mounted(2_100.0, Direction::Forward),
        mounted(1_950.0, Direction::Reverse),
    ]
}

#[test]
fn a_board_whose_calibration_is_of_other_servos_asks_for_the_model() {
    let joints = x_joints();
    let (person, result) = calibrated(&Case {
        joints,
        firmware: Firmware::XSeries,
        ..Case::default()
    });
    let dialogue = person.talk.0.borrow().0.join("\n");
    result.unwrap_or_else(|error| panic!("{error}\n{dialogue}"));
    assert_eq!(dialogue.matches("Model of these").count(), 1, "{dialogue}");
    let [_, after] = person.host.task.result().unwrap();
    assert_found(&after, &joints);
    // A calibration that is of these servos is renewed without the question.
    let setup = Setup {
        joints: after,
        ..Setup::default()
    };
    let (person, result) = calibrated(&Case {
        joints,
        firmware: Firmware::XSeries,
        checks_motors: true,
        setup,
        ..Case::default()
    });
    let dialogue = person.talk.0.borrow().0.join("\n");
    result.unwrap_or_else(|error| panic!("{error}\n{dialogue}"));
    assert!(!dialogue.contains("Model of these"), "{dialogue}");
    assert_eq!(dialogue.matches("as it should").count(), 2, "{dialogue}");
}

#[test]
fn another_control_mode_begins_with_the_current_of_a_model() {
    let joints = x_joints();
    let case = |model| Case {
        joints,
        firmware: Firmware::XSeries,
        checks_motors: true,
        mode: Some(ControlMode::Current),
        setup: Setup {
            joints: [Joint::x_series(); JOINTS],
            ..Setup::default()
        },
        model,
        ..Case::default()
    };
    let (person, result) = calibrated(&case("xl330-m288"));
    let dialogue = person.talk.0.borrow().0.join("\n");
    result.unwrap_or_else(|error| panic!("{error}\n{dialogue}"));
    assert_eq!(dialogue.matches("as it should").count(), 2, "{dialogue}");
    // 1.47 A for 0.52 N m, 1 mA a count.
    let by_current = joints.map(|joint| Joint {
        gain_counts_per_nm: 2_826.9,
        ..joint
    });
    let settings = person.host.session.status().settings.unwrap();
    assert_eq!(settings.setup.control_mode, ControlMode::Current);
    assert_found(&settings.setup.joints, &by_current);

    let (person, result) = calibrated(&case("xl430"));
    let error = result.unwrap_err().to_string();
    assert!(
        error.contains("XL430-W250 has no current control mode"),
        "{error}"
    );
    let settings = person.host.session.status().settings.unwrap();
    assert_eq!(settings.setup.control_mode, ControlMode::Pwm);
}

#[test]
fn an_arm_of_one_joint_is_asked_for_one() {
    let mut setup = Setup::default();
    (setup.arm.l2, setup.arm.m2) = (0.0, 0.0);
    let joints = x_joints();
    let (person, result) = calibrated(&Case {
        joints,
        firmware: Firmware::XSeries,
        setup,
        ..Case::default()
    });
    let dialogue = person.talk.0.borrow().0.join("\n");
    result.unwrap_or_else(|error| panic!("{error}\n{dialogue}"));
    assert!(!dialogue.to_lowercase().contains("joint 2"), "{dialogue}");
    let [_, after] = person.host.task.result().unwrap();
    assert_found(&after[..1], &joints[..1]);
}

#[test]
fn servos_that_are_swapped_are_found_out() {
    let (_, result) = calibrated(&Case {
        turns: [1, 0],
        ..Case::default()
    });
    let error = result.unwrap_err().to_string();
    assert!(error.contains("ids are swapped"), "{error}");
    assert!(error.contains("nothing was changed"), "{error}");
}
