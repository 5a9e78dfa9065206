//! The sampled loop that the paper closed over USB: every period it reads both
//! encoders, estimates, decides and sends two PWMs, to the bench's virtual arm.
//!
//! ```text
//! k T   angles = read      state = correct(angles)
//!       torque = law(k T, state)      PWM = command(torque)
//! ```
//!
//! The encoder is rounded to counts and PWM to integers, as in the servo.
//! Nothing else is random: the encoders have no noise here, so that a run is
//! its own repetition.

use armbridge_shared::JOINTS;
use armbridge_shared::actuator::{Command, Joint, Pwm};
use armbridge_shared::arm::{Parameters, State};
use armbridge_shared::control::{DryFriction, Lqr, Setpoint};
use armbridge_shared::estimate::Estimator;
use armbridge_shared::link::limits::hard;
use armbridge_sim::plant::{Friction, Plant, PlantConfig};
use nalgebra::Vector2;

/// The paper's dead zone as a torque: half of PWM 950..1050, by equation (5).
const DEAD_ZONE_NM: [f64; JOINTS] = [50.0 / 834.0; JOINTS];

/// When a torque that was decided begins to act.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Delay {
    /// At once: the ideal that (6) and (11) suppose.
    None,
    /// One period later, which no part of the loop models: USB and Matlab.
    Unmodelled,
    /// One period later, and the law acts on the state predicted for then, as
    /// the board does.
    Predicted,
}

/// Torque that the estimator computes with.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum EstimatorInput {
    /// What the law asked for, u(k) of (11) to the letter: more than the servo
    /// can give where it is at its limit.
    Requested,
    /// What the PWM sent stands for, as the board does.
    Sent,
}

/// What the estimator believes when the arm is let go.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Start {
    /// Upright, wherever the arm is: (11) from zero.
    Upright,
    /// At the first sample, at rest.
    Sampled,
}

/// A loop about to be closed.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Loop {
    pub(crate) period_us: u32,
    pub(crate) duration_s: f64,
    pub(crate) plant: PlantConfig,
    pub(crate) delay: Delay,
    pub(crate) input: EstimatorInput,
    pub(crate) start: Start,
    /// Whether dead-zone compensation is added to the torque.
    pub(crate) compensate: bool,
}

/// One sample of a run.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Sample {
    pub(crate) time_s: f64,
    /// True angles in rad.
    pub(crate) q: Vector2<f64>,
    /// Torque that the law asked for, in N m.
    pub(crate) torque: Vector2<f64>,
}

/// A run; it ends early when the arm falls.
#[derive(Clone, Debug)]
pub(crate) struct Run {
    pub(crate) samples: Vec<Sample>,
    /// An angle went beyond the board's limit, or a torque was not a number.
    pub(crate) fell: bool,
}

/// The bench's arm, let go at rest at these angles, with noiseless encoders.
pub(crate) fn arm_at(q: [f64; JOINTS], friction: Friction) -> PlantConfig {
    PlantConfig {
        friction_on: friction != Friction::NONE,
        friction: [friction; JOINTS],
        noise_lsb_rms: 0.0,
        initial: State::at_rest(Vector2::from(q)),
        held: false,
        ..PlantConfig::default()
    }
}

impl Loop {
    /// Closes the loop, with the estimator at rest upright to begin with.
    pub(crate) fn run(
        &self,
        estimator: &Estimator<f64>,
        law: impl Fn(f64, &State<f64>) -> Vector2<f64>,
    ) -> Run {
        let period_ns = u64::from(self.period_us) * 1000;
        let period_s = f64::from(self.period_us) * 1e-6;
        let joint = Joint::paper();
        let friction = DryFriction::of(if self.compensate {
            DEAD_ZONE_NM
        } else {
            [0.0; JOINTS]
        });
        let arm = Parameters::paper();
        let mut estimate = estimator.at_rest(Vector2::zeros());
        let mut plant = Plant::new(self.plant_config(period_ns), 0);
        let off = Command {
            pwm: Pwm::OFF,
            torque_nm: 0.0,
            is_limited: false,
        };
        // The estimator's torque, which acts from now on.
        let mut input_nm = Vector2::zeros();
        let mut run = Run {
            samples: Vec::new(),
            fell: false,
        };
        for k in 0..(self.duration_s / period_s).round() as u64 {
            let now_ns = k * period_ns;
            let now_s = k as f64 * period_s;
            let q = [0, 1].map(|servo| joint.angle(plant.read(servo, now_ns)));
            if k == 0 && self.start == Start::Sampled {
                estimate = estimator.at_rest(Vector2::from(q));
            }
            if self.delay != Delay::Predicted && k > 0 {
                estimator.advance(&arm, &mut estimate, input_nm);
            }
            let mut state = estimator.correct(&mut estimate, q.map(Some));
            let mut acts_s = now_s;
            if self.delay == Delay::Predicted {
                state = estimator.advance(&arm, &mut estimate, input_nm);
                acts_s += period_s;
            }
            // The disturbance torque is taken off, by an estimator that has it.
            let torque = law(acts_s, &state) - estimate.disturbance();
            let truth = plant.state().q;
            run.samples.push(Sample {
                time_s: now_s,
                q: truth,
                torque,
            });
            let added = friction.feed_forward(torque, Vector2::zeros());
            let commands = [0, 1].map(|j| {
                joint
                    .command(torque[j] + added[j], hard::PWM_COUNTS)
                    .unwrap_or(off)
            });
            for (servo, command) in commands.iter().enumerate() {
                plant.drive(servo, now_ns, command.pwm.counts());
            }
            input_nm = match self.input {
                EstimatorInput::Requested => torque,
                EstimatorInput::Sent => {
                    Vector2::from(commands.map(|command| command.torque_nm)) - added
                }
            };
            if truth.amax() > f64::from(hard::ANGLE_RAD) || !torque.iter().all(|t| t.is_finite()) {
                run.fell = true;
                break;
            }
        }
        run
    }

    /// The same under K of (10) about upright.
    pub(crate) fn regulate(&self, estimator: &Estimator<f64>) -> Run {
        let (lqr, upright) = (Lqr::paper(), upright());
        self.run(estimator, |_, state| lqr.torque(state, &upright))
    }

    fn plant_config(&self, period_ns: u64) -> PlantConfig {
        let delayed = self.delay != Delay::None;
        PlantConfig {
            input_delay_ns: [if delayed { period_ns } else { 0 }; JOINTS],
            ..self.plant
        }
    }
}

/// Upright takes no torque.
pub(crate) fn upright() -> Setpoint<f64> {
    Setpoint::new(&Parameters::paper(), Vector2::zeros())
}

impl Run {
    /// A joint's angle over time.
    pub(crate) fn angle(&self, joint: usize) -> Vec<(f64, f64)> {
        self.samples
            .iter()
            .map(|s| (s.time_s, s.q[joint]))
            .collect()
    }

    /// Largest angle of either joint in the last seconds; infinite if it fell.
    pub(crate) fn rest_rad(&self, last_s: f64) -> f64 {
        if self.fell {
            return f64::INFINITY;
        }
        let end_s = self.samples.last().map_or(0.0, |s| s.time_s);
        self.largest(|sample| {
            let late = sample.time_s > end_s - last_s;
            if late { sample.q.amax() } else { 0.0 }
        })
    }

    /// Largest torque asked for, in N m.
    pub(crate) fn peak_nm(&self) -> f64 {
        self.largest(|sample| sample.torque.amax())
    }

    /// Root mean square of a joint's distance from `goal` after `from_s`;
    /// infinite if it fell.
    pub(crate) fn rms(&self, joint: usize, from_s: f64, goal: impl Fn(f64) -> f64) -> f64 {
        if self.fell {
            return f64::INFINITY;
        }
        let late = || self.samples.iter().filter(|s| s.time_s >= from_s);
        let squares = late().map(|s| (s.q[joint] - goal(s.time_s)).powi(2));
        (squares.sum::<f64>() / late().count() as f64).sqrt()
    }

    fn largest(&self, of: impl Fn(&Sample) -> f64) -> f64 {
        self.samples.iter().map(of).fold(0.0, f64::max)
    }
}
