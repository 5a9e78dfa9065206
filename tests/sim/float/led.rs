//! Arms that are left where they are, and led by a hand.

use super::{COUNT_RAD, LEG_NS, floating, hidden, lead};
use armbridge_board::bridge::Channels;
use armbridge_control::arm::State;
use armbridge_link::message::{Drive, Mode, Record, Setup};
use armbridge_servo::JOINTS;
use armbridge_sim::Bench;
use armbridge_sim::plant::{Lead, Plant, PlantConfig};
use armbridge_tests::bench_run;
use nalgebra::Vector2;

pub(super) const MS: u64 = 1_000_000;
/// Spacing of observations.
const SPACING_NS: u64 = 2 * MS;

/// True state of the arm, and the hand's torque on its joints.
#[derive(Clone, Copy, Debug)]
pub(super) struct Seen {
    pub(super) state: State<f64>,
    pub(super) hand_nm: Vector2<f64>,
}

impl Seen {
    fn of(plant: &Plant) -> Self {
        let hand_nm = plant.true_state().push_nm.map(f64::from);
        Self {
            state: plant.state(),
            hand_nm: hand_nm.into(),
        }
    }
}

/// A run under a board that floats.
pub(super) struct Floated {
    /// From its start on.
    pub(super) seen: Vec<Seen>,
    /// Mode at its end.
    pub(super) mode: Mode,
    /// Records of the board.
    pub(super) records: Vec<Record>,
}

/// Runs an arm under a board that floats, on a bench prepared by `prepare`.
pub(super) fn float_with(
    config: &PlantConfig,
    setup: Setup,
    seed: u64,
    until_ms: u64,
    prepare: impl FnOnce(&mut Bench),
) -> Floated {
    let mut channels = Channels::new();
    let script = floating(setup, until_ms * 1_000);
    let mut run = bench_run(&mut channels, *config, seed, script);
    prepare(&mut run.bench);
    let seen = (0..until_ms * MS / SPACING_NS).map(|k| {
        let at_us = k * SPACING_NS / 1_000;
        while run.now_us() < at_us {
            run.step_until(at_us).unwrap();
        }
        Seen {
            state: run.bench.state_at(at_us),
            ..Seen::of(run.bench.plant())
        }
    });
    let seen = seen.collect();
    let records = run.host.into_parts().0;
    Floated {
        seen,
        mode: records.last().unwrap().mode,
        records,
    }
}

/// The same, which floats to the end.
fn float(
    config: &PlantConfig,
    setup: Setup,
    seed: u64,
    lead: Option<&Lead>,
    until_ms: u64,
) -> Vec<Seen> {
    let floated = float_with(config, setup, seed, until_ms, |bench| {
        if let Some(lead) = lead {
            bench.lead(lead);
        }
    });
    let drive = floated.mode.drive();
    assert_eq!(drive, Some(Drive::Float), "seed {seed}: {:?}", floated.mode);
    floated.seen
}

/// Mean torque of the hand along the way of each joint in N m: its work over the way.
fn mean_nm(seen: &[Seen]) -> [f64; JOINTS] {
    [0, 1].map(|joint| {
        let work = |two: &[Seen]| {
            let way = two[1].state.q[joint] - two[0].state.q[joint];
            0.5 * (two[0].hand_nm[joint] + two[1].hand_nm[joint]) * way
        };
        let way = seen[seen.len() - 1].state.q[joint] - seen[0].state.q[joint];
        seen.windows(2).map(work).sum::<f64>() / way.abs()
    })
}

pub(super) fn part(seen: &[Seen], from_ms: u64, to_ms: u64) -> &[Seen] {
    let index = |ms: u64| (ms * MS / SPACING_NS) as usize;
    &seen[index(from_ms)..index(to_ms)]
}

/// Set-ups of boards that believe in the default arm, dry friction included.
pub(super) fn setups() -> [(&'static str, Setup); 2] {
    let friction_nm = [0.04; JOINTS];
    let observer = Setup {
        friction_nm,
        ..Setup::default()
    };
    [("observer", observer), ("Kalman filter", Setup::best())]
}

/// The arm of a hidden one that leans by 0.5 to 1 rad either way in both joints, and its angles
/// half a radian nearer to upright.
fn leaning(seed: u64, base: Setup) -> (PlantConfig, Setup, [f64; JOINTS], [f64; JOINTS]) {
    let (mut config, setup) = hidden(seed, base);
    let initial = config.initial.q.map(|q| q.signum() * (0.5 + 0.5 * q.abs()));
    config.initial.q = initial;
    let raised = initial.map(|q| q - 0.5 * q.signum());
    (config, setup, initial.into(), raised.into())
}

/// Left anywhere within 1 rad, for 6 s: from the third second on it moves by less than a count a
/// second.
#[test]
fn an_arm_stays_where_it_is_left() {
    for (name, base) in setups() {
        for seed in 1..=40 {
            let (config, setup) = hidden(seed, base);
            let seen = float(&config, setup, seed, None, 6_000);
            let rest = part(&seen, 2_000, 6_000);
            for joint in 0..JOINTS {
                let way = |from: &Seen, to: &Seen| (to.state.q[joint] - from.state.q[joint]).abs();
                let sunk = way(&seen[0], &rest[0]) / COUNT_RAD;
                assert!(
                    sunk < 20.0,
                    "{name}, seed {seed}: joint {joint} sank by {sunk} counts"
                );
                let drift = way(&rest[0], &rest[rest.len() - 1]) / COUNT_RAD / 4.0;
                assert!(
                    drift < 1.0,
                    "{name}, seed {seed}: joint {joint}, {drift} counts/s"
                );
            }
        }
    }
}

/// Raised by half a radian at 0.5 rad/s, let go while a hand moves it back: the work over the way
/// is a third of what the unpowered arm takes, and once free it comes to rest.
#[test]
fn a_hand_leads_it_with_little_force_and_it_comes_to_rest() {
    for (name, base) in setups() {
        let (mut ratios, mut fast) = (Vec::new(), 0);
        for seed in 1..=40 {
            let (config, setup, initial, raised) = leaning(seed, base);
            let hand = lead(3_000 * MS, &[raised, initial], LEG_NS + LEG_NS / 2);
            let seen = float(&config, setup, seed, Some(&hand), 9_000);
            let leg_ms = LEG_NS / MS;
            let led_nm = mean_nm(part(&seen, 3_000, 3_000 + leg_ms));
            let free = PlantConfig {
                held: false,
                ..config
            };
            let mut unpowered = Plant::new(free, seed);
            unpowered.lead(&lead(0, &[initial, raised], 2 * LEG_NS));
            let unpowered: Vec<Seen> = (0..2 * LEG_NS / SPACING_NS)
                .map(|k| {
                    unpowered.advance(k * SPACING_NS);
                    Seen::of(&unpowered)
                })
                .collect();
            let unpowered_nm = mean_nm(part(&unpowered, leg_ms, 2 * leg_ms));
            let ratio = led_nm.iter().sum::<f64>() / unpowered_nm.iter().sum::<f64>();
            println!(
                "{name}, seed {seed}: {led_nm:.3?} N m, {unpowered_nm:.3?} unpowered: {ratio:.2}"
            );
            ratios.push(ratio);
            for nm in led_nm {
                assert!(nm.abs() < 0.165, "{name}, seed {seed}: {led_nm:?} N m");
            }
            // Free from here on.
            let free = part(&seen, 3_000 + leg_ms * 3 / 2, 9_000);
            let fastest = |seen: &[Seen]| {
                let speeds = seen.iter().map(|seen| seen.state.dq.amax());
                speeds.fold(0.0, f64::max)
            };
            let first = free[0].state.dq.amax();
            // The hidden residual of two arms is more than the friction that is left to them.
            let gain = fastest(free) - first;
            assert!(gain < 0.2, "{name}, seed {seed}: {gain} rad/s faster");
            fast += u32::from(gain > 0.02);
            let last = fastest(part(free, 3_000, 4_200));
            assert!(last < 0.05, "{name}, seed {seed}: still {last} rad/s");
        }
        let worst = ratios.iter().copied().fold(0.0, f64::max);
        let mean = ratios.iter().sum::<f64>() / ratios.len() as f64;
        println!("{name}: {mean:.3} of the unpowered arm's force, at most {worst:.3}");
        assert!(mean < 1.0 / 3.0 && worst < 0.4, "{name}: {mean}, {worst}");
        assert!(fast <= 2, "{name}: {fast} arms gain speed");
    }
}
