//! Calibration of each joint's zero and sign: by hand, with the motors off, and saved on
//! the board.
//!
//! Joint by joint, a person moves the arm to its zero and then to a positive angle, and
//! confirms each position; zero and sign follow from the counts. The angle of a count and
//! torque against command stay as the board has them, unless they are of another encoder, or another
//! control mode is wanted: then they are the nominal ones of the servos' model, which the person
//! names. On request, and after a question, each motor pushes once, gently, to show that it turns the way its encoder counts.
//!
//! | module     | what                                          |
//! |------------|-----------------------------------------------|
//! | `guide`    | the dialogue with the person                  |
//! | `measure`  | from counts to zero and sign, or why not      |
//! | `motor`    | one push, and what it moved                   |
//! | `nominal`  | the nominal calibration of a model            |
//! | `unusable` | reasons against a measurement or an answer    |

mod guide;
mod measure;
mod motor;
mod nominal;
#[cfg(test)]
mod tests;
mod unusable;

pub use guide::Guide;
pub use motor::MotorError;
pub use unusable::Unusable;

use armbridge_client::ctrl_c;
use armbridge_client::session::{Request, SERVO_TIMEOUT_US};
use armbridge_control::actuator::Joint;
use armbridge_control::encoder::Encoder;
use armbridge_link::message::{Command, Mode, Settings, Setup};
use armbridge_servo::{ControlMode, JOINTS};

use super::{Task, TaskError, View};
use measure::{Pose, Sampler, direction};
use motor::Motor;
use nominal::Gain;

/// Interval at which counts are shown while a person moves the arm.
const SHOW_US: u64 = 100_000;
/// Number of failed measurements after which the calibration ends.
const ATTEMPTS: u32 = 3;

/// Extent of a calibration.
#[derive(Clone, Copy, Debug)]
pub struct CalibrationOptions {
    /// Which joints, counting from 0.
    pub joints: [bool; JOINTS],
    /// Another control mode of X servos.
    pub mode: Option<ControlMode>,
    /// Let each motor push once.
    pub checks_motors: bool,
    /// Do not ask before the board is changed; a motor's push is still asked for.
    pub is_sure: bool,
}

#[derive(Debug)]
enum Step {
    /// For the board and its servos.
    Waiting,
    /// For the person, to name the servos' model.
    Model,
    /// For the person, to hold this joint at its zero.
    Zero(usize),
    /// Taking counts there.
    AtZero(usize, Sampler),
    /// For the person, to turn it to the positive side.
    Turn(usize, Pose),
    Turned(usize, Pose, Sampler),
    /// For a yes.
    Confirm,
    /// For the board to take the set-up.
    Configuring(u64),
    Motor(Motor),
    Saving(u64),
    Over,
}

/// Guides a person through the calibration.
pub struct Calibrate<G> {
    guide: G,
    options: CalibrationOptions,
    step: Step,
    attempts: u32,
    show_us: u64,
    before: Option<Settings>,
    encoder: Encoder,
    mode: ControlMode,
    joints: [Joint<f32>; JOINTS],
}

impl<G: Guide> Calibrate<G> {
    /// Not begun yet.
    pub fn new(guide: G, options: CalibrationOptions) -> Self {
        Self {
            guide,
            options,
            step: Step::Waiting,
            attempts: 0,
            show_us: 0,
            before: None,
            encoder: Encoder::Ax12a,
            mode: ControlMode::Pwm,
            joints: [Joint::paper(); JOINTS],
        }
    }

    /// Calibrations before and after, once they are saved.
    pub fn result(&self) -> Option<[[Joint<f32>; JOINTS]; 2]> {
        let before = self.before.filter(|_| matches!(self.step, Step::Over))?;
        Some([before.setup.joints, self.joints])
    }

    fn wait(&mut self, view: &View<'_>) -> Result<(), TaskError> {
        let status = view.session.status();
        if let Some(tripped) = status.trip {
            return Err(TaskError::Latched(tripped));
        }
        if let (Some(Mode::Idle), Some(settings), Some(servos)) =
            (status.mode(), status.settings, status.servos)
        {
            self.before = Some(settings);
            self.joints = settings.setup.joints;
            self.encoder = Encoder::of(servos.firmware);
            self.mode = match (self.encoder, self.options.mode) {
                (Encoder::Ax12a, Some(ControlMode::Current)) => {
                    let why = Unusable::NoCurrentMode("an AX-12A".into());
                    return Err(TaskError::Unusable(why));
                }
                (Encoder::Ax12a, _) => ControlMode::Pwm,
                (Encoder::XSeries, mode) => mode.unwrap_or(settings.setup.control_mode),
            };
            let joints = status.joints();
            for joint in self.options.joints.iter_mut().skip(joints) {
                *joint = false;
            }
            self.guide
                .say("The motors are off; the arm can be moved by hand.");
            let mut there = self.joints.iter().take(joints);
            let is_known = there.all(|joint| joint.encoder() == Some(self.encoder));
            if is_known && self.mode == settings.setup.control_mode {
                self.next_joint(0);
            } else {
                // Of what is there, nothing holds.
                self.options.joints = std::array::from_fn(|joint| joint < joints);
                self.ask_for_model();
            }
        } else if view.now_us > 2 * SERVO_TIMEOUT_US {
            return Err(TaskError::NoServos(status.obstacle));
        }
        Ok(())
    }

    /// Goes on with the first joint to calibrate from this one on.
    fn next_joint(&mut self, from: usize) {
        self.attempts = 0;
        if let Some(joint) = (from..JOINTS).find(|joint| self.options.joints[*joint]) {
            self.ask_for_zero(joint);
            return;
        }
        self.step = Step::Confirm;
        if !self.options.is_sure {
            self.report_change();
            self.guide.say("Save this on the board? [y/N]");
        }
    }

    fn ask_for_model(&mut self) {
        match self.encoder {
            Encoder::Ax12a => self.begin_with(Joint::paper()),
            Encoder::XSeries => {
                self.guide.say(&nominal::question());
                self.step = Step::Model;
            }
        }
    }

    /// Begins with a calibration that is of the servos' encoder.
    fn begin_with(&mut self, joint: Joint<f32>) {
        self.joints = [joint; JOINTS];
        self.next_joint(0);
    }

    fn named(&mut self, name: &str) -> Result<(), TaskError> {
        let Some(model) = nominal::find(name) else {
            self.again(Unusable::Model(name.trim().into()))?;
            self.ask_for_model();
            return Ok(());
        };
        let Some(gain) = Gain::of(model, self.mode) else {
            self.again(Unusable::NoCurrentMode(model.name.into()))?;
            self.ask_for_model();
            return Ok(());
        };
        self.guide.say(&nominal::description(model, gain));
        self.begin_with(nominal::calibration(gain));
        Ok(())
    }

    fn ask_for_zero(&mut self, joint: usize) {
        self.guide.say(&guide::zero_request(joint + 1));
        self.step = Step::Zero(joint);
    }

    fn ask_for_turn(&mut self, joint: usize, zero: Pose) {
        self.guide.say(&guide::turn_request(joint + 1));
        self.step = Step::Turn(joint, zero);
    }

    fn report_change(&mut self) {
        let before = self
            .before
            .map_or(self.joints, |before| before.setup.joints);
        for (number, (before, after)) in before.iter().zip(&self.joints).enumerate() {
            if !self.options.joints[number] {
                continue;
            }
            self.guide.say(&guide::change(number + 1, before, after));
        }
    }

    /// A measurement failed: repeats it, a limited number of times.
    fn again(&mut self, why: Unusable) -> Result<(), TaskError> {
        self.attempts += 1;
        if self.attempts >= ATTEMPTS {
            return Err(TaskError::Unusable(why));
        }
        self.guide.say(&format!(
            "Not usable: {why}. That was attempt {} of {ATTEMPTS}.",
            self.attempts
        ));
        Ok(())
    }

    fn measured(&mut self, joint: usize, sampler: &Sampler) -> Result<(), TaskError> {
        match sampler.pose(joint) {
            Ok(zero) => {
                self.joints[joint].zero_count = zero[joint] as f32;
                self.ask_for_turn(joint, zero);
            }
            Err(why) => {
                self.again(why)?;
                self.ask_for_zero(joint);
            }
        }
        Ok(())
    }

    fn turned(&mut self, joint: usize, zero: Pose, sampler: &Sampler) -> Result<(), TaskError> {
        let found = sampler
            .pose(joint)
            .and_then(|turned| direction(joint, &zero, &turned, self.encoder));
        match found {
            Ok(direction) => {
                self.joints[joint].direction = direction;
                self.next_joint(joint + 1);
            }
            Err(why) => {
                self.again(why)?;
                self.ask_for_turn(joint, zero);
            }
        }
        Ok(())
    }

    /// Shows the counts now and then; whether the person has answered.
    fn is_answered(&mut self, view: &View<'_>) -> Result<bool, TaskError> {
        if view.now_us >= self.show_us
            && let Some(record) = view.session.status().record
        {
            self.show_us = view.now_us + SHOW_US;
            let samples = record.input.samples.iter();
            let counts = samples.take(view.session.status().joints()).map(|sample| {
                let counts = sample.counts();
                counts.map_or_else(|| "none".to_owned(), |counts| counts.to_string())
            });
            let counts: Vec<_> = counts.collect();
            self.guide.show(&format!("counts {}", counts.join(", ")));
        }
        Ok(self.guide.answer()?.is_some())
    }

    fn configure(&mut self, view: &mut View<'_>) {
        if let Some(before) = self.before {
            let setup = Setup {
                joints: self.joints,
                control_mode: self.mode,
                ..before.setup
            };
            let configure = Command::Configure(setup);
            view.session
                .request(view.now_us, Request::Command(configure));
        }
        self.step = Step::Configuring(view.now_us);
    }

    fn after_motor(&mut self, view: &mut View<'_>, from: usize) {
        let next = (from..JOINTS).find(|joint| self.options.joints[*joint]);
        if let Some(joint) = next.filter(|_| self.options.checks_motors) {
            let servos = view.session.status().servos;
            let is_ready = servos.is_some_and(|servos| servos.is_ready);
            let motor = Motor::ask(joint, self.joints[joint], is_ready, &mut self.guide);
            self.step = Step::Motor(motor);
        } else {
            view.session
                .request(view.now_us, Request::Command(Command::Save));
            self.step = Step::Saving(view.now_us);
        }
    }
}

impl<G: Guide> Task for Calibrate<G> {
    fn look(&mut self, mut view: View<'_>) -> Result<(), TaskError> {
        if ctrl_c::is_raised() && !matches!(self.step, Step::Over) {
            return Err(TaskError::Interrupted);
        }
        let record = view.session.status().record;
        match std::mem::replace(&mut self.step, Step::Waiting) {
            Step::Waiting => self.wait(&view)?,
            Step::Model => match self.guide.answer()? {
                None => self.step = Step::Model,
                Some(name) => self.named(&name)?,
            },
            Step::Zero(joint) => {
                self.step = if self.is_answered(&view)? {
                    Step::AtZero(joint, Sampler::new(self.encoder))
                } else {
                    Step::Zero(joint)
                };
            }
            Step::AtZero(joint, mut sampler) => {
                if record.is_some_and(|record| sampler.take(&record)) {
                    self.measured(joint, &sampler)?;
                } else {
                    self.step = Step::AtZero(joint, sampler);
                }
            }
            Step::Turn(joint, zero) => {
                self.step = if self.is_answered(&view)? {
                    Step::Turned(joint, zero, Sampler::new(self.encoder))
                } else {
                    Step::Turn(joint, zero)
                };
            }
            Step::Turned(joint, zero, mut sampler) => {
                if record.is_some_and(|record| sampler.take(&record)) {
                    self.turned(joint, zero, &sampler)?;
                } else {
                    self.step = Step::Turned(joint, zero, sampler);
                }
            }
            Step::Confirm if self.options.is_sure => self.configure(&mut view),
            Step::Confirm => match self.guide.answer()?.as_deref().map(str::trim) {
                None => self.step = Step::Confirm,
                Some("y" | "Y" | "yes") => self.configure(&mut view),
                Some(_) => return Err(TaskError::NotConfirmed),
            },
            Step::Configuring(since_us) => {
                if view.is_acknowledged(since_us, "the board refused the set-up")? {
                    self.after_motor(&mut view, 0);
                } else {
                    self.step = Step::Configuring(since_us);
                }
            }
            Step::Motor(mut motor) => {
                if motor.look(&mut view, &mut self.guide)? {
                    self.after_motor(&mut view, motor.joint() + 1);
                } else {
                    self.step = Step::Motor(motor);
                }
            }
            Step::Saving(since_us) => {
                if view.is_acknowledged(since_us, "the board refused to save")? {
                    self.step = Step::Over;
                    view.session.request(view.now_us, Request::Leave);
                } else {
                    self.step = Step::Saving(since_us);
                }
            }
            Step::Over => self.step = Step::Over,
        }
        Ok(())
    }

    fn disconnected(&mut self, _now_us: u64) {
        if !matches!(self.step, Step::Over) {
            self.guide
                .say("The link broke: the calibration starts again.");
            self.step = Step::Waiting;
        }
    }
}
