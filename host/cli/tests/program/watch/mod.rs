//! The dashboard's screens, drawn from runs on the bench: the same bytes, from the
//! same seed, in virtual time.
//!
//! Reviewed screens are in `data/watch/`;
//! `UPDATE_SNAPSHOT=1 cargo test -p armbridge --test program watch` writes them anew. Look at
//! what it wrote.

mod keys;

use std::path::Path;
use std::sync::{Arc, Mutex};

use armbridge::watch::hand::Hand;
use armbridge::watch::keys::{Action, Keys};
use armbridge::watch::model::Model;
use armbridge::watch::view;
use armbridge_client::Tap;
use armbridge_client::event::{Direction, Event, EventKind, LinkDecoder};
use armbridge_client::session::{ChannelHost, Request, SessionHandle};
use armbridge_control::arm::State;
use armbridge_link::experiment::{Conclusion, ExperimentEnd};
use armbridge_link::message::{Command, Drive, Mode, Record, Refusal, ToBoard, ToHost};
use armbridge_link::server::{LinkRole, Program};
use armbridge_sim::Bench;
use armbridge_sim::link::{BoardUri, Options, drive};
use armbridge_sim::plant::{Plant, PlantConfig, Push};
use nalgebra::Vector2;
use ratatui::Terminal;
use ratatui::backend::TestBackend;
use ratatui::crossterm::event::{KeyCode, KeyEvent, KeyModifiers};

const S: u64 = 1_000_000_000;

/// Feeds a model until a moment, sees to it that the arm is regulated upright until
/// then, and leaves.
struct Until {
    ear: LinkDecoder,
    model: Arc<Mutex<Model>>,
    end_ns: u64,
    controls: SessionHandle,
    is_asked: bool,
}

impl Tap for Until {
    fn bytes(&mut self, direction: Direction, host_ns: u64, bytes: &[u8]) {
        let mut model = self.model.lock().unwrap();
        self.ear.take(direction, host_ns, bytes, |event| {
            if event.host_ns <= self.end_ns {
                model.take(&event);
            }
        });
        // It may be gone already.
        if model.board.mode() == Some(Mode::Idle) && !self.is_asked {
            self.is_asked = true;
            let _ = self.controls.request(Request::Arm);
            let upright = Command::Regulate([0.0, 0.0]);
            let _ = self.controls.request(Request::Command(upright));
        }
        if host_ns > self.end_ns {
            let _ = self.controls.request(Request::Leave);
        }
    }

    fn disconnected(&mut self, _host_ns: u64) {}
}

/// The model at `end_ns` of an arm that is regulated upright and pushed.
fn regulated(push: Push, end_ns: u64) -> Model {
    watched(push, end_ns, true)
}

/// The same, or of a board that is never armed.
fn watched(push: Push, end_ns: u64, is_armed: bool) -> Model {
    let config = PlantConfig {
        initial: State::at_rest(Vector2::new(0.3, -0.25)),
        ..PlantConfig::default()
    };
    let mut bench = Bench::new(Plant::new(config, 1));
    bench.push(push);
    let model = Arc::new(Mutex::new(Model::default()));
    let (station, controls) = ChannelHost::new();
    let mut options = Options::new(bench);
    options.link.taps.push(Box::new(Until {
        ear: LinkDecoder::default(),
        model: Arc::clone(&model),
        end_ns,
        controls,
        is_asked: !is_armed,
    }));
    let (_, result) = drive(&BoardUri::Sim, options, station);
    result.unwrap();
    Arc::try_unwrap(model).unwrap().into_inner().unwrap()
}

/// A push that the arm stands.
fn nudge(start_ns: u64) -> Push {
    Push {
        joint: 0,
        torque_nm: 0.5,
        start_ns,
        duration_ns: S / 10,
    }
}

/// A push that it does not stand.
fn shove(start_ns: u64) -> Push {
    Push {
        joint: 1,
        torque_nm: 3.0,
        start_ns,
        duration_ns: S,
    }
}

fn screen(model: &Model, keys: &Keys, (width, height): (u16, u16)) -> String {
    let mut terminal = Terminal::new(TestBackend::new(width, height)).unwrap();
    terminal
        .draw(|frame| view::draw(frame, model, keys, "sim: (simulated)"))
        .unwrap();
    let drawn = terminal.backend().to_string();
    // The backend quotes its lines.
    let lines = drawn.lines().map(|line| line.trim_matches('"').trim_end());
    let lines: Vec<_> = lines.collect();
    lines.join("\n") + "\n"
}

/// Compares with what is kept, or keeps it.
fn is_as_kept(name: &str, drawn: &str) {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("tests/data/watch/{name}.txt"));
    if std::env::var_os("UPDATE_SNAPSHOT").is_some() {
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(&path, drawn).unwrap();
    }
    let kept = std::fs::read_to_string(&path).unwrap_or_default();
    assert!(
        kept == drawn,
        "the screen has changed; if that is meant, run again with UPDATE_SNAPSHOT=1\n\
         kept:\n{kept}\ndrawn:\n{drawn}"
    );
}

const SIZES: [(&str, (u16, u16)); 2] = [("80x24", (80, 24)), ("120x40", (120, 40))];

#[test]
fn an_arm_that_was_pushed_and_stands() {
    let model = regulated(nudge(7 * S), 9 * S);
    for (size, place) in SIZES {
        is_as_kept(
            &format!("running-{size}"),
            &screen(&model, &Keys::default(), place),
        );
    }
}

#[test]
fn an_arm_that_was_pushed_too_hard() {
    let model = regulated(shove(6 * S), 7 * S);
    assert!(model.board.trip.is_some());
    for (size, place) in SIZES {
        is_as_kept(
            &format!("fault-{size}"),
            &screen(&model, &Keys::default(), place),
        );
    }
}

#[test]
fn a_fault_screen_shows_what_is_known_of_the_motors_and_who_clears() {
    let mut model = regulated(shove(6 * S), 7 * S);
    model.board.off = None;
    let mut keys = Keys::default();
    let drawn = screen(&model, &keys, (100, 30));
    assert!(
        drawn.contains("commanded off, not yet seen to be"),
        "{drawn}"
    );
    assert!(drawn.contains("(c clears)"), "{drawn}");
    keys.role = Some(LinkRole {
        is_commander: false,
        commander: None,
        is_touchable: false,
    });
    let drawn = screen(&model, &keys, (100, 30));
    assert!(drawn.contains("(its commander clears)"), "{drawn}");
}

#[test]
fn a_link_that_broke() {
    let mut model = regulated(nudge(7 * S), 9 * S);
    model.take(&Event {
        host_ns: 9 * S,
        kind: EventKind::Disconnected,
    });
    model.advance(9 * S + 3_200_000_000);
    for (size, place) in SIZES {
        is_as_kept(
            &format!("lost-{size}"),
            &screen(&model, &Keys::default(), place),
        );
    }
}

#[test]
fn an_experiment_and_how_it_ended() {
    let mut model = regulated(nudge(7 * S), 5 * S);
    let draw = |model: &mut Model, message| {
        let host_ns = 5 * S;
        let kind = EventKind::Received(0, message);
        model.take(&Event { host_ns, kind });
        screen(model, &Keys::default(), (100, 30))
    };
    let tick = model.board.record.unwrap();
    let in_drive = |drive| {
        let mut tick: Record = tick;
        tick.mode = Mode::Running(drive);
        ToHost::Record(tick)
    };
    let drawn = draw(&mut model, in_drive(Drive::Experiment));
    assert!(drawn.contains("an experiment drives the arm"), "{drawn}");
    let conclusion = Conclusion {
        tick: tick.tick,
        end: ExperimentEnd::Angle {
            joint: 1,
            value_rad: 0.512,
        },
    };
    draw(&mut model, ToHost::Concluded(conclusion));
    let drawn = draw(&mut model, in_drive(Drive::Hold));
    let ended = "broken off: joint 2 left its envelope at 0.512 rad";
    assert!(drawn.contains(ended), "{drawn}");
    let drawn = draw(&mut model, in_drive(Drive::Track));
    assert!(!drawn.contains(ended), "{drawn}");
    assert!(drawn.contains("  setpoint +"), "{drawn}");
    // Nothing holds an arm that floats at a setpoint.
    let drawn = draw(&mut model, in_drive(Drive::Float));
    assert!(drawn.contains("weightless: lead it by hand"), "{drawn}");
    assert!(
        !drawn.contains("  setpoint +") && !drawn.contains("  setpoint -"),
        "{drawn}"
    );
}

#[test]
fn an_arm_that_lies_beyond_its_limit_can_be_lifted_and_the_screen_says_so() {
    let mut model = watched(nudge(9 * S), S, false);
    let arm = Command::Arm { session: 1 };
    let refused = ToHost::Ack {
        sequence: 9,
        result: Err(Refusal::BeyondLimit { joint: 0 }),
        moment: None,
    };
    for kind in [
        EventKind::Sent(9, ToBoard::Command(arm)),
        EventKind::Received(0, refused),
    ] {
        model.take(&Event { host_ns: S, kind });
    }
    let drawn = screen(&model, &Keys::new(true), (80, 24));
    let lines: Vec<_> = drawn.lines().map(str::trim).collect();
    let words = "refused: joint 1 stands beyond its angle limit; move it inside by hand, or check \
                 its calibration; or press l, which lifts the simulated arm";
    assert!(lines.join(" ").contains(words), "{drawn}");
    assert!(lines.last().is_some_and(|keys| keys.contains("q quit")));
    // There is no such key where the arm is real.
    let drawn = screen(&model, &Keys::new(false), (80, 24));
    assert!(
        drawn.contains("its calibration") && !drawn.contains("press l"),
        "{drawn}"
    );
}

#[test]
fn an_arm_of_one_joint_has_one_panel_and_no_keys_of_the_other() {
    let mut model = regulated(nudge(9 * S), 3 * S);
    let mut settings = model.board.settings.unwrap();
    (settings.setup.arm.l2, settings.setup.arm.m2) = (0.0, 0.0);
    let kind = EventKind::Received(0, ToHost::Settings(settings));
    let host_ns = 3 * S;
    model.take(&Event { host_ns, kind });
    let drawn = screen(&model, &Keys::new(true), (100, 30));
    assert!(
        drawn.contains("joint 1  ") && !drawn.contains("joint 2"),
        "{drawn}"
    );
    let mut keys = Keys::new(true);
    assert_eq!(press(&mut keys, KeyCode::Right, &model).len(), 1);
    for code in [KeyCode::Up, KeyCode::Char('2')] {
        assert_eq!(press(&mut keys, code, &model), []);
        assert_eq!(keys.note.take(), Some("this arm has one joint"));
    }
}

#[test]
fn a_screen_that_is_too_small_says_so_and_still_tells_a_fault() {
    let model = regulated(shove(6 * S), 7 * S);
    let drawn = screen(&model, &Keys::default(), (60, 12));
    assert!(
        drawn.contains("60x12") && drawn.contains("80x24"),
        "{drawn}"
    );
    assert!(
        drawn.contains("FAULT") && drawn.contains("space stops"),
        "{drawn}"
    );
    // Nothing is too small to be drawn on.
    for size in [(1, 1), (2, 24), (200, 3)] {
        let _ = screen(&model, &Keys::default(), size);
    }
}

#[test]
fn the_role_on_a_served_link_is_shown_and_an_observer_only_stops() {
    let model = regulated(nudge(9 * S), 2 * S);
    let commander = Some(Program::new("armbridge run", 4_242));
    let role = |is_commander| LinkRole {
        is_commander,
        commander,
        is_touchable: true,
    };
    let mut keys = Keys::new(true);
    keys.role = Some(role(true));
    let drawn = screen(&model, &keys, (80, 24));
    assert!(drawn.contains("COMMANDING · link up"), "{drawn}");
    keys.role = Some(role(false));
    let drawn = screen(&model, &keys, (80, 24));
    let by = "OBSERVING   armbridge run (process 4242) commands the board; space stops it";
    assert!(
        drawn.contains(by) && drawn.contains("OBSERVING · link up"),
        "{drawn}"
    );
    for code in ['a', 'c', 'd', 'f', 'r'].map(KeyCode::Char) {
        assert_eq!(press(&mut keys, code, &model), []);
        assert!(keys.note.is_some_and(|note| note.contains("observes")) && keys.question.is_none());
    }
    assert_eq!(press(&mut keys, KeyCode::Up, &model), []);
    assert_eq!(
        letter(&mut keys, '2', &model),
        [Action::Hand(Hand::Push(1))]
    );
    assert_eq!(
        letter(&mut keys, ' ', &model),
        [Action::Request(Request::Stop)]
    );
    keys.is_touchable = false;
    assert_eq!(letter(&mut keys, '2', &model), []);
}

fn press(keys: &mut Keys, code: KeyCode, model: &Model) -> Vec<Action> {
    keys.press(KeyEvent::new(code, KeyModifiers::NONE), model)
}

/// A letter.
fn letter(keys: &mut Keys, letter: char, model: &Model) -> Vec<Action> {
    press(keys, KeyCode::Char(letter), model)
}
