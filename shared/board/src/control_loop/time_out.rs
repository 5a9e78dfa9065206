//! Time-outs of the host: silence, and age of its commands.
//!
//! | condition                     | time-out                | reaction                       |
//! |-------------------------------|-------------------------|--------------------------------|
//! | the host is silent            | `hold_ms`               | track: brake; torque: off; experiment: its end |
//! | the host is silent            | `silence_ms`            | a fault, whatever drives       |
//! | constant torque, not repeated | `torque_age_ms`         | torque ends                    |
//! | stream, not continued         | `stream_age_ms`         | the reference brakes, the arm is held |
//! | setpoint, not repeated        | `setpoint_age_ms`, if any | torque ends                  |
//! | motion, no other commanded    | `setpoint_age_ms`, if any | the reference brakes, the arm is held |
//!
//! An arm that is held after any of these is held at a setpoint as old as the braking. By
//! default a motion goes on to its end, ten minutes at most, and its end is held.

use super::tick::TickStatus;
use super::{ControlLoop, LoopConfig};
use armbridge_link::message::{Drive, Fault};
use armbridge_link::record::{Fallback, Permission, TickInput, Violation};

impl ControlLoop {
    /// Checks the silence of the host: first hold, then torque off.
    pub(super) fn check_host_silence(
        &mut self,
        config: &LoopConfig,
        input: &TickInput,
        status: &mut TickStatus,
    ) -> Option<Fallback> {
        if !status.is_armed() {
            return None;
        }
        let silent_ms = input.host_silent_ms;
        let limits = config.limits();
        if silent_ms > limits.silence_ms {
            status.trip(Violation {
                value: f32::from(silent_ms) * 1e-3,
                limit: f32::from(limits.silence_ms) * 1e-3,
                ..Violation::plain(Fault::HostSilent)
            });
            return None;
        }
        if silent_ms <= limits.hold_ms || !status.is_driven() {
            return None;
        }
        match self.drive() {
            // The arm is held already.
            Drive::Regulate | Drive::Hold => None,
            Drive::Track => Some(self.brake(input.acts_us())),
            Drive::Torque => {
                status.permission = Permission::Armed;
                Some(Fallback::Release)
            }
            // The experiment ends after this tick's samples have been processed.
            Drive::Experiment => {
                self.experiment.note_host_silence();
                None
            }
        }
    }

    /// Ends a command that is too old, even while heartbeats arrive.
    pub(super) fn check_command_age(
        &mut self,
        config: &LoopConfig,
        input: &TickInput,
        status: &mut TickStatus,
    ) -> Option<Fallback> {
        if !status.is_driven() || !self.is_aged(config, input.acts_us()) {
            return None;
        }
        if self.drive() == Drive::Track {
            return Some(self.brake(input.acts_us()));
        }
        status.permission = Permission::Armed;
        Some(Fallback::Release)
    }

    /// Whether the command that drives is too old at this time.
    fn is_aged(&self, config: &LoopConfig, at_us: u64) -> bool {
        let limits = config.limits();
        let limit_ms = match self.drive() {
            Drive::Torque => limits.torque_age_ms,
            Drive::Track if self.source.is_streamed() => limits.stream_age_ms,
            Drive::Regulate | Drive::Hold | Drive::Track => limits.setpoint_age_ms,
            // It has an end and an envelope of its own.
            Drive::Experiment => 0,
        };
        limit_ms > 0 && self.commanded.age_us(at_us) > u64::from(limit_ms) * 1_000
    }

    /// Brakes the reference, then holds the arm. The setpoint is of this time, for torque that
    /// ends at once would let a moving arm fall.
    pub(super) fn brake(&mut self, at_us: u64) -> Fallback {
        self.commanded = self.commanded.continued(Drive::Hold, at_us);
        self.source.brake(at_us);
        Fallback::Brake
    }
}
