//! Time-outs of the host: how long it may be silent, and how old its commands may be.
//!
//! | what                          | after                   | follows                        |
//! |-------------------------------|-------------------------|--------------------------------|
//! | the host is silent            | `hold_ms`               | track: brake; torque: off; experiment: its end |
//! | the host is silent            | `silence_ms`            | a fault, whatever drives       |
//! | constant torque, not repeated | `torque_age_ms`         | torque ends                    |
//! | stream, not continued         | `stream_age_ms`         | the reference brakes, the arm is held |
//! | setpoint, not repeated        | `setpoint_age_ms`, if any | torque ends                  |

use super::tick::Verdict;
use super::{ControlLoop, Fallback, LoopConfig, Permission, TickInput, Violation};
use crate::link::message::{Drive, Fault};

impl ControlLoop {
    /// How long the host has been silent: hold, then let go.
    pub(super) fn watch_host(
        &mut self,
        config: &LoopConfig,
        input: &TickInput,
        verdict: &mut Verdict,
    ) -> Option<Fallback> {
        if !verdict.is_armed() {
            return None;
        }
        let silent_us = input.host_silent_us;
        let limits = config.limits();
        let allowed_us = |ms: u16| u64::from(ms) * 1_000;
        if silent_us > allowed_us(limits.silence_ms) {
            verdict.trip(Violation {
                value: silent_us as f32 * 1e-6,
                limit: f32::from(limits.silence_ms) * 1e-3,
                ..Violation::plain(Fault::HostSilent)
            });
            return None;
        }
        if silent_us <= allowed_us(limits.hold_ms) || !verdict.is_driven() {
            return None;
        }
        match self.drive() {
            // They hold already.
            Drive::Regulate | Drive::Hold => None,
            Drive::Track => Some(self.brake(input.acts_us)),
            Drive::Torque => {
                verdict.permission = Permission::Armed;
                Some(Fallback::Release)
            }
            // It ends when this tick's samples have been looked at.
            Drive::Experiment => {
                self.experiment.note_quiet();
                None
            }
        }
    }

    /// A command that drives and is too old ends, however alive the host is.
    pub(super) fn watch_age(
        &mut self,
        config: &LoopConfig,
        input: &TickInput,
        verdict: &mut Verdict,
    ) -> Option<Fallback> {
        if !verdict.is_driven() || !self.is_aged(config, input.acts_us) {
            return None;
        }
        if self.drive() == Drive::Track {
            return Some(self.brake(input.acts_us));
        }
        verdict.permission = Permission::Armed;
        Some(Fallback::Release)
    }

    /// Whether what drives was commanded too long ago, at this time.
    pub fn is_aged(&self, config: &LoopConfig, at_us: u64) -> bool {
        let limits = config.limits();
        let most_ms = match self.drive() {
            Drive::Torque => limits.torque_age_ms,
            Drive::Track if self.source.is_streamed() => limits.stream_age_ms,
            Drive::Regulate | Drive::Hold => limits.setpoint_age_ms,
            Drive::Track | Drive::Experiment => 0,
        };
        most_ms > 0 && self.commanded.age_us(at_us) > u64::from(most_ms) * 1_000
    }

    pub(super) fn brake(&mut self, at_us: u64) -> Fallback {
        self.commanded = self.commanded.with_drive(Drive::Hold);
        self.source.brake(at_us);
        Fallback::Brake
    }
}
