//! Random experiments, one after the other: whatever is accepted stays within the limits,
//! ends in rest, and is the same again.

use armbridge_link::message::{Command, Mode};
use armbridge_sim::plant::PlantConfig;
use armbridge_tests::experiments::{experiment, number};
use armbridge_tests::random::Random;
use armbridge_tests::tapped_bench::{Action, ScriptedHost, records, replay, tapped_run};

use super::{arm_at, conclusions, during, refusals};

fn run(seed: u64) -> (usize, usize) {
    let mut random = Random::new(seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) | 1);
    let angle = |random: &mut Random| random.below(1_000) as f32 * 1e-3 - 0.5;
    let from = [angle(&mut random), angle(&mut random)];
    let mut acts = vec![(150_000, Action::Command(Command::Arm { session: 0 }))];
    let mut at_us = 200_000;
    for _ in 0..4 {
        acts.push((at_us, Action::Command(Command::Regulate(from))));
        at_us += 900_000;
        let plan = experiment(&mut random, number);
        acts.push((at_us, Action::Command(Command::Experiment(plan))));
        at_us += (plan.duration_s * 1e6) as u64 + 300_000;
    }
    let config = PlantConfig {
        gravity_scale: 0.8 + random.below(40) as f64 * 0.01,
        inertia_scale: 0.8 + random.below(40) as f64 * 0.01,
        ..arm_at(from)
    };
    let mut most_rad: f64 = 0.0;
    let events = tapped_run(
        ScriptedHost::new(acts, at_us),
        config,
        seed,
        |_, bench, _| {
            most_rad = most_rad.max(bench.plant().state().q.amax());
        },
    );
    let report = replay(&events);
    assert_eq!(
        report.differing + report.answers_differing,
        0,
        "seed {seed}: {}",
        report.text()
    );
    let faults = records(&events).filter(|record| matches!(record.mode, Mode::Fault(_)));
    assert_eq!(faults.count(), 0, "seed {seed}");
    assert!(most_rad < 1.5, "seed {seed}: {most_rad}");
    let accepted = 4 - refusals(&events).len();
    assert_eq!(conclusions(&events).len(), accepted, "seed {seed}");
    (accepted, during(&events).len())
}

#[test]
fn any_experiment_stays_within_the_limits_and_is_the_same_again() {
    let (mut accepted, mut ticks) = (0, 0);
    for seed in 0..24 {
        let (more, longer) = run(seed);
        accepted += more;
        ticks += longer;
    }
    assert!(accepted > 60 && ticks > 25_000, "{accepted} {ticks}");
}
