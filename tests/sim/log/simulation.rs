//! True states and pushes of a simulated arm in a log.

use std::path::{Path, PathBuf};

use armbridge_analysis::plan_runner::{PlanRunner, Script};
use armbridge_link::message::Setup;
use armbridge_log::inspect::Log;
use armbridge_log::inspect::log::topics;
use armbridge_log::recorder::Recorder;
use armbridge_log::recording::{Reader, Row};
use armbridge_log::simulation::{Push, TrueState};
use armbridge_sim::cosim::Interaction;
use armbridge_sim::link::{BoardUri, Options};
use armbridge_sim::plant::{Plant, PlantConfig};
use armbridge_sim::{Bench, link};

use super::{facts, folder};

/// A push in the run, and one after its end.
const PUSHES: [Push; 2] = [
    Push {
        joint: 1,
        torque_nm: -0.2,
        start_ns: 2_500_000_000,
        duration_ns: 200_000_000,
    },
    Push {
        joint: 0,
        torque_nm: 0.2,
        start_ns: 900_000_000_000,
        duration_ns: 200_000_000,
    },
];

/// A run of 3 s on the bench.
fn recorded(name: &str) -> PathBuf {
    let path = folder(name).join("run.mcap");
    let recorder = Recorder::create_waiting(&path, &facts()).unwrap();
    let mut options = Options::new(Bench::new(Plant::new(PlantConfig::default(), 1)));
    options.link.taps.push(recorder.tap());
    let (send, interactions) = std::sync::mpsc::channel();
    for push in PUSHES {
        send.send(Interaction::Push(push)).unwrap();
    }
    options.interactions = Some(interactions);
    let runner = PlanRunner::new(Script::demo(Setup::default(), 3_000_000));
    let (_, done) = link::drive(&BoardUri::Sim, options, runner);
    done.map_err(|error| error.to_string()).unwrap();
    recorder.finish().unwrap();
    path
}

fn rows(path: &Path) -> Vec<Row> {
    Reader::open(path).unwrap().rows().collect()
}

fn count_topic(path: &Path, topic: &str) -> u64 {
    topics(path).get(topic).copied().unwrap_or(0)
}

#[test]
fn each_tick_has_the_true_state_at_its_start() {
    let path = recorded("true_states");
    let mut rows = rows(&path);
    assert!(rows.len() > 3_000);
    let ticks = rows.len() as u64;
    // The first begins with the last answer of bring-up.
    assert_eq!(rows.remove(0).truth, None);
    let truth = |row: &Row| row.truth.unwrap();
    for row in &rows {
        assert_eq!(truth(row).at_ns, row.record.input.start_us * 1_000);
    }
    // The arm moves as its speed says: trapezoids of 1 ms.
    let moved_rad = |two: &[Row], j: usize| {
        let [a, b] = [truth(&two[0]), truth(&two[1])];
        let step_s = (b.at_ns - a.at_ns) as f32 * 1e-9;
        b.angle_rad[j] - a.angle_rad[j] - 0.5 * step_s * (a.speed_rad_s[j] + b.speed_rad_s[j])
    };
    let driven = rows
        .iter()
        .position(|row| row.record.mode.drive().is_some());
    for two in rows[driven.unwrap() + 1..].windows(2) {
        assert!((0..2).all(|j| moved_rad(two, j).abs() < 1e-4), "{two:?}");
    }
    // The estimate is near, and the motor's torque is that of the PWM.
    let last = rows.last().unwrap();
    for j in 0..2 {
        assert!((truth(last).angle_rad[j] - last.record.output.angle_rad[j]).abs() < 0.01);
    }
    assert_eq!(count_topic(&path, "/simulation/state"), ticks - 1);
}

#[test]
fn torques_on_the_arm_are_told_apart() {
    let path = recorded("torques");
    let rows = rows(&path);
    let pushed: Vec<TrueState> = rows
        .iter()
        .filter_map(|row| row.truth)
        .filter(|truth| truth.push_nm.iter().any(|push_nm| push_nm.abs() > 0.0))
        .collect();
    assert!((199..=201).contains(&pushed.len()), "{}", pushed.len());
    assert!(
        pushed
            .iter()
            .all(|truth| (truth.push_nm[0].abs() + (truth.push_nm[1] + 0.2).abs()) < 1e-6)
    );
    let static_nm = PlantConfig::default().static_friction_nm().unwrap();
    for truth in rows.iter().filter_map(|row| row.truth) {
        for (j, static_nm) in static_nm.into_iter().enumerate() {
            let (speed, torque_nm) = (truth.speed_rad_s[j], truth.friction_nm[j]);
            assert!(f64::from(torque_nm.abs()) <= static_nm + 1e-6, "{truth:?}");
            // Friction acts against the motion.
            assert!(torque_nm * speed <= 0.0, "{truth:?}");
        }
    }
}

#[test]
fn a_push_is_in_the_log_once_it_has_begun() {
    let path = recorded("pushes");
    let log = Log::load(&path).unwrap();
    assert_eq!(log.pushes, PUSHES[..1]);
    assert_eq!(count_topic(&path, "/simulation/push"), 1);
}

#[test]
fn a_true_state_takes_a_quarter_of_a_tick_of_the_file() {
    let path = recorded("cost");
    let (mut bytes, mut states) = (0, 0);
    let file = std::fs::read(&path).unwrap();
    let size = file.len();
    for message in mcap::MessageStream::new(&file).unwrap() {
        let message = message.unwrap();
        if message.channel.topic == "/simulation/state" {
            states += 1;
            // Its header, and its entry of the chunk's index.
            bytes += message.data.len() + 31 + 16;
        }
    }
    let per_tick = bytes as f64 / f64::from(states);
    println!(
        "{per_tick:.1} of {:.1} bytes per tick",
        size as f64 / f64::from(states)
    );
    assert!((85.0..105.0).contains(&per_tick), "{per_tick}");
}
