//! Model of an arm driven by the PWM of a log alone, with real-valued parameters: dry and
//! static friction, dead zones and delays.

use armbridge_analysis::identify::{FitResult, Quantity};
use armbridge_control::actuator::Joint;
use armbridge_control::arm::{Parameters, State};
use armbridge_link::message::{Record, Setup};
use armbridge_servo::{JOINTS, Pwm};
use armbridge_sim::plant::{Body, Friction, PlantConfig};
use nalgebra::Vector2;

use super::kind::Kind;
use super::truth::truth;

/// A tick in s, and in ns.
const TICK_S: f64 = 1e-3;
const TICK_NS: u64 = 1_000_000;

/// The arm, its motors and encoders.
#[derive(Clone, Copy, Debug)]
pub struct Model {
    arm: Parameters<f64>,
    joints: [Joint<f64>; JOINTS],
    friction: [Friction; JOINTS],
    /// Dead zone in counts below and above neutral; the torque begins half a count beyond,
    /// between the last PWM without torque and the next.
    dead_counts: [[f64; 2]; JOINTS],
    /// Delay from the sample of a tick's angle to the torque of its PWM.
    delay_s: [f64; JOINTS],
    stops_rad: [[f64; 2]; JOINTS],
}

impl Model {
    /// The identified arm, as in a board's set-up, and with parameters that a board lacks.
    pub fn identified(setup: &Setup, fit: &FitResult) -> Self {
        let estimate = |joint: usize, quantity: Quantity| fit.estimate(joint, quantity).0;
        Self {
            arm: setup.arm.map(f64::from),
            joints: setup.joints.map(|joint| Joint {
                zero_count: joint.zero_count.into(),
                rad_per_count: joint.rad_per_count.into(),
                direction: joint.direction,
                gain_counts_per_nm: joint.gain_counts_per_nm.into(),
                offset_counts: joint.offset_counts.into(),
            }),
            friction: core::array::from_fn(|joint| {
                // None of these arms has a Stribeck curve.
                assert_eq!(fit.stribeck[joint], None);
                let coulomb_nm = estimate(joint, Quantity::Coulomb);
                let static_nm =
                    fit.static_friction[joint].map_or(coulomb_nm, |friction| friction.torque_nm);
                Friction {
                    coulomb_nm,
                    static_nm: static_nm.max(coulomb_nm),
                    stribeck_rad_s: 0.0,
                    load: fit.load[joint].map_or(0.0, |load| load.load),
                }
            }),
            dead_counts: core::array::from_fn(|joint| {
                [Quantity::DeadBelow, Quantity::DeadAbove].map(|edge| estimate(joint, edge))
            }),
            delay_s: core::array::from_fn(|joint| estimate(joint, Quantity::Delay)),
            stops_rad: PlantConfig::default().stops_rad,
        }
    }

    /// The true arm.
    pub fn truth(kind: Kind, config: &PlantConfig) -> Self {
        Self {
            arm: config.arm,
            joints: config.joints,
            friction: config.friction,
            dead_counts: config.dead_zone_counts.map(|counts| counts.map(f64::from)),
            delay_s: core::array::from_fn(|joint| truth(kind, config, joint, Quantity::Delay)),
            stops_rad: config.stops_rad,
        }
    }

    /// At rest at these positions in counts in that tick of a log.
    ///
    /// # Panics
    ///
    /// On a step, if the log begins later than the delay before that tick.
    pub fn at_rest<'a>(&self, log: &'a [Record], tick: usize, counts: [f64; JOINTS]) -> Moving<'a> {
        let angle = |joint: usize| {
            let [zero, one] = [0.0, 1.0].map(|rad| self.joints[joint].position(rad));
            (counts[joint] - zero) / (one - zero)
        };
        let initial = State::at_rest(Vector2::new(angle(0), angle(1)));
        Moving {
            model: *self,
            log,
            tick,
            now_ns: 0,
            body: Body::new(self.arm, self.friction, self.stops_rad, initial),
        }
    }

    /// Angle of a count in rad.
    pub fn rad_per_count(&self) -> f64 {
        self.joints[0].rad_per_count
    }

    fn torque_nm(&self, joint: usize, pwm: u16) -> f64 {
        let counts = f64::from(pwm) - f64::from(Pwm::OFF.counts());
        let [below, above] = self.dead_counts[joint];
        let edge = if counts < 0.0 { below } else { above };
        if counts.abs() < edge + 0.5 {
            return 0.0;
        }
        self.joints[joint].torque(Pwm::saturating(pwm))
    }
}

/// A model driven by a log.
pub struct Moving<'a> {
    model: Model,
    log: &'a [Record],
    tick: usize,
    now_ns: u64,
    body: Body,
}

impl Moving<'_> {
    /// The encoders' counts without noise.
    pub fn counts(&self) -> [f64; JOINTS] {
        let state = self.body.state(self.now_ns);
        core::array::from_fn(|joint| self.model.joints[joint].position(state.q[joint]))
    }

    /// Advances to the next tick.
    pub fn step(&mut self) {
        let ticks = self.model.delay_s.map(|delay_s| delay_s.max(0.0) / TICK_S);
        let torque_nm = |joint: usize, before: usize| {
            let pwm = self.log[self.tick - before].input.pwm_in_force[joint];
            self.model.torque_nm(joint, pwm)
        };
        let mut now_nm = Vector2::from_fn(|joint, _| torque_nm(joint, ticks[joint] as usize + 1));
        self.body.set_torque(self.now_ns, now_nm);
        let part = ticks.map(|ticks| (ticks.fract() * TICK_NS as f64) as u64);
        let order = if part[0] <= part[1] { [0, 1] } else { [1, 0] };
        for joint in order {
            now_nm[joint] = torque_nm(joint, ticks[joint] as usize);
            self.body.set_torque(self.now_ns + part[joint], now_nm);
        }
        self.tick += 1;
        self.now_ns += TICK_NS;
        self.body.advance(self.now_ns);
    }
}
