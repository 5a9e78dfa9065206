//! The virtual arm: exact dynamics, dry friction, end stops, PWM in, encoder
//! counts out.
//!
//! [`Plant`] is the arm with two servos. Time is virtual, in ns since its creation, and
//! an argument of every call; calls are in the order of time, and a late one is executed
//! at the time of the latest. Equal configuration, seed and calls give results equal to
//! the bit. The motion depends only on the commands and their times, see [`body`]; the
//! noise of an encoder depends on the number of its readings.
//!
//! | step              | simulation                                          |
//! |-------------------|-----------------------------------------------------|
//! | PWM to torque     | equation (5), 1000 = off, gain and offset errors, dead zone, delay, limit |
//! | pushes            | an external torque on a joint, for a time            |
//! | grasps            | a spring and damper from a link to a hand that leads it |
//! | hands             | an imposed motion, then a hold, until a motor drives the arm |
//! | torque to motion  | equation (1), exact Coriolis, viscous and dry friction, stops |
//! | motion to counts  | calibration, Gaussian noise, rounding, range of the encoder |
//!
//! Not simulated: gear elasticity, backlash, supply sag, heat.

pub mod body;
mod config;
mod draw;
mod file;
mod hand;
mod motor_fault;
pub mod robot_description;

pub use armbridge_client::simulation::{Grip, Lead, LeadPoint, Push};
pub use body::{Body, Friction, Impact};
pub use config::PlantConfig;
pub use file::{BuiltinPlant, INITIAL_RAD, KEYS, KeyConflict, PLANTS, PlantError, PlantFile};
pub use motor_fault::MotorFault;

use std::collections::VecDeque;

use crate::encoder;
use armbridge_client::simulation::TrueState;
use armbridge_control::arm::State;
use armbridge_control::encoder::Encoder;
use armbridge_link::server::Touch;
use armbridge_servo::protocol2::model::Model;
use armbridge_servo::{Firmware, JOINTS, Pwm};
use body::grasp::Grasp;
use hand::Hand;
use nalgebra::Vector2;
use rand_distr::{Distribution, StandardNormal};
use rand_pcg::Pcg32;

/// PWM at which a Morpheus servo switches its motor off.
const OFF: u16 = Pwm::OFF.counts();
/// Counts from that which a stop sequence sends for a moment.
const STOP_COUNTS: u16 = 1;
/// Duration of a lift.
const LIFT_NS: u64 = Touch::LIFT_US as u64 * 1_000;

/// The arm with its motors and encoders.
#[derive(Clone, Debug)]
pub struct Plant {
    config: PlantConfig,
    body: Body,
    now_ns: u64,
    /// Guides the arm, or holds it.
    hand: Option<Hand>,
    motor_nm: Vector2<f64>,
    /// PWM of each servo, after its delay.
    pwm: [u16; JOINTS],
    motor_faults: [MotorFault; JOINTS],
    push_nm: Vector2<f64>,
    /// Pushes that have not been [taken](Plant::take_begun_push), in the order of their start.
    pushes: VecDeque<Push>,
    /// Future changes of torque, earliest first. A servo's own keep
    /// their order: its delay is always the same.
    due: VecDeque<Change>,
    noise: [Pcg32; JOINTS],
}

/// The arm at time zero.
fn initial_body(config: &PlantConfig) -> Body {
    Body::new(
        config.true_arm(),
        config.true_friction(),
        config.stops_rad,
        config.initial,
    )
}

#[derive(Clone, Copy, Debug)]
struct Change {
    at_ns: u64,
    kind: ChangeKind,
}

#[derive(Clone, Copy, Debug)]
enum ChangeKind {
    /// Another PWM of a motor.
    Pwm { servo: usize, pwm: u16 },
    /// Adds to the external torque.
    Push { joint: usize, delta_nm: f64 },
    /// A hand leads a link to these angles, from where it is.
    Lead {
        grip: Grip,
        to_rad: [f64; JOINTS],
        duration_ns: u64,
    },
    /// The hand lets go.
    LetGo,
}

impl Plant {
    /// The arm at time zero, with motors off and this seed of the encoders' noise. A joint that it
    /// does not have rests at 0.
    pub fn new(mut config: PlantConfig, seed: u64) -> Self {
        if config.arm.joints() < JOINTS {
            (config.initial.q.y, config.initial.dq.y) = (0.0, 0.0);
        }
        Self {
            body: initial_body(&config),
            config,
            now_ns: 0,
            hand: config.held.then(|| Hand::holding(config.initial.q)),
            motor_nm: Vector2::from_fn(|servo, _| config.torque(servo, OFF)),
            pwm: [OFF; JOINTS],
            motor_faults: [MotorFault::NONE; JOINTS],
            push_nm: Vector2::zeros(),
            pushes: VecDeque::new(),
            due: VecDeque::new(),
            // One stream per encoder: reading one does not change the other.
            noise: core::array::from_fn(|servo| Pcg32::new(seed, servo as u64)),
        }
    }

    /// Model of the servos if they are of the X series.
    pub(super) fn firmware(&self) -> Firmware {
        self.config.firmware()
    }

    pub(super) fn x_servo(&self) -> &'static Model {
        self.config.x_servo
    }

    /// Number of joints.
    pub fn joints(&self) -> usize {
        self.config.arm.joints()
    }

    /// The same with another step of the integration in ns, at least 1, instead of
    /// [`body::STEP_NS`].
    #[must_use]
    pub fn with_step(self, step_ns: u64) -> Self {
        Self {
            body: self.body.with_step(step_ns.max(1)),
            ..self
        }
    }

    /// Applies a PWM to a servo from `at_ns` on.
    ///
    /// # Panics
    ///
    /// If there is no such servo; they are 0 and 1.
    pub fn drive(&mut self, servo: usize, at_ns: u64, pwm: u16) {
        assert!(servo < JOINTS, "no servo {servo} on this arm");
        self.advance(at_ns);
        self.change(
            self.now_ns + self.config.input_delay_ns[servo],
            ChangeKind::Pwm { servo, pwm },
        );
    }

    /// Adds a push. A push whose start has passed begins now.
    ///
    /// # Panics
    ///
    /// If there is no such joint; they are 0 and 1.
    pub fn push(&mut self, push: Push) {
        let Push {
            joint,
            torque_nm: delta_nm,
            start_ns,
            duration_ns,
        } = push;
        assert!(joint < JOINTS, "no joint {joint} on this arm");
        let start_ns = start_ns.max(self.now_ns);
        let index = self
            .pushes
            .partition_point(|other| other.start_ns <= start_ns);
        self.pushes.insert(index, Push { start_ns, ..push });
        self.change(start_ns, ChangeKind::Push { joint, delta_nm });
        let delta_nm = -delta_nm;
        self.change(start_ns + duration_ns, ChangeKind::Push { joint, delta_nm });
    }

    /// Adds a hand that grasps a link at `start_ns` and leads it through the points of `path`,
    /// times in ns since then; it lets go after `release_ns`, wherever it is.
    pub fn lead(&mut self, lead: &Lead) {
        let start_ns = lead.start_ns.max(self.now_ns);
        let mut before_ns = 0;
        for via in &lead.path {
            if before_ns < lead.release_ns {
                let kind = ChangeKind::Lead {
                    grip: lead.grip,
                    to_rad: via.angle_rad,
                    duration_ns: via.after_ns - before_ns,
                };
                self.change(start_ns + before_ns, kind);
            }
            before_ns = via.after_ns;
        }
        self.change(start_ns + lead.release_ns, ChangeKind::LetGo);
    }

    /// Sets the fault of a servo's motor from now on.
    ///
    /// # Panics
    ///
    /// If there is no such servo; they are 0 and 1.
    pub fn fail_motor(&mut self, servo: usize, fault: MotorFault) {
        self.motor_faults[servo] = fault;
        self.motor_nm[servo] = self.torque_of(servo);
        self.body
            .set_torques(self.now_ns, self.motor_nm, self.push_nm);
    }

    /// Torque of a servo at its PWM.
    fn torque_of(&self, servo: usize) -> f64 {
        let MotorFault {
            gain,
            offset_counts,
        } = self.motor_faults[servo];
        let pwm = self.pwm[servo];
        // A motor that is off gives no torque, whatever its zero is.
        let counts = if pwm == OFF { 0.0 } else { offset_counts };
        let pwm = (f64::from(pwm) + counts).clamp(0.0, 2.0 * f64::from(OFF));
        gain * self.config.torque(servo, pwm.round() as u16)
    }

    /// The fastest impact on a stop since the last call.
    pub fn take_impact(&mut self) -> Option<Impact> {
        self.body.take_impact()
    }

    /// Energy of the arm at rest in this posture, in J.
    pub fn energy_at_rest(&self, q: [f64; JOINTS]) -> f64 {
        let posture = State::at_rest(Vector2::from(q));
        self.config.true_arm().energy(&posture)
    }

    /// Moves the arm by hand to these angles, and holds it there until a motor drives it or it
    /// is [released](Self::release). Angles beyond a stop end at it.
    pub fn move_by_hand(&mut self, to_rad: [f64; JOINTS], duration_ns: u64) {
        let from = self.state();
        self.hand = Some(Hand::moving(self.now_ns, from, to_rad.into(), duration_ns));
        self.follow_hand(self.now_ns);
    }

    /// Moves the arm by hand to its initial angles, and holds it there.
    pub fn lift(&mut self) {
        self.move_by_hand(self.config.initial.q.into(), LIFT_NS);
    }

    /// Lets go of the arm.
    pub fn release(&mut self) {
        self.hand = None;
    }

    /// Advances the body as the hand moves it; false if there is no hand.
    fn follow_hand(&mut self, to_ns: u64) -> bool {
        let Some(hand) = self.hand else {
            return false;
        };
        let state = hand.state(to_ns);
        if hand.is_still(to_ns) && self.body.rests_at(&state) {
            self.body.hold(to_ns);
        } else {
            self.body.guide(to_ns, state);
        }
        true
    }

    /// Reads the encoder of an AX-12A at `at_ns`, in counts.
    ///
    /// # Panics
    ///
    /// If there is no such servo; they are 0 and 1.
    pub fn read(&mut self, servo: usize, at_ns: u64) -> u16 {
        self.read_with(servo, Encoder::Ax12a, at_ns)
    }

    /// Reads a servo's encoder of this kind at `at_ns`, in counts. The calibration of the joint is
    /// that of the same encoder.
    ///
    /// # Panics
    ///
    /// If there is no such servo; they are 0 and 1.
    pub fn read_with(&mut self, servo: usize, encoder: Encoder, at_ns: u64) -> u16 {
        assert!(servo < JOINTS, "no servo {servo} on this arm");
        self.advance(at_ns);
        let noise: f64 = StandardNormal.sample(&mut self.noise[servo]);
        let position = self.config.joints[servo].position(self.state().q[servo]);
        encoder::count(encoder, position + self.config.noise_lsb_rms * noise)
    }

    /// Speed of a servo's shaft in counts of its encoder a second, at the time of the last reading.
    pub(super) fn counts_per_s(&self, servo: usize) -> f64 {
        let joint = &self.config.joints[servo];
        joint.position(self.state().dq[servo]) - joint.position(0.0)
    }

    /// Advances time.
    pub fn advance(&mut self, to_ns: u64) {
        self.now_ns = self.now_ns.max(to_ns);
        while let Some(&change) = self.due.front() {
            if change.at_ns > self.now_ns {
                break;
            }
            self.due.pop_front();
            self.apply(change);
        }
        if !self.follow_hand(self.now_ns) {
            self.body.advance(self.now_ns);
        }
    }

    /// True angles and speeds.
    pub fn state(&self) -> State<f64> {
        self.body.state(self.now_ns)
    }

    /// The next push that has begun, once.
    pub fn take_begun_push(&mut self) -> Option<Push> {
        let has_begun = self.pushes.front()?.start_ns <= self.now_ns;
        has_begun.then(|| self.pushes.pop_front()).flatten()
    }

    /// State and torques at the present time.
    pub fn true_state(&self) -> TrueState {
        let (state, friction_nm) = self.body.state_and_friction(self.now_ns);
        // A hand holds it, not friction.
        let friction_nm = if self.hand.is_some() {
            Vector2::zeros()
        } else {
            friction_nm
        };
        let real = |values: Vector2<f64>| <[f64; JOINTS]>::from(values).map(|value| value as f32);
        TrueState {
            at_ns: self.now_ns,
            angle_rad: real(state.q),
            speed_rad_s: real(state.dq),
            torque_nm: real(self.motor_nm),
            friction_nm: real(friction_nm),
            push_nm: real(self.push_nm + self.body.hand_nm(self.now_ns)),
        }
    }

    /// True motor torque in N m.
    pub fn torque(&self) -> Vector2<f64> {
        self.motor_nm
    }

    /// Applies a change if it is due, and queues it otherwise.
    fn change(&mut self, at_ns: u64, kind: ChangeKind) {
        let change = Change { at_ns, kind };
        if at_ns <= self.now_ns {
            self.apply(change);
        } else {
            let index = self.due.partition_point(|other| other.at_ns <= at_ns);
            self.due.insert(index, change);
        }
    }

    fn apply(&mut self, Change { at_ns, kind }: Change) {
        self.follow_hand(at_ns);
        match kind {
            ChangeKind::Pwm { servo, pwm } => {
                self.hand = self.hand.filter(|_| pwm.abs_diff(OFF) <= STOP_COUNTS);
                self.pwm[servo] = pwm;
                self.motor_nm[servo] = self.torque_of(servo);
            }
            ChangeKind::Push { joint, delta_nm } => self.push_nm[joint] += delta_nm,
            ChangeKind::Lead {
                grip,
                to_rad,
                duration_ns,
            } => {
                let grasp = self.body.grasp();
                let from_rad = grasp.map_or_else(|| self.body.state(at_ns).q, Grasp::end_rad);
                let grasp = Grasp::new(grip, from_rad, to_rad.into(), at_ns, duration_ns);
                self.body.set_grasp(at_ns, Some(grasp));
            }
            ChangeKind::LetGo => self.body.set_grasp(at_ns, None),
        }
        self.body.set_torques(at_ns, self.motor_nm, self.push_nm);
    }
}
