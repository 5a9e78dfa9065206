//! `armbridge setup` on the executed image: its steps as a person takes them, whose hands turn
//! the simulated arm as they are asked.

use std::collections::VecDeque;
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use armbridge::board_tasks::TaskError;
use armbridge::board_tasks::calibrate::Guide;
use armbridge::finding::Finding;
use armbridge::setup::{Setup, SetupOptions};
use armbridge_client::transport::{LinkUri, touch};
use armbridge_control::actuator::{Direction, Joint};
use armbridge_link::message::{Drive, Fault, Mode};
use armbridge_link::server::Touch;
use armbridge_servo::Firmware;
use armbridge_sim::Bench;
use armbridge_sim::plant::{Plant, PlantConfig};
use armbridge_sim::servo_kind::ServoKind;

use super::faults::is_off;
use super::served::{Served, Truth};

/// Largest motion while a motor is on, as promised: that of the motor check, and beyond it what
/// the hold allows.
const MOTION_MAX_RAD: f64 = 0.1;
/// Longest time with motors on in two armings: a motor check that is repeated takes 0.52 s, the
/// hold a second of the board's ticks, and link and pace add to it.
const ON_MAX_MS: usize = 4_000;
/// Time at the end for which motors are off, in ms.
const END_MS: usize = 100;
/// Duration of the hold.
const HOLD: Duration = Duration::from_secs(1);
/// Duration of a hand's motion, in µs.
const HAND_US: u32 = 1_000_000;

/// A person who does as asked.
struct Person {
    link: LinkUri,
    said: Vec<String>,
    hand: Option<JoinHandle<()>>,
    answers: VecDeque<String>,
}

impl Guide for Person {
    fn say(&mut self, line: &str) {
        self.said.push(line.into());
        let pose = match line {
            _ if line.starts_with("Joint 1: turn") => Some([0.4, 0.0]),
            _ if line.starts_with("Joint 2: turn") => Some([0.0, 0.4]),
            _ if line.contains("hold it at its zero") => Some([0.0, 0.0]),
            _ if line.contains("Let go of it") => Some([0.02, -0.02]),
            _ => None,
        };
        if let Some(angle_rad) = pose {
            let link = self.link.clone();
            let motion = Touch::Move {
                angle_rad,
                duration_us: HAND_US,
            };
            self.hand = Some(std::thread::spawn(move || {
                touch::touch(&link, motion).unwrap();
            }));
            self.answers.push_back(String::new());
        } else if line.contains("[y/N]") {
            self.answers.push_back("y".into());
        }
    }

    fn show(&mut self, _line: &str) {}

    fn answer(&mut self) -> Result<Option<String>, TaskError> {
        if let Some(hand) = self.hand.take_if(|hand| hand.is_finished()) {
            hand.join().unwrap();
        }
        if self.hand.is_some() {
            return Ok(None);
        }
        Ok(self.answers.pop_front())
    }
}

/// A run of the guide.
struct Guided {
    findings: Vec<(String, Finding)>,
    is_complete: bool,
    said: String,
}

fn guided(board: &Served) -> Guided {
    let options = SetupOptions {
        link: board.link.clone(),
        port: Some(board.port.clone()),
        // A busy machine may execute the image slower than the wall clock.
        patience: Duration::from_millis(50),
        is_sure: false,
        hold: HOLD,
    };
    let mut person = Person {
        link: board.link.clone(),
        said: Vec::new(),
        hand: None,
        answers: VecDeque::new(),
    };
    let mut findings = Vec::new();
    let begun = Instant::now();
    let is_complete = Setup::new(&options, &mut person)
        .run(|step, finding| {
            println!(
                "{:5.1} s  {step}: {finding:?}",
                begun.elapsed().as_secs_f64()
            );
            findings.push((step.to_owned(), finding.clone()));
        })
        .unwrap();
    Guided {
        findings,
        is_complete,
        said: person.said.join("\n"),
    }
}

impl Guided {
    /// The finding of a step, state and texts.
    fn row(&self, step: &str) -> (&str, &str, &str) {
        let (_, finding) = (self.findings.iter())
            .find(|(name, _)| name == step)
            .unwrap_or_else(|| panic!("no step {step} in {:?}", self.findings));
        let (state, text, remedy) = finding.parts();
        (state, text, remedy.unwrap_or_default())
    }
}

/// Each time that motors were on, and the largest motion in it, in ms and rad.
fn drives(truths: &[Truth]) -> Vec<(usize, f64)> {
    let mut drives = Vec::new();
    for drive in truths.chunk_by(|a, b| is_off(a.pwm) == is_off(b.pwm)) {
        if !is_off(drive[0].pwm) {
            let motion = drive.iter().flat_map(|truth| {
                [0, 1].map(|joint| (truth.angle_rad[joint] - drive[0].angle_rad[joint]).abs())
            });
            drives.push((drive.len(), motion.fold(0.0, f64::max)));
        }
    }
    drives
}

/// Motors moved the arm no farther and no longer than promised, and are off.
#[track_caller]
fn assert_gentle(truths: &[Truth]) {
    let drives = drives(truths);
    let on_ms: usize = drives.iter().map(|(ms, _)| ms).sum();
    let most = drives.iter().map(|(_, rad)| *rad).fold(0.0, f64::max);
    println!("motors on for {on_ms} ms, {most:.4} rad at most");
    assert!(
        most <= MOTION_MAX_RAD && on_ms <= ON_MAX_MS,
        "{on_ms} ms, {most} rad"
    );
    // The board goes on for a while after the guide has ended.
    let end = truths.iter().rev().take(END_MS);
    assert!(end.clone().count() == END_MS && end.clone().all(|truth| is_off(truth.pwm)));
}

fn servos(ids: [u8; 2]) -> [ServoKind; 2] {
    ids.map(|id| ServoKind::new(Firmware::Morpheus, id, 1_000_000).unwrap())
}

/// A new arm: mounted its own way, and a servo with the id of another arm.
#[test]
#[ignore = "needs the firmware image: run `cargo verify`"]
fn from_a_new_arm_to_one_that_is_held() {
    let mounted = |zero_count, direction| Joint {
        zero_count,
        direction,
        ..Joint::paper()
    };
    let joints = [
        mounted(530.0, Direction::Forward),
        mounted(490.0, Direction::Reverse),
    ];
    let board = Served::with(move || {
        let config = PlantConfig {
            joints,
            ..PlantConfig::default()
        };
        Bench::with_servos(Plant::new(config, 1), &servos([1, 7]))
    });
    let first = guided(&board);
    assert!(first.is_complete, "{:?}\n{}", first.findings, first.said);
    assert!(
        first
            .said
            .contains("Servo 7 gets id 2, and keeps it. Go on? [y/N]")
    );
    assert_eq!(
        first.row("servos").1,
        "ids 1 and 2, firmware Morpheus, 1000000 baud"
    );
    // What is done is not done again.
    let second = guided(&board);
    assert!(second.is_complete, "{:?}", second.findings);
    assert!(!second.said.contains("Joint 1") && !second.said.contains("gets id"));
    let zeros = second.row("calibration").1;
    assert!(zeros.contains("armbridge calibrate"), "{zeros}");

    let (run, truths) = board.end();
    assert_gentle(&truths);
    let drives: Vec<_> = (run.records())
        .filter_map(|record| record.mode.drive())
        .collect();
    assert!(drives.len() > 1_000 && drives.iter().all(|drive| *drive == Drive::Regulate));
    let words: Vec<&str> = zeros.split([' ', ',', ':']).collect();
    let [first, second] = [words[1], words[4]].map(|count| count.parse::<f64>().unwrap());
    assert!(
        (first - 530.0).abs() < 1.0 && (second - 490.0).abs() < 1.0,
        "{zeros}"
    );
    assert!(
        zeros.contains("forward, ") && zeros.contains("reverse:"),
        "{zeros}"
    );
}

/// Servos whose supply is off do not answer.
#[test]
#[ignore = "needs the firmware image: run `cargo verify`"]
fn servos_without_supply_end_it_before_anything_moves() {
    let board = Served::with(|| {
        let mut bench = Bench::with_servos(Plant::new(PlantConfig::default(), 1), &servos([1, 2]));
        for servo in [0, 1] {
            bench.disconnect(servo);
        }
        bench
    });
    let guided = guided(&board);
    assert!(!guided.is_complete);
    let (state, text, remedy) = guided.row("servos");
    assert_eq!(state, "missing");
    assert!(text.starts_with("no servo answers"), "{text}");
    assert!(
        remedy.starts_with("switch the servos' supply on"),
        "{remedy}"
    );
    let (_, truths) = board.end();
    assert!(truths.iter().all(|truth| is_off(truth.pwm)));
}

/// Motors that turn against their encoders: the motor check finds them within its bound.
#[test]
#[ignore = "needs the firmware image: run `cargo verify`"]
fn motors_that_turn_the_wrong_way_are_off_before_the_arm_has_moved_far() {
    let board = Served::with(|| {
        let config = PlantConfig {
            torque_gain: -1.0,
            ..PlantConfig::default()
        };
        Bench::with_servos(Plant::new(config, 1), &servos([1, 2]))
    });
    let first = guided(&board);
    assert!(!first.is_complete);
    let (state, text, remedy) = first.row("direction");
    assert_eq!(state, "missing");
    assert!(text.starts_with("torque off: joint "), "{text}");
    assert!(text.contains("its motor turns it the wrong way"), "{text}");
    assert!(remedy.contains("armbridge clear"), "{remedy}");
    // The fault stays, and the next run says so before anything else.
    let second = guided(&board);
    assert_eq!(second.row("board").0, "missing");
    assert!(second.row("board").2.contains("armbridge clear"));
    let (run, truths) = board.end();
    assert_gentle(&truths);
    assert_eq!(
        run.records().next_back().map(|record| record.mode),
        Some(Mode::Fault(Fault::MotorDirection))
    );
}
