//! Resumption from records: the host's replay sets the recorded state of a tick, and runs
//! the tick. A board calls none of these functions.

use super::Core;
use crate::control_loop::{ActuatorCommand, LoopConfig};
use crate::supervisor::Event;
use armbridge_control::arm::State as ArmState;
use armbridge_control::trajectory::Reference;
use armbridge_link::message::{Mode, Trip};
use nalgebra::Vector2;

impl Core {
    /// Replaces the configuration, in any state.
    pub fn replace_config(&mut self, config: LoopConfig) {
        self.control_loop.install(&self.config, &config, false, 0);
        self.control_loop.reset_monitors();
        self.config = config;
    }

    /// Sets number and times of the recorded tick.
    pub fn resume_tick(&mut self, tick: u32, start_us: u64, planned_us: u64) {
        self.tick = tick.wrapping_sub(1);
        self.now_us = start_us;
        self.next_start_us = planned_us;
    }

    /// Sets the recorded mode.
    pub fn resume_mode(&mut self, mode: Mode, trip: Option<Trip>) {
        self.supervisor.resume(mode, trip);
        self.are_motors_checked |= mode.is_armed() && mode != Mode::MotorCheck;
        if let Some(drive) = mode.drive() {
            self.control_loop.set_drive(drive);
        }
    }

    /// Ends a check of the motors that has just begun: they had been checked before the log.
    pub fn skip_motor_check(&mut self) {
        self.are_motors_checked = true;
        // Never refused.
        let _ = self.apply(Event::MotorsChecked);
    }

    /// Sets the recorded state at the beginning of the tick: ticks missed so far, and motors
    /// that were off.
    pub fn resume_before(&mut self, missed: u32, is_off: bool) {
        self.timing.missed = missed;
        if is_off {
            self.in_force = ActuatorCommand::OFF;
        }
    }

    /// Sets the recorded estimate and reference of the tick.
    pub fn resume_after(&mut self, state: ArmState<f32>, reference: [Vector2<f32>; 2]) {
        let [q, dq] = reference;
        let reference = Reference {
            q,
            dq,
            ddq: Vector2::zeros(),
        };
        self.control_loop.resume(state, reference);
        if !self.state().is_driven() {
            self.next = ActuatorCommand::OFF;
        }
    }

    /// Clears the state after a gap in the records: idle, motors not driven.
    pub fn forget(&mut self) {
        self.supervisor.resume(Mode::Idle, None);
        self.next = ActuatorCommand::OFF;
    }

    /// Sets the silence of the host, in µs.
    pub fn set_silence(&mut self, silent_us: u64) {
        self.now_us = self.now_us.max(silent_us);
        self.host_frame_us = self.now_us.saturating_sub(silent_us);
    }
}
