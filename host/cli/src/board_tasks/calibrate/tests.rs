//! Calibration of an arm on the bench that is moved by pushes, as by hands.

use std::cell::RefCell;
use std::collections::VecDeque;
use std::rc::Rc;
use std::sync::mpsc::{Sender, channel};

use armbridge_client::{Host, LinkError};
use armbridge_control::actuator::{Direction, Joint};
use armbridge_servo::JOINTS;
use armbridge_sim::Bench;
use armbridge_sim::cosim::Interaction;
use armbridge_sim::link::{BoardUri, Options, drive};
use armbridge_sim::plant::{Plant, PlantConfig, Push};

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

/// An arm that lies on a table: no gravity, much friction, not held.
fn calibrated(
    true_joints: [Joint<f64>; JOINTS],
    turns: [usize; JOINTS],
    checks_motors: bool,
) -> (Person, Result<(), LinkError<TaskError>>) {
    let config = PlantConfig {
        gravity_scale: 0.0,
        held: false,
        joints: true_joints,
        ..PlantConfig::default()
    };
    let talk = Talk::default();
    let (hands, interactions) = channel();
    let calibration = CalibrationOptions {
        joints: [true; JOINTS],
        checks_motors,
        is_sure: false,
    };
    let person = Person {
        host: TaskHost::new(Calibrate::new(talk.clone(), calibration)),
        talk,
        turns,
        seen: 0,
        hands,
        answer_at_us: None,
    };
    let mut options = Options::new(Bench::new(Plant::new(config, 1)));
    options.interactions = Some(interactions);
    drive(&BoardUri::Sim, options, person)
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
    let (person, result) = calibrated(joints, [0, 1], true);
    let dialogue = person.talk.0.borrow().0.join("\n");
    result.unwrap_or_else(|error| panic!("{error}\n{dialogue}"));
    let [before, after] = person.host.task.result().unwrap();
    assert_eq!(before, [Joint::paper(); JOINTS]);
    for (found, there) in after.iter().zip(joints) {
        let off = f64::from(found.zero_count) - there.zero_count;
        assert!(off.abs() < 1.0, "{off} counts off");
        assert_eq!(found.direction, there.direction);
        assert!((f64::from(found.rad_per_count) - there.rad_per_count).abs() < 1e-9);
    }
    // The board reports its settings in force.
    let settings = person.host.session.status().settings.unwrap();
    assert_eq!(settings.setup.joints, after);
    assert_eq!(dialogue.matches("as it should").count(), 2, "{dialogue}");
}

#[test]
fn servos_that_are_swapped_are_found_out() {
    let (_, result) = calibrated([Joint::paper(); JOINTS], [1, 0], false);
    let error = result.unwrap_err().to_string();
    assert!(error.contains("ids are swapped"), "{error}");
    assert!(error.contains("nothing was changed"), "{error}");
}
