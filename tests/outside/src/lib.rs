//! A board's control loop around a simulated arm, for a microcontroller, a web page or a PC.

#![no_std]
#![forbid(unsafe_code)]
#![warn(missing_docs)]

use armbridge_board::checkpoints::Checkpoints;
use armbridge_board::tick::{ControlLoop, DriveRequest, Instant, LoopConfig, step};
use armbridge_control::actuator::Joint;
use armbridge_control::arm::{Parameters, State};
use armbridge_link::message::{Missing, Refusal, Sample, Settings};
use armbridge_link::record::{Permission, TickInput, TickOutput};
use armbridge_servo::Pwm;

/// Steps of the simulation in a period.
const STEPS: u16 = 10;

/// A simulated arm, its servos, and the control loop that drives them.
#[derive(Clone, Debug)]
pub struct Loop {
    config: LoopConfig,
    control: ControlLoop,
    input: TickInput,
    arm: Parameters<f32>,
    servos: [Joint<f32>; 2],
    plant: State<f32>,
}

impl Loop {
    /// An arm that begins at rest at these angles in rad, with the loop of these settings.
    ///
    /// # Errors
    /// The refusal of a board.
    pub fn new(settings: &Settings, angle_rad: [f32; 2]) -> Result<Self, Refusal> {
        let config = LoopConfig::build(settings)?;
        Ok(Self {
            config,
            control: ControlLoop::new(&config),
            input: TickInput::AT_REST,
            arm: settings.setup.arm,
            servos: settings.setup.joints,
            plant: State::at_rest(angle_rad.into()),
        })
    }

    /// Asks for these angles in rad.
    ///
    /// # Errors
    /// The refusal of a board.
    pub fn regulate(&mut self, angle_rad: [f32; 2]) -> Result<(), Refusal> {
        let now = Instant {
            us: self.input.start_us,
            acts_us: self.input.acts_us(),
            is_driven: self.input.permission == Permission::Drive,
        };
        let request = DriveRequest::Regulate(angle_rad);
        self.control.request(&self.config, &request, now)?;
        self.input.permission = Permission::Drive;
        Ok(())
    }

    /// Advances the arm by a period, with servos that answer or not.
    pub fn tick(&mut self, are_answering: bool) -> TickOutput {
        self.input.lead_us = self.config.period_us().get();
        self.input.samples = [0, 1].map(|joint| {
            let position = self.servos[joint].position(self.plant.q[joint]);
            if are_answering {
                Sample::Counts((position + 0.5) as u16)
            } else {
                Sample::Missing(Missing::Silence)
            }
        });
        let pwm = self.input.pwm_in_force.map(Pwm::saturating);
        let torque_nm = [0, 1]
            .map(|joint| self.servos[joint].torque(pwm[joint]))
            .into();
        let checkpoints = &mut Checkpoints::default();
        let output = step(&self.config, &mut self.control, &self.input, checkpoints);
        if output.fault().is_some() {
            self.input.permission = Permission::Off;
        }
        let step_s = self.input.lead_us as f32 * 1e-6 / f32::from(STEPS);
        for _ in 0..STEPS {
            let acceleration = self.arm.acceleration(&self.plant, torque_nm);
            self.plant.dq += acceleration * step_s;
            self.plant.q += self.plant.dq * step_s;
        }
        self.input.start_us = self.input.acts_us();
        self.input.pwm_in_force = output.pwm;
        output
    }

    /// Angles of the arm in rad.
    pub fn angle_rad(&self) -> [f32; 2] {
        self.plant.q.into()
    }
}
