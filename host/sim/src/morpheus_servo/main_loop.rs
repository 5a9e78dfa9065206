//! One turn of the main loop after it has polled for a message: the timer
//! tick, when one is due, and the transmitter. Idle turns are combined into one
//! stage, and split again when a message interrupts them.

use super::converter::Sample;
use super::mcu::Mcu;
use super::state::{CycleState, Stage};
use super::{Action, cycle_costs};

impl Mcu {
    /// Cycles of one idle turn.
    pub(super) fn turn(&self) -> u64 {
        let cycle = match self.cycle_state {
            CycleState::NotStarted => 0,
            CycleState::Member if self.cycle_pending => cycle_costs::TURN_CYCLE_PENDING,
            CycleState::AwaitingSlot | CycleState::Member => cycle_costs::TURN_STARTED,
        };
        let stuck = if self.receiver.stuck() {
            cycle_costs::MESSAGE_STUCK
        } else {
            0
        };
        cycle_costs::TURN + cycle + stuck
    }

    /// Ends the idle turns early if a message waits: the loop polls it at its next turn.
    pub(super) fn shorten_idle_turns(&mut self, now: u64) {
        if self.idle_turns == 0 || !self.receiver.waiting() {
            return;
        }
        let turn = self.turn();
        let last_poll = self.stage_end - (turn - cycle_costs::TURN + cycle_costs::POLL_TO_TICK);
        let Some(remaining) = last_poll.checked_sub(now) else {
            return; // The tick comes first.
        };
        let turns = remaining / turn;
        self.stage = Stage::PollMessages;
        self.stage_end = last_poll - turns * turn;
        self.turns_left = turns as u8;
        self.idle_turns = 0;
    }

    /// Second half of a turn, after the poll for a message.
    pub(super) fn finish_turn(&mut self, now: u64) -> Option<Action> {
        let turn = self.turn();
        let extra = turn - cycle_costs::TURN;
        if self.turns_left == 0 {
            return self.enter(Stage::Tick, now + extra + cycle_costs::POLL_TO_TICK);
        }
        if self.driving || !self.transmit.is_empty() {
            self.turns_left -= 1;
            return self.enter(Stage::Transmit, now + extra + cycle_costs::POLL_TO_TRANSMIT);
        }
        if self.receiver.waiting() {
            // It arrived while the loop was busy.
            self.turns_left -= 1;
            return self.enter(Stage::PollMessages, now + turn);
        }
        self.idle_turns = self.turns_left;
        self.turns_left = 0;
        let idle = u64::from(self.idle_turns) * turn;
        self.enter(Stage::Tick, now + idle + extra + cycle_costs::POLL_TO_TICK)
    }

    /// Timer tick: applies the PWM of a sync write.
    pub(super) fn tick(&mut self, now: u64) -> Option<Action> {
        self.idle_turns = 0;
        self.turns_left = cycle_costs::TURNS_PER_TICK;
        let mut cost = cycle_costs::TICK_TO_CONVERTER;
        if self.requests.pwm_sync != self.requests.pwm_before {
            self.requests.pwm = self.requests.pwm_sync;
            self.requests.pwm_before = self.requests.pwm_sync;
            self.control.set_pwm(self.requests.pwm_sync);
            cost += cycle_costs::TICK_SYNC_PWM;
        }
        self.enter(Stage::ReadConverter, now + cost)
    }

    /// Reads the converter's result, and runs the control step on a position.
    pub(super) fn sample(&mut self, now: u64) -> Option<Action> {
        let mut cost = 0;
        let mut changed = false;
        match self.converter.take_result() {
            None => {}
            Some(Sample::Temperature(reading)) => {
                self.control.temperature = reading;
                cost += cycle_costs::CONTROL_TEMPERATURE;
            }
            Some(Sample::Position(reading)) => {
                let before = self.control.applied;
                cost += self.control.step(reading, self.gains);
                changed = self.control.applied != before;
            }
        }
        cost += self.converter.tick(now + cost);
        if self.delay_ticks > 0 {
            self.delay_ticks -= 1;
            cost += cycle_costs::TICK_DELAY;
        }
        if changed {
            // The new PWM is on the motor when the step is done.
            self.enter(Stage::ApplyPwm, now + cost)
        } else {
            self.after_tick(now + cost)
        }
    }

    pub(super) fn after_tick(&mut self, now: u64) -> Option<Action> {
        let transmit = now + cycle_costs::CONVERTER_TO_TRANSMIT;
        if self.driving || !self.transmit.is_empty() {
            self.enter(Stage::Transmit, transmit)
        } else {
            self.enter(
                Stage::PollMessages,
                transmit + cycle_costs::TRANSMIT_TO_POLL,
            )
        }
    }

    /// Passes a byte to the transmitter, or releases the bus after the last one.
    pub(super) fn transmit_byte(&mut self, now: u64) -> Option<Action> {
        if self.uart.can_send(now)
            && let Some(byte) = self.transmit.pop_front()
        {
            let driver = if self.driving {
                0
            } else {
                cycle_costs::DRIVER_ON
            };
            self.driving = true;
            let start = self.uart.send(now + driver + cycle_costs::TRANSMIT_TO_SEND);
            let start_ns = super::nanoseconds(start);
            self.enter(
                Stage::PollMessages,
                now + driver + cycle_costs::TRANSMIT_BYTE_TO_POLL,
            );
            return Some(Action::Send { byte, start_ns });
        }
        if !self.transmit.is_empty() {
            return self.enter(
                Stage::PollMessages,
                now + cycle_costs::TRANSMIT_FULL_TO_POLL,
            );
        }
        let now = if self.uart.can_send(now) {
            now
        } else {
            now + cycle_costs::TRANSMIT_LAST
        };
        if self.uart.ran_empty(now + cycle_costs::TRANSMIT_TO_EMPTY) {
            return self.enter(Stage::ReleaseBus, now + cycle_costs::DRIVER_OFF);
        }
        self.enter(Stage::PollMessages, now + cycle_costs::TRANSMIT_TO_POLL)
    }
}
