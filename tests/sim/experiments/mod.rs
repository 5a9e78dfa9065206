//! Experiments on the virtual arm: what each does, how each ends, why one may not be.

mod end;
mod random;
mod refusals;
mod signals;
mod start;

use armbridge_client::event::{Event, EventKind};
use armbridge_control::experiment::Signal;
use armbridge_link::experiment::{Conclusion, Experiment, Role};
use armbridge_link::message::{Command, Drive, Limits, Record, Refusal, ToHost};
use armbridge_sim::plant::PlantConfig;
use armbridge_tests::plant;
use armbridge_tests::tapped_bench::{Action, ScriptedHost, records, tapped_run};

/// When experiments are asked for, in µs: the arm has come to rest.
const BEGIN_US: u64 = 1_500_000;

/// Ticks of 1 ms.
const PERIOD_US: u32 = 1_000;

/// A wide and slow envelope about upright.
const ENVELOPE: Experiment = Experiment {
    roles: [Role::Hold, Role::Hold],
    duration_s: 1.0,
    angle_rad: [[-1.0, 1.0]; 2],
    speed_rad_s: [2.5; 2],
};

/// The experiment with these roles, for so long, in [`ENVELOPE`].
fn experiment(roles: [Role; 2], duration_s: f32) -> Experiment {
    Experiment {
        roles,
        duration_s,
        ..ENVELOPE
    }
}

/// Events of a host that holds the arm at these angles, and then acts.
fn heard_at(angle_rad: [f32; 2], acts: &[(u64, Action)], until_us: u64) -> Vec<Event> {
    // An arm that leans falls before its motors are checked.
    let unchecked = Limits {
        check_rad_s2: 0,
        ..Limits::default()
    };
    let begin = [
        (100_000, Action::Command(Command::Limit(unchecked))),
        (150_000, Action::Command(Command::Arm { session: 0 })),
        (200_000, Action::Command(Command::Regulate(angle_rad))),
    ];
    let acts = begin.into_iter().chain(acts.iter().copied());
    tapped_run(
        ScriptedHost::new(acts, until_us),
        arm_at(angle_rad),
        1,
        |_, _, _| {},
    )
}

/// The bench's arm, held at these angles.
fn arm_at(angle_rad: [f32; 2]) -> PlantConfig {
    plant(angle_rad.map(f64::from), true)
}

/// Events of one experiment from these angles.
fn heard_of(angle_rad: [f32; 2], plan: Experiment) -> Vec<Event> {
    let acts = [(BEGIN_US, Action::Command(Command::Experiment(plan)))];
    let until_us = BEGIN_US + (plan.duration_s * 1e6) as u64 + 1_500_000;
    heard_at(angle_rad, &acts, until_us)
}

/// The ticks that the experiment decided.
fn during(events: &[Event]) -> Vec<Record> {
    let is_one = |record: &Record| record.mode.drive() == Some(Drive::Experiment);
    records(events).filter(is_one).collect()
}

/// The ticks after it.
fn after(events: &[Event]) -> Vec<Record> {
    let last = during(events).last().expect("an experiment").tick;
    records(events)
        .filter(|record| record.tick > last)
        .collect()
}

fn conclusions(events: &[Event]) -> Vec<Conclusion> {
    let messages = events.iter().filter_map(|event| match event.kind {
        EventKind::Received(_, ToHost::Concluded(conclusion)) => Some(conclusion),
        _ => None,
    });
    messages.collect()
}

fn refusals(events: &[Event]) -> Vec<Refusal> {
    let messages = events.iter().filter_map(|event| match event.kind {
        EventKind::Received(_, ToHost::Ack { result, .. }) => result.err(),
        _ => None,
    });
    messages.collect()
}

/// Value of the signal in the n-th tick of an experiment.
fn expected(signal: &Signal<f32>, tick: usize, duration_s: f32) -> f32 {
    let elapsed_us = tick as u32 * PERIOD_US;
    signal.at(elapsed_us as f32 * 1e-6, duration_s).value
}
