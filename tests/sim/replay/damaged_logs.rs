//! Logs that differ from the board's messages, or lack some.

use armbridge_analysis::plan_runner::Script;
use armbridge_client::event::{Direction, Event, EventKind};
use armbridge_link::message::{
    Command, Controller, Gains, Guards, Record, Sample, Setup, ToBoard, ToHost,
};
use armbridge_log::replay::{Changes, Verdict};
use armbridge_tests::plant;
use armbridge_tests::tapped_bench::{
    Action, ScriptedHost, assert_all_equal, assert_equal, recorded, records, replay, replay_with,
    tapped_run,
};

fn demo() -> Vec<Event> {
    let script = Script::demo(Setup::default(), 1_000_000);
    recorded(plant([0.30, -0.25], true), 1, script)
}

/// Changes the record of this tick.
fn change(events: &mut [Event], tick: u32, change: impl Fn(&mut Record)) {
    let records = events.iter_mut().filter_map(|event| match &mut event.kind {
        EventKind::Received(_, ToHost::Record(record)) => Some(record),
        _ => None,
    });
    for record in records.filter(|record| record.tick == tick) {
        change(record);
    }
}

#[test]
fn one_count_names_its_tick() {
    let mut events = demo();
    let tick = records(&events).nth(600).unwrap().tick;
    change(&mut events, tick, |record| {
        if let Sample::Counts(counts) = &mut record.input.samples[1] {
            *counts += 1;
        }
    });
    let report = replay(&events);
    assert_eq!(report.verdict, Verdict::Differs);
    let first = report.first.unwrap();
    assert_eq!((first.tick, first.field.as_str()), (tick, "angle_rad_2"));
    assert_ne!(first.recorded, first.computed);
    assert!(report.differing > 1);
}

#[test]
fn an_output_names_its_tick_and_nothing_else() {
    for (field, spoil) in [
        (
            "pwm_next_counts_1",
            (|record| record.output.pwm[0] ^= 1) as fn(&mut Record),
        ),
        ("torque_nm_2", |record| {
            record.output.torque_nm[1] = f32::from_bits(record.output.torque_nm[1].to_bits() ^ 1);
        }),
        ("guards", |record| record.output.guards = Guards::BRAKED),
    ] {
        let mut events = demo();
        let tick = records(&events).nth(700).unwrap().tick;
        change(&mut events, tick, spoil);
        let report = replay(&events);
        let first = report.first.unwrap();
        assert_eq!((first.tick, first.field.as_str()), (tick, field));
        assert_eq!(report.differing, 1);
    }
}

/// A gain that was commanded otherwise shows in the first torque.
#[test]
fn another_gain_names_the_first_torque() {
    let mut events = demo();
    let driven = records(&events)
        .find(|record| record.mode.drive().is_some())
        .unwrap();
    for event in &mut events {
        if let EventKind::Sent(_, ToBoard::Command(Command::Configure(setup))) = &mut event.kind
            && let Controller::StateFeedback(Gains::Design { q, .. }) = &mut setup.controller
        {
            q[0] *= 1.01;
        }
    }
    let first = replay(&events).first.unwrap();
    assert_eq!(first.tick, driven.tick);
    assert!(
        first.field.contains("pwm") || first.field.contains("torque"),
        "{first}"
    );
}

/// A loss costs the ticks up to the next start of the board, and no more.
#[test]
fn a_gap_is_left_out_and_said() {
    let acts = [
        (150_000, Command::Arm { session: 0 }),
        (200_000, Command::Regulate([0.0; 2])),
        (600_000, Command::Idle),
        (700_000, Command::Arm { session: 0 }),
        (720_000, Command::Regulate([0.1, 0.0])),
    ];
    let acts = acts.map(|(at_us, command)| (at_us, Action::Command(command)));
    let host = ScriptedHost::new(acts, 1_000_000);
    let events = tapped_run(host, plant([0.02, 0.0], true), 6, |_, _, _| {});
    assert_all_equal(&replay(&events));

    let is_lost = |event: &Event| match event.kind {
        EventKind::Received(_, ToHost::Record(record)) => (550..560).contains(&record.tick),
        _ => false,
    };
    let at = events.iter().position(is_lost).unwrap();
    let mut left: Vec<Event> = events.iter().filter(|e| !is_lost(e)).copied().collect();
    // Dropped by the link, by the board, or by the recorder.
    let host_ns = left[at].host_ns;
    for lost in [Some(EventKind::Lost(Direction::ToHost, 10)), None] {
        if let Some(kind) = lost {
            left.insert(at, Event { host_ns, kind });
        }
        let report = replay(&left);
        assert_equal(&report);
        let skipped = &report.skipped[0];
        assert_eq!(
            (skipped.missing, skipped.first_tick),
            (10, 550),
            "{skipped:?}"
        );
        // Until it is armed again, some 400 ms later.
        assert!((300..450).contains(&skipped.ticks), "{skipped:?}");
        assert_eq!(report.compared + skipped.ticks, report.records);
        if lost.is_some() {
            left.remove(at);
        }
    }
}

/// A log that begins in the middle, and one of a host that takes a moving arm over.
#[test]
fn a_log_may_begin_in_the_middle() {
    let events = demo();
    let middle = replay(&events[events.len() / 2..]);
    assert_eq!(middle.verdict, Verdict::Nothing);
    assert_eq!(middle.skipped[0].ticks, middle.records);

    let acts = [
        (150_000, Action::Command(Command::Arm { session: 0 })),
        (200_000, Action::Command(Command::Regulate([0.1, 0.0]))),
        (
            500_300,
            Action::Message(ToBoard::Hello(armbridge_link::schema::HELLO)),
        ),
        (700_000, Action::Command(Command::Arm { session: 0 })),
        (720_000, Action::Command(Command::Regulate([0.0, 0.0]))),
    ];
    let host = ScriptedHost::new(acts, 1_000_000);
    let events = tapped_run(host, plant([0.1, 0.0], true), 7, |_, _, _| {});
    assert_equal(&replay(&events));
    let hello = events
        .iter()
        .rposition(|event| matches!(event.kind, EventKind::Sent(_, ToBoard::Hello(_))))
        .unwrap();
    let taken_over = replay(&events[hello..]);
    assert_equal(&taken_over);
    assert!(taken_over.compared > 250, "{}", taken_over.text());
}

/// More weight on the torque: less of it, and the same estimate.
#[test]
fn other_settings_are_answered_open_loop() {
    let events = demo();
    let pairs = vec![(
        "controller.r".to_owned(),
        toml::Value::Array(vec![toml::Value::Float(1_000.0); 2]),
    )];
    let report = replay_with(&events, Changes::new(toml::Table::new(), pairs));
    let what_if = report.what_if.unwrap();
    assert_eq!(what_if.changes.len(), 1, "{what_if}");
    assert_eq!(what_if.faults, 0, "{what_if}");
    assert!(what_if.driven > 900, "{what_if}");
    for joint in what_if.joints {
        assert!(
            joint.torque_rms_computed_nm < joint.torque_rms_recorded_nm,
            "{joint:?}"
        );
        assert!(joint.torque_difference_max_nm > 0.0);
    }
}

#[test]
fn changed_limits_are_named_and_equal_ones_too() {
    let events = demo();
    for (torque_nm, words) in [
        (0.1, "with limits.torque_nm=[0.1, 0.1]"),
        (1.25, "with the recorded settings"),
    ] {
        let value = toml::Value::Array(vec![toml::Value::Float(torque_nm); 2]);
        let pairs = vec![("limits.torque_nm".to_owned(), value)];
        let report = replay_with(&events, Changes::new(toml::Table::new(), pairs));
        let text = report.what_if.unwrap().to_string();
        assert!(text.starts_with(words), "{text}");
    }
}
