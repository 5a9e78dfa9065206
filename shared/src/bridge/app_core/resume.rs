//! Resumption from records: the host's replay sets what a log has of a tick, and steps it.
//!
//! A board calls none of these.

use super::Core;
use crate::arm::State as ArmState;
use crate::control::Reference;
use crate::control_loop::{ActuatorCommand, LoopConfig};
use crate::link::message::{Mode, Trip};
use nalgebra::Vector2;

impl Core {
    /// These settings are in force, whatever was before.
    pub fn replace_config(&mut self, config: LoopConfig) {
        self.control_loop.install(&self.config, &config, false, 0);
        self.control_loop.reset_monitors();
        self.config = config;
    }

    /// The tick of a record begins: `tick` and its times are the record's.
    pub fn resume_tick(&mut self, tick: u32, start_us: u64, planned_us: u64) {
        self.tick = tick.wrapping_sub(1);
        self.now_us = start_us;
        self.next_start_us = planned_us;
    }

    /// The mode is this, whatever it was.
    pub fn resume_mode(&mut self, mode: Mode, trip: Option<Trip>) {
        self.supervisor.resume(mode, trip);
        if let Some(drive) = mode.drive() {
            self.control_loop.set_drive(drive);
        }
    }

    /// Of the tick under way: ticks missed so far, and motors that were off.
    pub fn resume_before(&mut self, missed: u32, is_off: bool) {
        self.timing.missed = missed;
        if is_off {
            self.in_force = ActuatorCommand::OFF;
        }
    }

    /// What the tick under way estimated and asked for is this.
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

    /// Nothing is known of what went on, but that nothing drives the motors.
    pub fn forget(&mut self) {
        self.supervisor.resume(Mode::Idle, None);
        self.next = ActuatorCommand::OFF;
    }

    /// The host has been silent for so long, in µs.
    pub fn set_silence(&mut self, silent_us: u64) {
        self.now_us = self.now_us.max(silent_us);
        self.heard_us = self.now_us.saturating_sub(silent_us);
    }
}
