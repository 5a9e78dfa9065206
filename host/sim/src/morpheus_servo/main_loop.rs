//! One turn of the main loop after it has looked for a message: the timer
//! tick, when one is due, and feeding the transmitter. Idle turns are taken
//! together, and given back one by one when a message interrupts them.

use super::converter::Sample;
use super::mcu::Mcu;
use super::state::{Bus, Stage};
use super::{Action, cycle_costs};

impl Mcu {
    pub(super) fn turn(&self) -> u64 {
        let chain = match self.bus {
            Bus::Unknown => 0,
            Bus::Member if self.cycle_pending => cycle_costs::TURN_IN_CYCLE,
            Bus::Slot | Bus::Member => cycle_costs::TURN_ON_CHAIN,
        };
        let stuck = if self.inbox.stuck() {
            cycle_costs::STUCK
        } else {
            0
        };
        cycle_costs::TURN + chain + stuck
    }

    /// A message waits: the loop sees it at its next turn.
    pub(super) fn cut_idle_turns(&mut self, now: u64) {
        if self.idle_turns == 0 || !self.inbox.waiting() {
            return;
        }
        let turn = self.turn();
        let last_look = self.stage_end - (turn - cycle_costs::TURN + cycle_costs::LOOK_TO_TICK);
        let Some(ahead) = last_look.checked_sub(now) else {
            return; // The tick comes first.
        };
        let turns = ahead / turn;
        self.stage = Stage::Look;
        self.stage_end = last_look - turns * turn;
        self.turns_left = turns as u8;
        self.idle_turns = 0;
    }

    /// The second half of a turn, from where a message was looked for.
    pub(super) fn finish_turn(&mut self, now: u64) -> Option<Action> {
        let turn = self.turn();
        let extra = turn - cycle_costs::TURN;
        if self.turns_left == 0 {
            return self.go(Stage::Tick, now + extra + cycle_costs::LOOK_TO_TICK);
        }
        if self.driving || !self.transmit.is_empty() {
            self.turns_left -= 1;
            return self.go(Stage::Feed, now + extra + cycle_costs::LOOK_TO_FEED);
        }
        if self.inbox.waiting() {
            // It arrived while the loop was busy.
            self.turns_left -= 1;
            return self.go(Stage::Look, now + turn);
        }
        self.idle_turns = self.turns_left;
        self.turns_left = 0;
        let idle = u64::from(self.idle_turns) * turn;
        self.go(Stage::Tick, now + idle + extra + cycle_costs::LOOK_TO_TICK)
    }

    pub(super) fn tick(&mut self, now: u64) -> Option<Action> {
        self.idle_turns = 0;
        self.turns_left = cycle_costs::TURNS_PER_TICK;
        let mut cost = cycle_costs::TICK_TO_SAMPLE;
        if self.requests.pwm_sync != self.requests.pwm_before {
            self.requests.pwm = self.requests.pwm_sync;
            self.requests.pwm_before = self.requests.pwm_sync;
            self.control.set_pwm(self.requests.pwm_sync);
            cost += cycle_costs::TICK_SYNC_PWM;
        }
        self.go(Stage::Sample, now + cost)
    }

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
            self.go(Stage::Control, now + cost)
        } else {
            self.after_tick(now + cost)
        }
    }

    pub(super) fn after_tick(&mut self, now: u64) -> Option<Action> {
        let feed = now + cycle_costs::SAMPLE_TO_FEED;
        if self.driving || !self.transmit.is_empty() {
            self.go(Stage::Feed, feed)
        } else {
            self.go(Stage::Look, feed + cycle_costs::FEED_TO_LOOK)
        }
    }

    pub(super) fn feed(&mut self, now: u64) -> Option<Action> {
        if self.uart.can_send(now)
            && let Some(byte) = self.transmit.pop_front()
        {
            let driver = if self.driving {
                0
            } else {
                cycle_costs::DRIVER_ON
            };
            self.driving = true;
            let start = self.uart.send(now + driver + cycle_costs::FEED_TO_SEND);
            let start_ns = super::nanoseconds(start);
            self.go(Stage::Look, now + driver + cycle_costs::FEED_BYTE_TO_LOOK);
            return Some(Action::Send { byte, start_ns });
        }
        if !self.transmit.is_empty() {
            return self.go(Stage::Look, now + cycle_costs::FEED_FULL_TO_LOOK);
        }
        let now = if self.uart.can_send(now) {
            now
        } else {
            now + cycle_costs::FEED_LAST
        };
        if self.uart.ran_empty(now + cycle_costs::FEED_TO_EMPTY) {
            return self.go(Stage::Release, now + cycle_costs::DRIVER_OFF);
        }
        self.go(Stage::Look, now + cycle_costs::FEED_TO_LOOK)
    }
}
