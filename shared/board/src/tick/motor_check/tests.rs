//! The check on simulated joints: right, wrong, swapped and held ones.

use super::*;
use armbridge_control::arm::State;

/// Encoder count in rad.
const COUNT_RAD: f32 = 0.005_118;

/// Deviations from the model.
#[derive(Clone, Copy, Debug)]
struct Truth {
    /// Sign and strength of each motor.
    gain: [f32; 2],
    is_swapped: bool,
    coulomb_nm: f32,
    from_rad: [f32; 2],
    push: Push,
}

/// A torque from outside, between two times.
#[derive(Clone, Copy, Debug)]
struct Push {
    torque_nm: [f32; 2],
    between_s: [f32; 2],
}

impl Push {
    const NONE: Self = Self {
        torque_nm: [0.0; 2],
        between_s: [0.0; 2],
    };

    /// One of 0.05 to 0.8 N m on one joint, at a random time.
    fn random(noise: &mut Noise) -> Self {
        let mut draw = |from: f32, to: f32| from + (to - from) * noise.uniform();
        let size_nm = draw(0.05, 0.8) * if draw(0.0, 1.0) < 0.5 { -1.0 } else { 1.0 };
        let is_first = draw(0.0, 1.0) < 0.5;
        let from_s = draw(0.0, 0.3);
        Self {
            torque_nm: if is_first {
                [size_nm, 0.0]
            } else {
                [0.0, size_nm]
            },
            between_s: [from_s, from_s + draw(0.02, 0.3)],
        }
    }
}

const RIGHT: Truth = Truth {
    gain: [1.0; 2],
    is_swapped: false,
    coulomb_nm: 0.04,
    from_rad: [0.02, -0.02],
    push: Push::NONE,
};

/// Gaussian noise of one count.
struct Noise(u32);

impl Noise {
    fn next(&mut self) -> f32 {
        let sum: f32 = (0..12).map(|_| self.uniform()).sum();
        sum - 6.0
    }

    /// From 0 to 1.
    fn uniform(&mut self) -> f32 {
        self.0 = self.0.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (self.0 >> 8) as f32 / (1 << 24) as f32
    }
}

/// Result of a check, and the largest motion in rad.
fn check(truth: &Truth, period_us: u32, seed: u32) -> (Result<(), Fault>, f32) {
    /// Steps of the simulation in a tick.
    const STEPS: u32 = 20;
    let arm = Parameters::<f32>::paper();
    let (mut check, mut noise) = (MotorCheck::default(), Noise(seed));
    let mut plant = State::at_rest(Vector2::from(truth.from_rad));
    let (mut estimate, mut in_force_nm) = (plant.q, Vector2::zeros());
    let step_s = period_us as f32 * 1e-6 / STEPS as f32;
    let mut largest_rad: f32 = 0.0;
    // Swapped servos are known by the other's name.
    let named = |pair: Vector2<f32>| {
        if truth.is_swapped {
            Vector2::new(pair.y, pair.x)
        } else {
            pair
        }
    };
    for tick in 0..10_000 {
        let at_s = tick as f32 * period_us as f32 * 1e-6;
        let [from_s, to_s] = truth.push.between_s;
        let is_pushed = (from_s..to_s).contains(&at_s);
        let true_rad = named(plant.q);
        let measured_rad = [0, 1]
            .map(|joint| Some((true_rad[joint] / COUNT_RAD + noise.next()).round() * COUNT_RAD));
        // An observer of 15 ms.
        let share = (period_us as f32 / 15e3).min(1.0);
        for joint in 0..2 {
            estimate[joint] += share * (measured_rad[joint].unwrap() - estimate[joint]);
        }
        let input = CheckInput {
            noise_rad2: [COUNT_RAD * COUNT_RAD; 2],
            arm: &arm,
            acceleration_rad_s2: 16.0,
            period_us,
            measured_rad,
            angle_rad: estimate,
            in_force_nm,
        };
        let next_nm = match check.tick(&input) {
            CheckStep::Torque(torque_nm) => torque_nm,
            CheckStep::Passed => return (Ok(()), largest_rad),
            CheckStep::Failed(violation) => return (Err(violation.fault), largest_rad),
        };
        for _ in 0..STEPS {
            let motor_nm = in_force_nm.component_mul(&Vector2::from(truth.gain));
            let mut torque_nm = named(motor_nm);
            if is_pushed {
                torque_nm += Vector2::from(truth.push.torque_nm);
            }
            let posture = Posture::of(plant.q);
            let gravity_nm = posture.gravity(&arm);
            for joint in 0..2 {
                let rest_nm = torque_nm[joint] - gravity_nm[joint];
                let is_still = plant.dq[joint].abs() < 1e-3;
                let friction_nm = if is_still {
                    rest_nm.clamp(-1.5 * truth.coulomb_nm, 1.5 * truth.coulomb_nm)
                } else {
                    truth.coulomb_nm * plant.dq[joint].signum()
                };
                torque_nm[joint] -= friction_nm;
            }
            let acceleration = arm.acceleration(&plant, torque_nm);
            plant.dq += acceleration * step_s;
            plant.q += plant.dq * step_s;
        }
        in_force_nm = next_nm;
        let moved = plant.q - Vector2::from(truth.from_rad);
        largest_rad = largest_rad.max(moved.amax());
    }
    panic!("no end: {truth:?}");
}

/// Number of 100 checks with this result. None moves a joint by a tenth of a radian.
fn count(truth: &Truth, period_us: u32, expected: Result<(), Fault>) -> u32 {
    (1..=100)
        .map(|seed| {
            let (result, moved_rad) = check(truth, period_us, seed);
            assert!(
                moved_rad < 0.1,
                "{truth:?} {period_us} {seed}: {moved_rad} rad"
            );
            u32::from(result == expected)
        })
        .sum()
}

#[test]
fn motors_that_turn_the_right_way_pass() {
    let smooth = Truth {
        coulomb_nm: 0.0,
        from_rad: [0.25, -0.25],
        ..RIGHT
    };
    let weak = Truth {
        gain: [0.8; 2],
        ..RIGHT
    };
    let strong = Truth {
        gain: [1.5; 2],
        ..RIGHT
    };
    for truth in [RIGHT, smooth, weak, strong] {
        for (period_us, least) in [(600, 100), (1_000, 100), (5_000, 100), (10_000, 99)] {
            let passed = count(&truth, period_us, Ok(()));
            assert!(passed >= least, "{truth:?} {period_us}: {passed}");
        }
    }
}

#[test]
fn a_motor_that_turns_the_wrong_way_is_found_within_a_tenth_of_a_radian() {
    for gain in [[-1.0, 1.0], [1.0, -1.0], [-1.0, -1.0]] {
        for (coulomb_nm, from_rad) in [(0.04, [0.02, -0.02]), (0.0, [0.1, 0.1])] {
            let truth = Truth {
                gain,
                coulomb_nm,
                from_rad,
                ..RIGHT
            };
            for (period_us, least) in [(600, 100), (1_000, 100), (5_000, 95), (10_000, 90)] {
                let found = count(&truth, period_us, Err(Fault::MotorDirection));
                assert!(found >= least, "{truth:?} {period_us}: {found}");
                assert_eq!(count(&truth, period_us, Ok(())), 0, "{truth:?} {period_us}");
            }
        }
    }
}

#[test]
fn swapped_servos_are_found() {
    let truth = Truth {
        is_swapped: true,
        ..RIGHT
    };
    for (period_us, named, found) in [(600, 100, 100), (1_000, 100, 100), (5_000, 85, 95)] {
        let swapped = count(&truth, period_us, Err(Fault::JointsSwapped));
        assert!(swapped >= named, "{period_us}: {swapped}");
        let passed = count(&truth, period_us, Ok(()));
        assert!(100 - passed >= found, "{period_us}: {passed} passed");
    }
}

#[test]
fn a_joint_that_is_held_is_stuck() {
    let truth = Truth {
        coulomb_nm: 0.8,
        ..RIGHT
    };
    assert_eq!(count(&truth, 1_000, Err(Fault::Stuck)), 100);
}

/// Numbers of 600 checks with a random push that pass, and that find a wrong motor.
fn pushed(gain: [f32; 2]) -> [u32; 2] {
    let mut noise = Noise(7);
    let mut counts = [0; 2];
    for seed in 1..=600 {
        let push = Push::random(&mut noise);
        let truth = Truth {
            gain,
            push,
            ..RIGHT
        };
        let (result, moved_rad) = check(&truth, 1_000, seed);
        assert!(moved_rad < 0.1, "{truth:?} {seed}: {moved_rad} rad");
        counts[0] += u32::from(result.is_ok());
        counts[1] += u32::from(result == Err(Fault::MotorDirection));
    }
    counts
}

#[test]
fn a_push_is_rarely_taken_for_a_wrong_motor_and_never_hides_one() {
    let [passed, wrong] = pushed([1.0; 2]);
    assert!(
        passed > 450 && wrong == 3,
        "{passed} passed, {wrong} called wrong"
    );
    for gain in [[-1.0, 1.0], [1.0, -1.0]] {
        let [passed, wrong] = pushed(gain);
        assert!(
            passed == 0 && wrong > 560,
            "{passed} passed, {wrong} called wrong"
        );
    }
}
