//! The whole loop without the bus: estimator, controller and actuator in f32 as
//! on the board, on the virtual arm, one period of input delay.

use armbridge_control::actuator::{Command, Joint};
use armbridge_control::arm::{Parameters, State};
use armbridge_control::controller::{DryFriction, Lqr, Setpoint, Weights};
use armbridge_control::estimate::Config;
use armbridge_link::limits::hard;
use armbridge_servo::{JOINTS, Pwm};
use armbridge_sim::plant::{Plant, PlantConfig};
use nalgebra::Vector2;

/// Options of a run.
#[derive(Clone, Copy)]
struct Loop {
    period_us: u32,
    gains: Option<Weights<f32>>,
    estimator: Config<f32>,
    compensate: bool,
    /// Each joint misses its sample in one tick of so many, in turn.
    lose_every: usize,
}

/// The true angles and the torque given to the estimator, at one sample.
struct Tick {
    q: Vector2<f64>,
    torque: Vector2<f64>,
}

/// Result of a run; angles in rad, torques in N m.
#[derive(Debug)]
struct Outcome {
    /// When the error was above 20 mrad for the last time, in s.
    settled_s: f64,
    /// Largest error over the last 2 s.
    rest_rad: f64,
    /// Largest peak to peak over the last 2 s.
    hunt_rad: f64,
    /// Largest torque asked for.
    peak_nm: f64,
    /// Standard deviation of the torque over the last 2 s.
    noise_nm: f64,
}

impl Loop {
    /// Six seconds of it.
    fn run(&self, plant: &PlantConfig, seed: u64, setpoint: [f32; JOINTS]) -> Outcome {
        let arm = Parameters::<f32>::paper();
        let period_s = self.period_us as f32 * 1e-6;
        let model = arm.linearise(Vector2::zeros()).zero_order_hold(period_s);
        let lqr = match &self.gains {
            Some(weights) => Lqr::design(&model, weights).expect("gains"),
            None => Lqr::paper(),
        };
        let joint = Joint::<f32>::paper();
        let friction = DryFriction::of(if self.compensate {
            // The paper's dead zone: half of 950..1050.
            [50.0 / 834.0; JOINTS]
        } else {
            [0.0; JOINTS]
        });
        let estimator = self.estimator.build(&arm, period_s).expect("an estimator");
        let target = Setpoint::new(&arm, Vector2::from(setpoint));
        let mut plant = Plant::new(*plant, seed);

        let mut now_ns = 0;
        let read =
            |plant: &mut Plant, now_ns| [0, 1].map(|servo| joint.angle(plant.read(servo, now_ns)));
        let initial = Vector2::from(read(&mut plant, now_ns));
        let mut estimate = estimator.at_rest(initial);
        let off = Command {
            pwm: Pwm::OFF,
            torque_nm: 0.0,
            is_limited: false,
        };
        let mut next = [off; JOINTS];
        let ticks = (6_000_000 / self.period_us) as usize;
        let mut trace = Vec::new();
        for tick in 0..ticks {
            now_ns += u64::from(self.period_us) * 1000;
            let mut measured = read(&mut plant, now_ns).map(Some);
            for (joint, sample) in measured.iter_mut().enumerate() {
                if (tick + joint) % self.lose_every == self.lose_every - 1 {
                    *sample = None;
                }
            }
            for (servo, command) in next.iter().enumerate() {
                plant.drive(servo, now_ns, command.pwm.counts());
            }
            let in_force = Vector2::from(next.map(|command| command.torque_nm));
            estimator.correct(&mut estimate, measured);
            let ahead = estimator.advance(&arm, &mut estimate, in_force);
            let torque = lqr.torque(&ahead, &target);
            let added = friction.feed_forward(torque - target.torque(), Vector2::zeros());
            next = [0, 1].map(|j| {
                let command = joint
                    .command(torque[j] + added[j], hard::PWM_COUNTS)
                    .expect("finite");
                Command {
                    torque_nm: command.torque_nm - added[j],
                    ..command
                }
            });
            trace.push(Tick {
                q: plant.state().q,
                torque: in_force.cast(),
            });
        }

        Outcome::of(&trace, target.q().cast(), f64::from(period_s))
    }
}

impl Outcome {
    fn of(trace: &[Tick], goal: Vector2<f64>, period_s: f64) -> Self {
        let error = |tick: &Tick| (tick.q - goal).amax();
        let last_off = trace.iter().rposition(|tick| error(tick) > 0.02);
        let tail = &trace[trace.len() - (2.0 / period_s) as usize..];
        let peak_to_peak = |joint: usize| {
            let angles = tail.iter().map(|tick| tick.q[joint]);
            angles.clone().fold(f64::MIN, f64::max) - angles.fold(f64::MAX, f64::min)
        };
        let deviation = |joint: usize| {
            let torques = tail.iter().map(|tick| tick.torque[joint]);
            let mean = torques.clone().sum::<f64>() / tail.len() as f64;
            let squares = torques.map(|torque| (torque - mean).powi(2));
            (squares.sum::<f64>() / tail.len() as f64).sqrt()
        };
        Self {
            settled_s: last_off.map_or(0.0, |tick| (tick + 1) as f64 * period_s),
            rest_rad: tail.iter().map(error).fold(0.0, f64::max),
            hunt_rad: peak_to_peak(0).max(peak_to_peak(1)),
            peak_nm: trace.iter().map(|t| t.torque.amax()).fold(0.0, f64::max),
            noise_nm: deviation(0).max(deviation(1)),
        }
    }
}

fn frictionless(q: [f64; JOINTS]) -> PlantConfig {
    PlantConfig {
        friction_on: false,
        ..from(q)
    }
}

fn from(q: [f64; JOINTS]) -> PlantConfig {
    PlantConfig {
        initial: State::at_rest(Vector2::from(q)),
        ..PlantConfig::default()
    }
}

/// 1 kHz with the paper's weights and the standing observer.
fn standing() -> Loop {
    Loop {
        period_us: 1000,
        gains: Some(Weights::paper()),
        estimator: Config::standing(),
        compensate: false,
        lose_every: usize::MAX,
    }
}

const SEEDS: core::ops::RangeInclusive<u64> = 1..=3;
const START: [f64; JOINTS] = [0.30, -0.25];
const UPRIGHT: [f32; JOINTS] = [0.0, 0.0];
const ASIDE: [f32; JOINTS] = [0.5, -0.4];
/// One encoder count in rad.
const COUNT_RAD: f64 = 0.0051;

#[test]
fn without_friction_it_settles_fast_and_rests_within_a_count() {
    for seed in SEEDS {
        for setpoint in [UPRIGHT, ASIDE] {
            let outcome = standing().run(&frictionless(START), seed, setpoint);
            assert!(outcome.settled_s < 1.3, "{outcome:?}");
            assert!(outcome.rest_rad < COUNT_RAD, "{outcome:?}");
            assert!(outcome.noise_nm < 0.02, "{outcome:?}");
            assert!(outcome.peak_nm < 1.0, "{outcome:?}");
        }
    }
}

#[test]
fn with_friction_it_rests_where_stiction_holds_it() {
    let arm = Parameters::<f64>::paper();
    let model = arm.linearise(Vector2::zeros()).zero_order_hold(0.001);
    let gain = Lqr::design(&model, &Weights::paper()).unwrap().gain;
    let stiffness =
        arm.gravity_slope(Vector2::zeros()).diagonal() + Vector2::new(gain[(0, 0)], gain[(1, 1)]);
    // 44.6 and 48.8 mrad.
    let explained = (0.06 / stiffness.x).max(0.06 / stiffness.y);
    for seed in SEEDS {
        for setpoint in [UPRIGHT, ASIDE] {
            let outcome = standing().run(&from(START), seed, setpoint);
            assert!(outcome.rest_rad < explained, "{outcome:?}");
            assert!(outcome.rest_rad > 2.0 * COUNT_RAD, "{outcome:?}");
            assert!(outcome.noise_nm < 0.02, "{outcome:?}");
        }
    }
}

#[test]
fn dead_zone_compensation_takes_that_offset_away_everywhere() {
    let compensated = Loop {
        compensate: true,
        ..standing()
    };
    for seed in SEEDS {
        for setpoint in [UPRIGHT, ASIDE] {
            for plant in [from(START), frictionless(START)] {
                let outcome = compensated.run(&plant, seed, setpoint);
                assert!(outcome.settled_s < 1.3, "{outcome:?}");
                assert!(outcome.rest_rad < COUNT_RAD, "{outcome:?}");
                assert!(outcome.hunt_rad < COUNT_RAD, "{outcome:?}");
            }
        }
    }
}

#[test]
fn the_paper_s_gain_stands_at_its_45_ms() {
    let paper = Loop {
        period_us: 45_000,
        gains: None,
        ..standing()
    };
    let difference = Loop {
        estimator: Config::FiniteDifference { filter_s: 0.0 },
        ..paper
    };
    for seed in SEEDS {
        for variant in [paper, difference] {
            let free = variant.run(&frictionless(START), seed, UPRIGHT);
            assert!(free.settled_s < 1.3, "{free:?}");
            let stuck = variant.run(&from(START), seed, UPRIGHT);
            // 0.06 N m over a stiffness of 1.079 and 0.918 N m/rad.
            assert!(stuck.rest_rad < 0.0653, "{stuck:?}");
        }
    }
}

#[test]
fn a_fifth_of_the_samples_may_be_lost() {
    let lossy = Loop {
        lose_every: 5,
        ..standing()
    };
    for seed in SEEDS {
        let outcome = lossy.run(&frictionless(START), seed, UPRIGHT);
        assert!(outcome.settled_s < 1.3, "{outcome:?}");
        assert!(outcome.rest_rad < COUNT_RAD, "{outcome:?}");
    }
}

#[test]
fn plain_differences_are_noise_at_1_khz_and_a_filter_tames_them() {
    let with = |filter_s| Loop {
        estimator: Config::FiniteDifference { filter_s },
        ..standing()
    };
    let plain = with(0.0).run(&frictionless(START), 1, UPRIGHT);
    assert!(plain.noise_nm > 0.4, "{plain:?}");
    let filtered = with(0.02).run(&frictionless(START), 1, UPRIGHT);
    assert!(filtered.settled_s < 1.3, "{filtered:?}");
    assert!(filtered.noise_nm < 0.1, "{filtered:?}");
}
