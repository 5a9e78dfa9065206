//! An unknown arm in a tracking loop designed for the paper's arm: PWM sent, and encoder
//! counts.

use armbridge_analysis::identify::Trace;
use armbridge_control::actuator::Joint;
use armbridge_control::arm::Parameters;
use armbridge_servo::JOINTS;
use armbridge_sim::plant::{Plant, PlantConfig, Push};
use nalgebra::Vector2;

/// Arrival of a PWM and sample of each joint's angle, from the start of the tick in ns.
const SENT_NS: u64 = 150_000;
const TAKEN_NS: [u64; JOINTS] = [400_000, 480_000];
/// Time from the arrival of a PWM to the sample of the angle, in s.
pub(crate) const LEAD_S: [f64; JOINTS] = [250e-6, 330e-6];
/// Stiffness in N m/rad and damping in N m s/rad.
const GAINS: [[f64; 2]; JOINTS] = [[2.5, 0.22], [1.65, 0.2]];

/// The arm and its controller.
pub(crate) struct TrackingLoop {
    plant: Plant,
    servos: [Joint<f64>; JOINTS],
    arm: Parameters<f64>,
    pub(crate) trace: Trace,
    q: [f64; JOINTS],
    v: [f64; JOINTS],
}

impl TrackingLoop {
    pub(crate) fn on(config: &PlantConfig, servos: [Joint<f64>; JOINTS], seed: u64) -> Self {
        Self {
            plant: Plant::new(*config, seed),
            servos,
            arm: Parameters::paper(),
            trace: Trace::default(),
            q: [0.0; JOINTS],
            v: [0.0; JOINTS],
        }
    }

    fn tick(&mut self, pwm: [u16; JOINTS]) {
        let now_ns = self.trace.pwm.len() as u64 * 1_000_000;
        for (joint, pwm) in pwm.into_iter().enumerate() {
            self.plant.drive(joint, now_ns + SENT_NS, pwm);
        }
        let counts = [0, 1].map(|joint| self.plant.read(joint, now_ns + TAKEN_NS[joint]));
        self.trace.pwm.push(pwm);
        self.trace.counts.push(counts.map(Some));
        for (joint, count) in counts.into_iter().enumerate() {
            let expected = self.q[joint] + self.v[joint] * 1e-3;
            let error = self.servos[joint].angle(count) - expected;
            self.q[joint] = expected + 0.1 * error;
            self.v[joint] += 5.3 * error;
        }
    }

    fn pwm(&self, joint: usize, [q, v]: [f64; 2]) -> u16 {
        let gravity = self.arm.gravity(Vector2::from(self.q))[joint];
        let viscous = [self.arm.b1, self.arm.b2][joint] * v;
        let [stiffness, damping] = GAINS[joint];
        let torque =
            gravity + viscous + stiffness * (q - self.q[joint]) + damping * (v - self.v[joint]);
        self.servos[joint].pwm(torque).unwrap().counts()
    }

    /// Applies an external torque to a joint from now on.
    pub(crate) fn apply_torque(&mut self, joint: usize, torque_nm: f64, seconds: f64) {
        self.plant.push(Push {
            joint,
            torque_nm,
            start_ns: self.trace.pwm.len() as u64 * 1_000_000,
            duration_ns: (seconds * 1e9) as u64,
        });
    }

    /// Tracks angles and speeds that are a function of the time in s.
    pub(crate) fn track(&mut self, seconds: f64, path: impl Fn(f64) -> [[f64; 2]; JOINTS]) {
        for k in 0..(seconds * 1e3) as usize {
            let aims = path(k as f64 * 1e-3);
            self.tick([self.pwm(0, aims[0]), self.pwm(1, aims[1])]);
        }
    }

    /// Moves to these angles and holds them.
    pub(crate) fn go(&mut self, to: [f64; JOINTS]) {
        const MOVES_S: f64 = 0.8;
        let from = self.q;
        self.track(1.4, |t| {
            let u = (t / MOVES_S).min(1.0);
            let progress = u.powi(3) * (10.0 - 15.0 * u + 6.0 * u * u);
            let speed = 30.0 * u * u * (1.0 - u).powi(2) / MOVES_S;
            [0, 1].map(|j| {
                let distance = to[j] - from[j];
                [from[j] + distance * progress, distance * speed]
            })
        });
    }
}
