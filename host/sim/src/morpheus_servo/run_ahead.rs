//! Running ahead of the wire: what a servo does alone, until a byte can reach it.
//!
//! Most of a servo's events are its own: turns of its main loop, handlers of
//! bytes already received. Those up to a given time are executed in one go. It stops before
//! an event that the wire must execute in its place: an [`Action`](super::Action), another bit
//! rate, a stage with interrupts off.

use super::cycle_costs;
use super::mcu::{Due, Mcu};
use super::state::{CycleState, Stage};

impl Mcu {
    /// Executes internal events from cycle `now` on, up to but not including `until`.
    pub(super) fn run_ahead(&mut self, now: u64, until: u64) {
        let mut now = now;
        loop {
            let (at, due) = self.next_due(now);
            if at >= until || self.concerns_others(due, at) {
                return;
            }
            self.execute_due(due, at);
            now = self.run_stages(at, until.min(self.interrupted_at()));
        }
    }

    /// Runs the main loop from `now` on, up to but not including `until`. Returns the start of
    /// its last stage.
    fn run_stages(&mut self, now: u64, until: u64) -> u64 {
        let mut now = now;
        loop {
            let at = self.stage_end.max(now);
            let until = until.min(self.converter.result_at());
            if at >= until || self.concerns_others(Due::Stage, at) {
                return now;
            }
            now = at;
            self.run(now);
        }
    }

    /// Whether this event at `at` is one that the wire must execute.
    fn concerns_others(&self, due: Due, at: u64) -> bool {
        match due {
            Due::HandlerEffect | Due::Interrupt => false,
            Due::Conversion => true,
            Due::Stage => match self.stage {
                Stage::Transmit => !self.transmit.is_empty() && self.uart.can_send(at),
                Stage::ApplyPwm | Stage::ReleaseBus => true,
                _ => !self.interrupts_on(),
            },
        }
    }

    /// Cycle before which it begins no byte, unless it receives another one; `next` is
    /// that of its next event.
    pub(super) fn earliest_send(&self, next: u64) -> u64 {
        let begins = if !self.transmit.is_empty() || self.stage == Stage::QueueReply {
            next
        } else if self.may_reply() {
            next + cycle_costs::SHORTEST_REPLY
        } else {
            return u64::MAX;
        };
        begins.max(self.uart.sent_until())
    }

    /// Whether it may begin a reply before it receives another byte.
    fn may_reply(&self) -> bool {
        let loop_is_idle = matches!(
            self.stage,
            Stage::Tick | Stage::ReadConverter | Stage::ApplyPwm | Stage::PollMessages
        );
        let reply_is_due = match self.cycle_state {
            CycleState::NotStarted => false,
            CycleState::AwaitingSlot => true,
            CycleState::Member => self.cycle_pending,
        };
        let message_waits = self.receiver.waiting() || self.receiver.is_open();
        let is_receiving = self.uart.has_byte() || self.handles_byte();
        !loop_is_idle || reply_is_due || message_waits || is_receiving
    }
}
