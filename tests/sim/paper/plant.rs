//! Properties of the virtual arm.

use armbridge_control::actuator::{Direction, Joint};
use armbridge_control::arm::{Parameters, State};
use armbridge_servo::JOINTS;
use armbridge_sim::plant::{Plant, PlantConfig, Push};
use nalgebra::Vector2;

const MS: u64 = 1_000_000;

fn released(q: [f64; 2]) -> PlantConfig {
    PlantConfig {
        initial: State::at_rest(Vector2::from(q)),
        held: false,
        ..PlantConfig::default()
    }
}

fn frictionless(q: [f64; 2]) -> PlantConfig {
    PlantConfig {
        friction_on: false,
        ..released(q)
    }
}

/// A second of commands at odd times.
fn drive(plant: &mut Plant, mut between: impl FnMut(&mut Plant, u64)) {
    for k in 0..200_u64 {
        let at_ns = k * 5 * MS + (k * 7919) % MS;
        between(plant, at_ns);
        plant.drive((k % 2) as usize, at_ns, 900 + ((k * 37) % 230) as u16);
    }
}

#[test]
fn motion_does_not_depend_on_how_often_one_looks() {
    for config in [released([0.2, -0.1]), frictionless([0.2, -0.1])] {
        let mut silent = Plant::new(config, 1);
        drive(&mut silent, |_, _| {});
        let mut watched = Plant::new(config, 1);
        drive(&mut watched, |plant, at_ns| {
            for back in [3 * MS, 2 * MS + 17, MS, 1] {
                plant.advance(at_ns.saturating_sub(back));
                plant.read(0, at_ns.saturating_sub(back));
                let _ = plant.state();
            }
        });
        for plant in [&mut silent, &mut watched] {
            plant.advance(1_234_567_891);
        }
        assert_eq!(silent.state(), watched.state());
        assert_ne!(silent.state().dq, Vector2::zeros());
    }
}

#[test]
fn same_seed_same_bits_other_seed_other_noise() {
    let readings = |seed| {
        let mut plant = Plant::new(released([0.0, 0.0]), seed);
        let mut readings = Vec::new();
        drive(&mut plant, |plant, at_ns| {
            readings.push([plant.read(0, at_ns), plant.read(1, at_ns)]);
        });
        readings
    };
    assert_eq!(readings(1), readings(1));
    assert_ne!(readings(1), readings(2));
}

#[test]
fn sensor_noise_is_one_count_rms_and_independent() {
    let mut plant = Plant::new(PlantConfig::default(), 3);
    let samples: Vec<[f64; 2]> = (0..20_000)
        .map(|k| [0, 1].map(|servo| f64::from(plant.read(servo, k * MS)) - 512.0))
        .collect();
    let mean = |f: &dyn Fn(&[f64; 2]) -> f64| samples.iter().map(f).sum::<f64>() / 20_000.0;
    // One count of noise and 1/12 of rounding; the tolerances are five sigma.
    for joint in 0..2 {
        assert!(mean(&|s| s[joint]).abs() < 0.04);
        assert!((mean(&|s| s[joint] * s[joint]) - 13.0 / 12.0).abs() < 0.06);
    }
    assert!(mean(&|s| s[0] * s[1]).abs() < 0.04);
}

#[test]
fn a_stuck_joint_stays_truly_still_and_breaks_away_at_the_static_torque() {
    // 1015 is no torque by equation (5); 0.06 N m are 50 counts.
    let pushed = |pwm| {
        let mut plant = Plant::new(released([0.0, 0.0]), 1);
        plant.drive(0, 0, pwm);
        plant.advance(1000 * MS);
        plant.state()
    };
    assert_eq!(pushed(1015 + 50), State::at_rest(Vector2::zeros()));
    assert_eq!(pushed(1015 - 50), State::at_rest(Vector2::zeros()));
    assert!(pushed(1015 + 51).q.x > 0.01);
    assert!(pushed(1015 - 51).q.x < -0.01);
}

#[test]
fn a_sliding_joint_comes_to_rest_and_stays() {
    let mut config = released([0.0, 0.0]);
    config.arm.g = 0.0;
    config.initial.dq = Vector2::new(1.0, 0.0);
    let mut plant = Plant::new(config, 1);
    plant.advance(1000 * MS);
    let rest = plant.state();
    assert_eq!(rest.dq, Vector2::zeros());
    // M dv/dt = -b v - c from v0: x = (M/b) (v0 - (c/b) ln(1 + b v0/c)).
    let arm = Parameters::<f64>::paper();
    let (mass, b, c) = (arm.mass(rest.q)[(0, 0)], arm.b1, 0.04);
    let way = mass / b * (1.0 - c / b * (1.0 + b / c).ln());
    assert!((rest.q.x - way).abs() < 1e-6, "{} {way}", rest.q.x);
    plant.advance(5000 * MS);
    assert_eq!(plant.state(), rest);
}

#[test]
fn a_stop_ends_the_fall_and_lets_go() {
    for config in [released([0.3, 0.0]), frictionless([0.3, 0.0])] {
        let mut plant = Plant::new(config, 1);
        plant.advance(10_000 * MS);
        let table = core::f64::consts::FRAC_PI_2;
        assert_eq!(plant.state().q.x, table);
        assert_eq!(plant.state().dq.x, 0.0);
        plant.drive(0, 10_000 * MS, 0);
        plant.advance(10_500 * MS);
        assert!(plant.state().q.x < table - 0.1);
    }
}

#[test]
fn it_is_held_until_the_first_torque() {
    let config = PlantConfig {
        held: true,
        ..frictionless([0.3, -0.2])
    };
    let mut plant = Plant::new(config, 1);
    plant.drive(0, 100 * MS, 1000);
    plant.advance(500 * MS);
    assert_eq!(plant.state(), config.initial);
    plant.drive(1, 500 * MS, 1015);
    plant.advance(600 * MS);
    // From then on it falls like one that was let go at time zero.
    let mut free = Plant::new(frictionless([0.3, -0.2]), 1);
    free.drive(1, 0, 1015);
    free.advance(100 * MS);
    assert_eq!(plant.state(), free.state());
}

#[test]
fn pwm_becomes_torque_with_every_switch() {
    let torque = |config: PlantConfig, pwm| {
        let mut plant = Plant::new(config, 1);
        plant.drive(0, 0, pwm);
        plant.torque().x
    };
    let plain = PlantConfig::default();
    let joint = Joint::<f64>::paper();
    for pwm in [0, 500, 999, 1001, 1015, 1500, 2000] {
        let by_equation_5 = (f64::from(pwm) - 1015.0) / 834.0;
        assert!((torque(plain, pwm) - by_equation_5).abs() < 1e-15);
    }
    assert_eq!(torque(plain, 1000), 0.0);
    let dead = PlantConfig {
        dead_zone_counts: [PlantConfig::PAPER_DEAD_ZONE_COUNTS; JOINTS],
        ..plain
    };
    assert_eq!([951, 1049].map(|pwm| torque(dead, pwm)), [0.0, 0.0]);
    assert!(torque(dead, 950) < 0.0 && torque(dead, 1050) > 0.0);
    let lopsided = PlantConfig {
        dead_zone_counts: [[5, 30], [0, 0]],
        ..plain
    };
    assert_eq!([995, 1030].map(|pwm| torque(lopsided, pwm)), [0.0, 0.0]);
    assert!(torque(lopsided, 994) < 0.0 && torque(lopsided, 1031) > 0.0);
    let weak = PlantConfig {
        torque_gain: 0.7,
        ..plain
    };
    assert!((torque(weak, 1849) - 0.7).abs() < 1e-15);
    let offset = PlantConfig {
        pwm_offset_counts: 15.0,
        ..plain
    };
    assert!((torque(offset, 1030)).abs() < 1e-15);
    let limited = PlantConfig {
        torque_limit_nm: 0.5,
        ..plain
    };
    assert_eq!([0, 2000].map(|pwm| torque(limited, pwm)), [-0.5, 0.5]);
    let mut reversed = plain;
    reversed.joints[0].direction = Direction::Reverse;
    assert!((torque(reversed, 1849) + 1.0).abs() < 1e-15);
    assert!((reversed.joints[0].torque(joint.pwm(1.0).unwrap()) + 1.0).abs() < 1e-15);
}

#[test]
fn a_delayed_command_is_the_same_command_later() {
    let delayed = PlantConfig {
        input_delay_ns: [3 * MS + 1, 17 * MS],
        ..frictionless([0.0, 0.0])
    };
    let mut plant = Plant::new(delayed, 1);
    let mut prompt = Plant::new(frictionless([0.0, 0.0]), 1);
    let mut later = Vec::new();
    for k in 0..50 {
        for (servo, delay_ns) in delayed.input_delay_ns.into_iter().enumerate() {
            let pwm = 1015 + (k * 13 % 60) as u16 - 25 * servo as u16;
            plant.drive(servo, k * MS, pwm);
            later.push((k * MS + delay_ns, servo, pwm));
        }
    }
    later.sort_by_key(|(at_ns, ..)| *at_ns);
    for (at_ns, servo, pwm) in later {
        prompt.drive(servo, at_ns, pwm);
    }
    for plant in [&mut plant, &mut prompt] {
        plant.advance(100 * MS);
    }
    assert_eq!(plant.state(), prompt.state());
    assert!(plant.state().q.iter().all(|q| *q != 0.0));
}

#[test]
fn scales_change_what_they_say() {
    let arm = Parameters::<f64>::paper();
    let q = Vector2::new(0.4, -0.3);
    let start = |config: PlantConfig| {
        let mut plant = Plant::new(config, 1);
        plant.advance(MS);
        // From rest, the speed after a moment is the acceleration.
        plant.state().dq / 1e-3
    };
    let plain = start(frictionless([q.x, q.y]));
    let expected = arm.acceleration(&State::at_rest(q), Vector2::zeros());
    assert!((plain - expected).amax() < 0.01 * expected.amax());
    let heavy = PlantConfig {
        inertia_scale: 1.25,
        ..frictionless([q.x, q.y])
    };
    assert!((start(heavy) * 1.25 - plain).amax() < 0.01 * plain.amax());
    let light = PlantConfig {
        gravity_scale: 0.8,
        ..frictionless([q.x, q.y])
    };
    assert!((start(light) / 0.8 - plain).amax() < 0.01 * plain.amax());
}

/// A push acts for its time and no longer, on an arm that nobody holds and that
/// does not stick.
#[test]
fn a_push_is_a_torque_for_a_time() {
    let push = |torque_nm| Push {
        joint: 0,
        torque_nm,
        start_ns: 10 * MS,
        duration_ns: 5 * MS,
    };
    let after = |config: PlantConfig, torque_nm| {
        let mut plant = Plant::new(config, 1);
        plant.push(push(torque_nm));
        plant.advance(10 * MS);
        assert_eq!(plant.state(), config.initial);
        plant.advance(15 * MS);
        let end = plant.state();
        plant.advance(16 * MS);
        assert_eq!(plant.torque(), Vector2::zeros());
        (end, plant.state())
    };
    let free = frictionless([0.0, 0.0]);
    let (end, later) = after(free, 0.1);
    let inertia = free.arm.mass(Vector2::zeros())[(0, 0)];
    let expected = 0.1 * 5e-3 / inertia;
    assert!((end.dq.x / expected - 1.0).abs() < 0.03, "{}", end.dq.x);
    assert!(later.dq.x < end.dq.x, "viscous friction alone is left");

    let held = PlantConfig { held: true, ..free };
    assert_eq!(after(held, 0.1).1, held.initial);
    let stuck = released([0.0, 0.0]);
    assert_eq!(after(stuck, 0.05).1, stuck.initial);
    assert!(after(stuck, 0.1).0.dq.x > 0.0);
}
