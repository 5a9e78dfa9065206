//! The virtual arm: exact dynamics, dry friction, end stops, PWM in, encoder
//! counts out.
//!
//! [`Plant`] is what two servos are bolted to. Time is virtual, in ns since the
//! arm came to be, and passed in with every call; calls are made in the order
//! of time, and one that comes late counts as made at the time of the latest.
//! Nothing sleeps, and the same configuration, seed and calls give the same
//! bits. The motion depends on the commands and their times alone, see
//! [`body`]; the noise of an encoder on how often that encoder was read.
//!
//! | step              | what is simulated                                   |
//! |-------------------|-----------------------------------------------------|
//! | PWM to torque     | equation (5), 1000 = off, gain and offset errors, dead zone, delay, limit |
//! | torque to motion  | equation (1), exact Coriolis, viscous and dry friction, stops |
//! | motion to counts  | calibration, Gaussian noise, rounding, 0..=1023      |
//!
//! What is left out: gear elasticity, backlash, supply sag, heat.

pub mod body;
mod config;

pub use body::{Body, Friction};
pub use config::PlantConfig;

use armbridge_shared::JOINTS;
use armbridge_shared::actuator::Pwm;
use armbridge_shared::arm::State;
use nalgebra::Vector2;
use rand_distr::{Distribution, StandardNormal};
use rand_pcg::Pcg32;
use std::collections::VecDeque;

/// PWM at which a Morpheus servo switches its motor off.
const OFF: u16 = Pwm::OFF.counts();
/// Largest count of an AX-12A's encoder.
const LARGEST_COUNT: f64 = 1023.0;

/// The arm with its motors and encoders.
#[derive(Clone, Debug)]
pub struct Plant {
    config: PlantConfig,
    body: Body,
    now_ns: u64,
    held: bool,
    pwm: [u16; JOINTS],
    /// Commands on their way to the motors, earliest first.
    delayed: VecDeque<Command>,
    noise: [Pcg32; JOINTS],
}

#[derive(Clone, Copy, Debug)]
struct Command {
    at_ns: u64,
    servo: usize,
    pwm: u16,
}

impl Plant {
    /// At time zero, motors off. The seed is that of the encoders' noise.
    pub fn new(config: PlantConfig, seed: u64) -> Self {
        let body = Body::new(
            config.true_arm(),
            config.true_friction(),
            config.stops_rad,
            config.initial,
        );
        Self {
            config,
            body,
            now_ns: 0,
            held: config.held,
            pwm: [OFF; JOINTS],
            delayed: VecDeque::new(),
            // One stream per encoder: reading one does not change the other.
            noise: core::array::from_fn(|servo| Pcg32::new(seed, servo as u64)),
        }
    }

    /// A servo applies a PWM from `at_ns` on.
    ///
    /// # Panics
    ///
    /// If there is no such servo; they are 0 and 1.
    pub fn drive(&mut self, servo: usize, at_ns: u64, pwm: u16) {
        assert!(servo < JOINTS, "no servo {servo} on this arm");
        self.advance(at_ns);
        let command = Command {
            at_ns: self.now_ns + self.config.input_delay_ns,
            servo,
            pwm,
        };
        if command.at_ns <= self.now_ns {
            self.apply(command);
        } else {
            self.delayed.push_back(command);
        }
    }

    /// A servo converts its position: encoder counts at `at_ns`.
    ///
    /// # Panics
    ///
    /// If there is no such servo; they are 0 and 1.
    pub fn read(&mut self, servo: usize, at_ns: u64) -> u16 {
        assert!(servo < JOINTS, "no servo {servo} on this arm");
        self.advance(at_ns);
        let noise: f64 = StandardNormal.sample(&mut self.noise[servo]);
        let position = self.config.joints[servo].position(self.state().q[servo]);
        (position + self.config.noise_lsb_rms * noise)
            .round()
            .clamp(0.0, LARGEST_COUNT) as u16
    }

    /// Lets time pass.
    pub fn advance(&mut self, to_ns: u64) {
        self.now_ns = self.now_ns.max(to_ns);
        while let Some(&command) = self.delayed.front() {
            if command.at_ns > self.now_ns {
                break;
            }
            self.delayed.pop_front();
            self.apply(command);
        }
        if self.held {
            self.body.hold(self.now_ns);
        } else {
            self.body.advance(self.now_ns);
        }
    }

    /// True angles and speeds, now.
    pub fn state(&self) -> State<f64> {
        self.body.state(self.now_ns)
    }

    /// True motor torque in N m, now.
    pub fn torque(&self) -> Vector2<f64> {
        self.body.torque()
    }

    fn apply(&mut self, command: Command) {
        if self.held && command.pwm != OFF {
            self.body.hold(command.at_ns);
            self.held = false;
        }
        self.pwm[command.servo] = command.pwm;
        let torque = Vector2::from_fn(|servo, _| self.config.torque(servo, self.pwm[servo]));
        self.body.set_torque(command.at_ns, torque);
    }
}
