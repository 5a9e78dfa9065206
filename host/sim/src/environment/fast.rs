//! The board in [`Mode::Fast`](super::Mode::Fast): the tick of the board around the virtual arm,
//! with the wire and the servos as constant delays.
//!
//! ```text
//!      sampled_us   applied_us
//! |---------+---|-------------------+-----------|
//!       sampled |   packets         | PWM of the tick before is applied
//!               start of the tick; decided with these samples
//! ```
//!
//! A servo answers with the position of its last conversion, which is before the tick, and applies a
//! PWM in its next control step. Both drift against the tick; here both have their mean. Nothing is lost on this wire,
//! and neither link nor supervisor take part: the loop is permitted to drive until it trips.

use armbridge_board::bridge::command::{ValidatedCommand, validate};
use armbridge_board::checkpoints::Checkpoints;
use armbridge_board::tick::{ControlLoop, Instant, LoopConfig, step};
use armbridge_control::arm::State;
use armbridge_link::message::{Command, Fault, Sample};
use armbridge_link::record::{Fallback, Permission, TickInput, TickOutput};
use armbridge_servo::{Firmware, Pwm};

use super::Observation;
use crate::plant::{Plant, PlantConfig};

/// Mean delays of servos, measured on the exact board; see the tests.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Delays {
    /// From the sample of a position to the start of the tick that asks for it, in µs.
    pub sampled_us: u64,
    /// From the start of a tick to the torque of its PWM, in µs.
    pub applied_us: u64,
}

impl Delays {
    /// Those of servos with this firmware, at 1 kHz and 1 Mbaud.
    pub const fn of(firmware: Firmware) -> Self {
        let (sampled_us, applied_us) = match firmware {
            // Simulated cycle by cycle.
            Firmware::Morpheus | Firmware::Stock => (100, 600),
            Firmware::XSeries => (140, 700),
        };
        Self {
            sampled_us,
            applied_us,
        }
    }

    /// From the sample to the torque that a tick decides with it, in µs.
    pub const fn total_us(self) -> u64 {
        self.sampled_us + self.applied_us
    }
}

/// Ticks of an arm at rest before an episode, in which the encoders' noise becomes known.
const SETTLE_TICKS: u32 = 64;
/// Step of the integration, in ns: that of the tick, which the change of torque cuts.
const STEP_NS: u64 = 1_000_000;

/// See the [module](self).
#[derive(Debug)]
pub struct FastBoard {
    config: LoopConfig,
    control_loop: ControlLoop,
    plant: Plant,
    delays: Delays,
    input: TickInput,
    output: TickOutput,
    fault: Option<Fault>,
}

impl FastBoard {
    /// A board that has armed, and the arm at rest. Also returns its last tick.
    pub fn new(config: &LoopConfig, plant: PlantConfig, seed: u64) -> (Self, Observation) {
        let mut board = Self {
            config: *config,
            control_loop: ControlLoop::new(config),
            plant: Plant::new(plant, seed).with_step(STEP_NS),
            delays: Delays::of(plant.firmware()),
            input: TickInput {
                is_first: true,
                lead_us: config.period_us().get(),
                ..TickInput::AT_REST
            },
            output: TickOutput::NONE,
            fault: None,
        };
        for _ in 0..SETTLE_TICKS {
            board.tick();
        }
        board.input.permission = Permission::Armed;
        board.control_loop.energise();
        let observation = board.observation();
        (board, observation)
    }

    /// Gives a command, lets go of the arm, and runs so many ticks; returns the last.
    pub fn advance(&mut self, command: &Command, ticks: u32) -> Observation {
        let next_us = self.input.acts_us();
        let now = Instant {
            us: next_us,
            acts_us: next_us,
            is_driven: self.input.permission == Permission::Drive,
        };
        if self.fault.is_none()
            && let Ok(ValidatedCommand::Drive(request)) =
                validate(*command, 0, self.config.joints(), None)
            && self
                .control_loop
                .request(&self.config, &request, now)
                .is_ok()
        {
            self.input.permission = Permission::Drive;
        }
        self.plant.release();
        for _ in 0..ticks {
            self.tick();
        }
        self.observation()
    }

    /// True state of the arm.
    pub fn true_state(&self) -> State<f64> {
        self.plant.state()
    }

    fn tick(&mut self) {
        let Self {
            plant,
            input,
            config,
            delays,
            ..
        } = self;
        input.start_us = input.acts_us();
        let driven = input.permission.drives_motors();
        let pwm = if driven {
            self.output.pwm
        } else {
            [Pwm::OFF.counts(); 2]
        };
        let sampled_ns = (input.start_us - delays.sampled_us) * 1_000;
        let applied_ns = (input.start_us + delays.applied_us) * 1_000;
        input.samples = [0, 1].map(|servo| Sample::Counts(plant.read(servo, sampled_ns)));
        for (servo, (pwm, before)) in pwm.into_iter().zip(input.pwm_in_force).enumerate() {
            if pwm != before {
                plant.drive(servo, applied_ns, pwm);
            }
        }
        input.pwm_in_force = pwm;
        let mut checkpoints = Checkpoints::default();
        self.output = step(config, &mut self.control_loop, input, &mut checkpoints);
        input.is_first = false;
        let Some(events) = self.output.events else {
            return;
        };
        if let Some(Fallback::Release) = events.fallback {
            input.permission = Permission::Armed;
        }
        if let Some(violation) = events.fault {
            input.permission = Permission::Off;
            self.fault = Some(violation.fault);
        }
    }

    fn observation(&self) -> Observation {
        let output = &self.output;
        Observation {
            angle_rad: output.angle_rad,
            speed_rad_s: output.speed_rad_s,
            torque_nm: output.torque_nm,
            pwm: output.pwm,
            fault: self.fault,
            is_driven: self.input.permission == Permission::Drive,
        }
    }
}
