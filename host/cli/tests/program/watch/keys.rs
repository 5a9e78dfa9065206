//! Effect of the keys in each state of the board.

use armbridge::watch::keys::{Action, Keys, Question};
use armbridge_client::event::{Event, EventKind};
use armbridge_client::session::Request;
use armbridge_link::limits::Milliradians;
use armbridge_link::message::{Command, Settings};
use ratatui::crossterm::event::{KeyCode, KeyEvent, KeyModifiers};

use super::{S, letter, nudge, press, regulated, shove, watched};

#[test]
fn stopping_needs_no_answer_and_arming_does() {
    let idle = watched(nudge(9 * S), S, false);
    let mut keys = Keys::new(false);
    for stop in [' ', 's'] {
        assert_eq!(letter(&mut keys, 'a', &idle), []);
        assert_eq!(keys.question, Some(Question::Arm));
        assert_eq!(
            letter(&mut keys, stop, &idle),
            [Action::Request(Request::Stop)]
        );
        assert_eq!(keys.question, None);
        // A new key does not answer the question before.
        assert_eq!(letter(&mut keys, 'y', &idle), []);
    }
    assert_eq!(letter(&mut keys, 'a', &idle), []);
    assert_eq!(letter(&mut keys, 'n', &idle), []);
    assert_eq!(letter(&mut keys, 'a', &idle), []);
    assert_eq!(
        letter(&mut keys, 'y', &idle),
        [Action::Request(Request::Arm)]
    );

    // Regulating arms first; the arm stays where it is.
    assert_eq!(letter(&mut keys, 'r', &idle), []);
    let here = Command::Regulate(idle.board.record.unwrap().output.angle_rad);
    let held = [
        Action::Request(Request::Arm),
        Action::Request(Request::Command(here)),
    ];
    assert_eq!(letter(&mut keys, 'h', &idle), held);

    // It floats where it is once it is armed, and not before.
    assert_eq!(letter(&mut keys, 'f', &idle), []);
    assert!(keys.question.is_none() && keys.note.is_some_and(|note| note.contains("press a")));
    let running = regulated(nudge(9 * S), 2 * S);
    assert_eq!(letter(&mut keys, 'f', &running), []);
    assert_eq!(
        letter(&mut keys, 'y', &running),
        [Action::Request(Request::Command(Command::Float))]
    );

    // It is parked only where it has a pose; a taught motion is written at any time.
    assert_eq!(letter(&mut keys, 'p', &running), []);
    assert!(keys.note.is_some_and(|note| note.contains("park.kind")));
    let mut posed = running.clone();
    let mut settings = Settings::default();
    settings.limits.park = Some([Milliradians(1_200), Milliradians(0)]);
    posed.board.settings = Some(settings);
    assert_eq!(
        letter(&mut keys, 'p', &posed),
        [Action::Request(Request::Command(Command::Park))]
    );
    assert_eq!(letter(&mut keys, 't', &idle), [Action::Teach]);
    assert_eq!(letter(&mut keys, 'm', &running), []);
    assert!(keys.question.is_none() && keys.note.is_some_and(|note| note.contains("press f")));

    // A link that broke while one thought about it.
    assert_eq!(letter(&mut keys, 'a', &idle), []);
    let mut lost = idle.clone();
    lost.take(&Event {
        host_ns: S,
        kind: EventKind::Disconnected,
    });
    assert_eq!(letter(&mut keys, 'y', &lost), []);
    assert_eq!(letter(&mut keys, 'a', &lost), []);
    assert_eq!(keys.question, None);
    let ctrl_c = KeyEvent::new(KeyCode::Char('c'), KeyModifiers::CONTROL);
    assert_eq!(keys.press(ctrl_c, &lost), [Action::Quit]);
}

#[test]
fn setpoints_move_in_steps_and_stay_where_the_arm_is_not_braked() {
    let running = regulated(nudge(9 * S), 2 * S);
    let mut keys = Keys::new(false);
    let mut latest = [0.0; 2];
    for _ in 0..200 {
        for act in press(&mut keys, KeyCode::Right, &running) {
            let Action::Request(Request::Command(Command::Regulate(setpoint))) = act else {
                panic!("{act:?}");
            };
            assert!(
                (setpoint[0] - latest[0] - 0.02).abs() < 1e-5,
                "{setpoint:?}"
            );
            latest = setpoint;
        }
    }
    // The limit is 1.5, and the brake acts from 1.4 on.
    assert!(latest[0] > 1.25 && latest[0] <= 1.3, "{latest:?}");
    assert!(latest[1].abs() < 1e-6);
    assert_eq!(letter(&mut keys, 'c', &running), []);
    assert_eq!(letter(&mut keys, '1', &running), []);

    let fault = regulated(shove(6 * S), 7 * S);
    assert_eq!(press(&mut keys, KeyCode::Up, &fault), []);
    assert_eq!(letter(&mut keys, 'a', &fault), []);
    assert_eq!(keys.question, None);
    let clear = Action::Request(Request::Command(Command::ClearFault));
    assert_eq!(letter(&mut keys, 'c', &fault), [clear]);
}
