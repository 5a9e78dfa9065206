//! Speed of the environments: ticks per second of each mode, on one core and on all.
//!
//! `cargo run --release -p armbridge-sim --example environment_speed`

use std::time::Instant;

use armbridge_link::message::{Settings, Setup};
use armbridge_sim::environment::batch::Batch;
use armbridge_sim::environment::{ActionKind, Description, Environment, Mode, Task};
use armbridge_sim::plant::PlantConfig;

/// Ticks of a step.
const TICKS: u32 = 20;

fn description(mode: Mode) -> Description {
    Description {
        task: Task::Reach,
        mode,
        action: ActionKind::Setpoint,
        settings: Settings {
            setup: Setup::best(),
            ..Settings::default()
        },
        plants: vec![PlantConfig::default()],
        ticks_per_step: TICKS,
        steps_max: 250,
    }
}

fn main() {
    for (name, mode, steps) in [("exact", Mode::Exact, 500), ("fast", Mode::Fast, 25_000)] {
        let mut environment = Environment::new(description(mode)).expect("an environment");
        let begun = Instant::now();
        environment.reset().expect("an episode");
        println!(
            "{name}: reset in {:.2} ms",
            begun.elapsed().as_secs_f64() * 1e3
        );
        let begun = Instant::now();
        let mut reward = 0.0;
        for step in 0..steps {
            let angle_rad = if step % 100 < 50 { 0.2 } else { -0.2 };
            let transition = environment.step([angle_rad, -angle_rad]).expect("a step");
            reward += transition.reward;
            assert!(!transition.is_terminated, "{transition:?}");
        }
        let ticks = f64::from(steps * TICKS);
        let per_s = ticks / begun.elapsed().as_secs_f64();
        let mean = reward / f64::from(steps);
        println!("{name}: {per_s:.0} ticks a second, mean reward {mean:.3}");
    }
    let environment = Environment::new(description(Mode::Fast)).expect("an environment");
    let mut batch = Batch::new(&environment, 64).expect("simulated ones");
    batch.reset(&[Some(1); 64]).expect("episodes");
    let begun = Instant::now();
    for _ in 0..500 {
        batch.step(&[[0.1, 0.1]; 64]).expect("a step");
    }
    let per_s = f64::from(500 * 64 * TICKS) / begun.elapsed().as_secs_f64();
    println!("fast, 64 environments: {per_s:.0} ticks a second");
}
