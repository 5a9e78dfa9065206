//! Equation of motion of a servo on a pendulum, simulated from a recording's goals.
//!
//! ```text
//! J q'' = motor - b q' - m g l sin(q - zero) - friction
//! motor = kt/R V duty - kt²/R q'                  driven; V as recorded
//! motor = 0                                       not driven: the winding is open
//! duty  = D kp (goal - q), from -1 to 1
//! |friction| <= coulomb + (load + load_static S) |motor + m g l sin(q - zero)|
//! S     = exp(-(q' / stribeck)²)
//! ```
//!
//! Load friction grows with the torques on both ends of the gears: while a motor holds a load,
//! motor and weight press upon the same teeth, and their magnitudes add up.
//!
//! Dry friction and viscous friction are implicit in a step, the rest is explicit: friction stops
//! the pendulum within a step if it can, and never reverses it. So it sticks without a threshold
//! of speed.

use super::parameters::{Parameters, Quantity};
use super::recording::{Recording, Sample};

/// Standard gravity in m/s².
pub(super) const GRAVITY_M_S2: f64 = 9.80665;
/// Duty per rad and unit of gain of an XL330: 4096 counts a turn, 256 units of gain for one of
/// PWM per count, 885 units of PWM at full duty.
const DUTY_PER_RAD: f64 = 4096.0 / (core::f64::consts::TAU * 256.0 * 885.0);
/// Longest step in s: a quarter of it changes the error of a recording's simulation by 0.01
/// degrees. A step acts as half its length of delay, by which that of the goals is too large.
pub(super) const STEP_MAX_S: f64 = 1e-3;

/// The goals as the servo has them: late, and between samples on a line.
pub(super) struct Goals<'a> {
    samples: &'a [Sample],
    delay_s: f64,
    index: usize,
}

impl<'a> Goals<'a> {
    pub(super) fn new(samples: &'a [Sample], parameters: &Parameters) -> Self {
        Self {
            samples,
            delay_s: parameters.get(Quantity::Delay),
            index: 0,
        }
    }

    /// Goal in rad at a time, and the supply in V if the motor is driven; times only grow.
    pub(super) fn at(&mut self, time_s: f64) -> (f64, Option<f64>) {
        let time_s = time_s - self.delay_s;
        let is_past = |sample: &Sample| sample.time_s <= time_s;
        while self.samples.get(self.index + 1).is_some_and(is_past) {
            self.index += 1;
        }
        let before = &self.samples[self.index];
        let goal_rad = match self.samples.get(self.index + 1) {
            Some(next) if time_s > before.time_s => {
                let share = (time_s - before.time_s) / (next.time_s - before.time_s);
                before.goal_rad + share * (next.goal_rad - before.goal_rad)
            }
            _ => before.goal_rad,
        };
        (goal_rad, before.is_driven.then_some(before.supply_v))
    }
}

/// A pendulum in motion.
struct Pendulum {
    angle_rad: f64,
    speed_rad_s: f64,
}

/// Constants of a simulation.
pub(super) struct Plant {
    pub(super) inertia_kg_m2: f64,
    pub(super) gravity_nm: f64,
    pub(super) zero_rad: f64,
    duty_per_rad: f64,
    stall_nm_v: f64,
    pub(super) back_emf: f64,
    pub(super) viscous: f64,
    pub(super) coulomb_nm: f64,
    pub(super) load: f64,
    load_static: f64,
    stribeck_rad_s: f64,
}

impl Plant {
    pub(super) fn new(recording: &Recording, parameters: &Parameters) -> Self {
        let get = |quantity| parameters.get(quantity);
        Self {
            inertia_kg_m2: recording.inertia_kg_m2 + get(Quantity::RotorInertia),
            gravity_nm: recording.gravity_nm,
            zero_rad: get(Quantity::Zero),
            duty_per_rad: DUTY_PER_RAD * recording.gain,
            stall_nm_v: get(Quantity::StallTorque),
            back_emf: get(Quantity::BackEmf),
            viscous: get(Quantity::Viscous),
            coulomb_nm: get(Quantity::Coulomb),
            load: get(Quantity::Load),
            load_static: get(Quantity::LoadStatic),
            // A form without this parameter has none of those that it would multiply.
            stribeck_rad_s: get(Quantity::StribeckSpeed).max(1e-9),
        }
    }

    /// Torque of the motor at rest in N m, as the servo's controller drives it.
    pub(super) fn stall_nm(&self, angle_rad: f64, goal_rad: f64, supply_v: Option<f64>) -> f64 {
        supply_v.map_or(0.0, |supply_v| {
            let duty = (self.duty_per_rad * (goal_rad - angle_rad)).clamp(-1.0, 1.0);
            self.stall_nm_v * supply_v * duty
        })
    }

    fn step(&self, pendulum: &mut Pendulum, goal_rad: f64, supply_v: Option<f64>, step_s: f64) {
        let Pendulum {
            angle_rad,
            speed_rad_s,
        } = *pendulum;
        let stall_nm = self.stall_nm(angle_rad, goal_rad, supply_v);
        let back_emf = supply_v.map_or(0.0, |_| self.back_emf);
        let weight_nm = self.gravity_nm * (angle_rad - self.zero_rad).sin();
        let gears_nm = (stall_nm - back_emf * speed_rad_s + weight_nm).abs();
        let rest = (-(speed_rad_s / self.stribeck_rad_s).powi(2)).exp();
        let friction_nm = self.coulomb_nm + (self.load + self.load_static * rest) * gears_nm;
        // Momentum without dry friction, and what dry friction can take of it.
        let damped = self.inertia_kg_m2 + step_s * (self.viscous + back_emf);
        let momentum = self.inertia_kg_m2 * speed_rad_s + step_s * (stall_nm - weight_nm);
        let left = (momentum.abs() - step_s * friction_nm).max(0.0);
        pendulum.speed_rad_s = left.copysign(momentum) / damped;
        pendulum.angle_rad += step_s * pendulum.speed_rad_s;
    }
}

/// Angles in rad of a simulated pendulum at a recording's samples, from the first one on.
pub fn simulate(recording: &Recording, parameters: &Parameters) -> Vec<f64> {
    simulate_in_steps(recording, parameters, STEP_MAX_S)
}

fn simulate_in_steps(recording: &Recording, parameters: &Parameters, step_max_s: f64) -> Vec<f64> {
    let samples = &recording.samples;
    let plant = Plant::new(recording, parameters);
    let mut goals = Goals::new(samples, parameters);
    let mut pendulum = Pendulum {
        angle_rad: samples.first().map_or(0.0, |sample| sample.angle_rad),
        speed_rad_s: recording.initial_speed_rad_s,
    };
    let mut angles_rad = Vec::with_capacity(samples.len());
    angles_rad.push(pendulum.angle_rad);
    for pair in samples.windows(2) {
        let duration_s = pair[1].time_s - pair[0].time_s;
        let steps = (duration_s / step_max_s).ceil().max(1.0);
        let step_s = duration_s / steps;
        for step in 0..steps as usize {
            let time_s = pair[0].time_s + (step as f64 + 0.5) * step_s;
            let (goal_rad, supply_v) = goals.at(time_s);
            plant.step(&mut pendulum, goal_rad, supply_v, step_s);
        }
        angles_rad.push(pendulum.angle_rad);
    }
    angles_rad
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Lets a pendulum of 1 N m and 0.01 kg m² go at an angle, not driven.
    fn let_go(angle_rad: f64, parameters: &Parameters, step_s: f64) -> Vec<f64> {
        let sample = |i: usize| Sample {
            time_s: i as f64 * 0.01,
            angle_rad,
            goal_rad: 0.0,
            is_driven: false,
            supply_v: 7.4,
        };
        let recording = Recording {
            name: String::new(),
            trajectory: String::new(),
            gain: 100.0,
            gravity_nm: 1.0,
            inertia_kg_m2: 0.006,
            initial_speed_rad_s: 0.0,
            samples: (0..200).map(sample).collect(),
        };
        simulate_in_steps(&recording, parameters, step_s)
    }

    fn smooth() -> Parameters {
        Parameters::default().with(Quantity::RotorInertia, 0.004)
    }

    #[test]
    fn without_friction_it_swings_as_a_pendulum() {
        let angles_rad = let_go(0.01, &smooth(), 1e-4);
        for (i, angle_rad) in angles_rad.iter().enumerate() {
            // Ten rad/s.
            let expected = 0.01 * (i as f64 * 0.1).cos();
            assert!((angle_rad - expected).abs() < 2e-5, "{i}: {angle_rad}");
        }
    }

    #[test]
    fn it_sticks_while_friction_holds_the_weight() {
        // 0.479 N m of weight; load friction is a share of it.
        for (parameters, sticks) in [
            (smooth().with(Quantity::Coulomb, 0.49), true),
            (smooth().with(Quantity::Coulomb, 0.47), false),
            (smooth().with(Quantity::Load, 1.01), true),
            (smooth().with(Quantity::Load, 0.99), false),
            (
                smooth()
                    .with(Quantity::Load, 0.5)
                    .with(Quantity::LoadStatic, 0.51),
                true,
            ),
        ] {
            let parameters = parameters.with(Quantity::StribeckSpeed, 0.3);
            let angles_rad = let_go(0.5, &parameters, 5e-4);
            assert_eq!(angles_rad[199].to_bits() == 0.5_f64.to_bits(), sticks);
        }
    }

    #[test]
    fn coulomb_friction_takes_as_much_from_every_swing() {
        let angles_rad = let_go(0.1, &smooth().with(Quantity::Coulomb, 0.02), 1e-4);
        // Two frictions over the weight's slope a half period: 0.1, -0.06, 0.02, stuck.
        let least = angles_rad.iter().copied().fold(0.0, f64::min);
        assert!((least + 0.06).abs() < 1e-3, "{least}");
        assert!((angles_rad[199] - 0.02).abs() < 1e-3, "{}", angles_rad[199]);
    }

    #[test]
    fn a_goal_is_late_by_the_delay() {
        let sample = |i: usize| Sample {
            time_s: i as f64 * 0.01,
            angle_rad: 0.0,
            goal_rad: i as f64,
            is_driven: i > 1,
            supply_v: 7.4,
        };
        let samples: Vec<Sample> = (0..5).map(sample).collect();
        let mut goals = Goals {
            samples: &samples,
            delay_s: 0.005,
            index: 0,
        };
        for (time_s, goal_rad, is_driven) in [
            (0.0, 0.0, false),
            (0.010, 0.5, false),
            (0.0249, 1.99, false),
            (0.0251, 2.01, true),
            (0.1, 4.0, true),
        ] {
            let found = goals.at(time_s);
            assert!((found.0 - goal_rad).abs() < 1e-9, "{time_s}: {found:?}");
            assert_eq!(found.1.is_some(), is_driven, "{time_s}");
        }
    }
}
