//! The sampled loop that the paper closed over USB, on the simulated arm: every period it
//! reads both encoders, estimates the state, computes torques and sends two PWM values.
//!
//! ```text
//! k T   angles = read      state = correct(angles)
//!       torque = law(k T, state)      PWM = command(torque)
//! ```
//!
//! Angles are rounded to encoder counts and PWM to integers, as in the servo.
//! The encoders have no noise here, so a run is deterministic.

use armbridge_control::actuator::{Command, Joint};
use armbridge_control::arm::{Parameters, State};
use armbridge_control::controller::{DryFriction, Lqr, Setpoint};
use armbridge_control::estimate::Estimator;
use armbridge_link::limits::hard;
use armbridge_servo::{JOINTS, Pwm};
use armbridge_sim::plant::{Friction, Plant, PlantConfig};
use nalgebra::Vector2;

/// The paper's dead zone as a torque: half of PWM 950..1050, by equation (5).
const DEAD_ZONE_NM: [f64; JOINTS] = [50.0 / 834.0; JOINTS];

/// Delay from a sample to its torque.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Delay {
    /// No delay: the ideal that (6) and (11) assume.
    None,
    /// One period that no part of the loop models: USB and Matlab.
    Unmodelled,
    /// One period; the law acts on the state predicted for its end, as on the board.
    Predicted,
}

/// Torque that is the estimator's input.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum EstimatorInput {
    /// Torque requested by the law, u(k) of (11) to the letter: more than the servo
    /// can give at its limit.
    Requested,
    /// Torque of the PWM sent, as on the board.
    Sent,
}

/// State of the estimator when the arm is released.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum InitialEstimate {
    /// Upright, whatever the arm's angles: (11) from zero.
    Upright,
    /// At rest at the first sample.
    FirstSample,
}

/// Configuration of the loop.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SampledLoop {
    pub(crate) period_us: u32,
    pub(crate) duration_s: f64,
    pub(crate) plant: PlantConfig,
    pub(crate) delay: Delay,
    pub(crate) input: EstimatorInput,
    pub(crate) start: InitialEstimate,
    /// Whether dead-zone compensation is added to the torque.
    pub(crate) compensate: bool,
}

/// One sample of a run.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Sample {
    pub(crate) time_s: f64,
    /// True angles in rad.
    pub(crate) q: Vector2<f64>,
    /// Torque requested by the law, in N m.
    pub(crate) torque: Vector2<f64>,
}

/// A run, which ends early if the arm falls.
#[derive(Clone, Debug)]
pub(crate) struct Run {
    pub(crate) samples: Vec<Sample>,
    /// An angle exceeded the board's limit, or a torque was not finite.
    pub(crate) fell: bool,
}

/// The simulated arm, released at rest at the angles `q` in rad, with noiseless encoders.
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

impl SampledLoop {
    /// Simulates the loop, in which `law` gives torques in N m from time in s and state.
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
        // The estimator's input from now on.
        let mut input_nm = Vector2::zeros();
        let mut run = Run {
            samples: Vec::new(),
            fell: false,
        };
        for k in 0..(self.duration_s / period_s).round() as u64 {
            let now_ns = k * period_ns;
            let now_s = k as f64 * period_s;
            let q = [0, 1].map(|servo| joint.angle(plant.read(servo, now_ns)));
            if k == 0 && self.start == InitialEstimate::FirstSample {
                estimate = estimator.at_rest(Vector2::from(q));
            }
            if self.delay != Delay::Predicted && k > 0 {
                estimator.advance(&arm, &mut estimate, input_nm);
            }
            let mut state = estimator.correct(&mut estimate, q.map(Some));
            let mut torque_time_s = now_s;
            if self.delay == Delay::Predicted {
                state = estimator.advance(&arm, &mut estimate, input_nm);
                torque_time_s += period_s;
            }
            // Estimators without a disturbance torque have zero.
            let torque = law(torque_time_s, &state) - estimate.disturbance();
            let truth = plant.state().q;
            run.samples.push(Sample {
                time_s: now_s,
                q: truth,
                torque,
            });
            let feed_forward = friction.feed_forward(torque, Vector2::zeros());
            let commands = [0, 1].map(|j| {
                joint
                    .command(torque[j] + feed_forward[j], hard::PWM_COUNTS)
                    .unwrap_or(off)
            });
            for (servo, command) in commands.iter().enumerate() {
                plant.drive(servo, now_ns, command.pwm.counts());
            }
            input_nm = match self.input {
                EstimatorInput::Requested => torque,
                EstimatorInput::Sent => {
                    Vector2::from(commands.map(|command| command.torque_nm)) - feed_forward
                }
            };
            if truth.amax() > f64::from(hard::ANGLE_RAD) || !torque.iter().all(|t| t.is_finite()) {
                run.fell = true;
                break;
            }
        }
        run
    }

    /// Simulates the loop under K of (10) about upright.
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

/// Setpoint upright, which takes no torque.
pub(crate) fn upright() -> Setpoint<f64> {
    Setpoint::new(&Parameters::paper(), Vector2::zeros())
}

impl Run {
    /// Angle in rad over time in s of a joint.
    pub(crate) fn angle(&self, joint: usize) -> Vec<(f64, f64)> {
        self.samples
            .iter()
            .map(|s| (s.time_s, s.q[joint]))
            .collect()
    }

    /// Largest angle of either joint in the last `last_s` seconds; infinite if the arm fell.
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

    /// Largest torque requested, in N m.
    pub(crate) fn peak_nm(&self) -> f64 {
        self.largest(|sample| sample.torque.amax())
    }

    /// RMS error of a joint against `reference` after `from_s`; infinite if the arm fell.
    pub(crate) fn rms_error(
        &self,
        joint: usize,
        from_s: f64,
        reference: impl Fn(f64) -> f64,
    ) -> f64 {
        if self.fell {
            return f64::INFINITY;
        }
        let late = || self.samples.iter().filter(|s| s.time_s >= from_s);
        let squares = late().map(|s| (s.q[joint] - reference(s.time_s)).powi(2));
        (squares.sum::<f64>() / late().count() as f64).sqrt()
    }

    fn largest(&self, quantity: impl Fn(&Sample) -> f64) -> f64 {
        self.samples.iter().map(quantity).fold(0.0, f64::max)
    }
}
