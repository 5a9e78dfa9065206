//! Control step of the servo: from converter readings to the PWM.
//!
//! Either the commanded PWM is applied, or a goal position is approached at a set
//! speed and then held by a PID controller. All
//! arithmetic is 16 bits wide and wraps, as on the microcontroller.

use std::cmp::Ordering;

use super::cycle_costs;

/// Positions kept for the speed, which is the difference over 14 samples.
const HISTORY: usize = 15;
/// The converter's largest reading.
const FULL_SCALE: i16 = 1023;
/// The PWM that switches the motor off.
pub(super) const OFF: u16 = 1000;
/// Largest PWM.
const FULL: u16 = 2000;
/// Limit of the integral terms.
const WINDUP: i16 = 10_000;

/// Settings that the control step takes from the EEPROM variables.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Gains {
    pub(super) upper_margin: u8,
    pub(super) lower_margin: u8,
    pub(super) position: [u8; 3],
    pub(super) speed: [u8; 3],
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Mode {
    /// The commanded PWM is applied.
    Pwm(u16),
    /// Position and speed control decide the PWM.
    Position,
}

#[derive(Debug, Clone)]
pub(super) struct Control {
    pub(super) mode: Mode,
    /// The PWM on the motor.
    pub(super) applied: u16,
    pub(super) position: i16,
    pub(super) speed: i16,
    pub(super) temperature: u16,
    pub(super) goal: i16,
    pub(super) goal_speed: i16,
    history: [i16; HISTORY],
    newest: usize,
    started: bool,
    moving: bool,
    speed_error: i16,
    speed_sum: i16,
    position_error: i16,
    position_sum: i16,
}

/// Adds to an integral unless it is beyond its limit and would grow. Returns
/// its cost relative to the usual one.
fn integrate(sum: &mut i16, gain: u8, error: i16) -> i64 {
    let term = i16::from(gain).wrapping_mul(*sum);
    let (beyond, grows, stays) = match term {
        _ if term > WINDUP => (-2, error > 0, -21),
        _ if term < -WINDUP => (1, error < 0, -16),
        _ => (0, false, 0),
    };
    if grows {
        return stays;
    }
    *sum = sum.wrapping_add(error);
    beyond
}

/// Output of a PID controller, and the cost of its division.
fn pid(gains: [u8; 3], error: i16, sum: i16, change: i16, divisor: i16) -> (i16, i64) {
    let [p, i, d] = gains.map(i16::from);
    let term = i.wrapping_mul(sum);
    let quotient = term / divisor;
    let sign = if term < 0 {
        cycle_costs::DIVIDE_NEGATIVE
    } else {
        0
    };
    let cost = sign + i64::from(quotient.unsigned_abs().count_ones());
    let effort = p
        .wrapping_mul(error)
        .wrapping_add(quotient)
        .wrapping_add(d.wrapping_mul(change));
    (effort, cost)
}

impl Control {
    pub(super) fn new() -> Self {
        Self {
            mode: Mode::Pwm(OFF),
            applied: OFF,
            position: 0,
            speed: 0,
            temperature: 0,
            goal: 0,
            goal_speed: 0,
            history: [0; HISTORY],
            newest: 0,
            started: false,
            moving: false,
            speed_error: 0,
            speed_sum: 0,
            position_error: 0,
            position_sum: 0,
        }
    }

    /// Commands a PWM; one above 2000 is ignored. Returns whether it was accepted.
    pub(super) fn set_pwm(&mut self, pwm: u16) -> bool {
        if pwm <= FULL {
            self.mode = Mode::Pwm(pwm);
        }
        pwm <= FULL
    }

    /// Commands a position; one outside the limits, or a speed above 10, is
    /// ignored. Returns whether it was accepted.
    pub(super) fn set_goal(&mut self, goal: u16, speed: u16, gains: Gains) -> bool {
        let goal = goal as i16;
        let inside = goal >= i16::from(gains.lower_margin)
            && goal <= FULL_SCALE - i16::from(gains.upper_margin);
        let is_accepted = inside && speed <= 10;
        if is_accepted {
            self.goal = goal;
            self.goal_speed = speed as i16;
            self.moving = true;
            self.mode = Mode::Position;
        }
        is_accepted
    }

    /// Processes a new position reading and computes the PWM. Returns the cost of the
    /// step, in cycles.
    pub(super) fn step(&mut self, reading: u16, gains: Gains) -> u64 {
        self.position = reading as i16;
        let mut cost = self.push_history();
        self.speed = self.position.wrapping_sub(self.history[self.newest]);
        if self.speed < 0 {
            self.speed = self.speed.wrapping_neg();
            cost += cycle_costs::SPEED_NEGATIVE;
        }
        let pwm = match self.mode {
            Mode::Pwm(pwm) => {
                cost += cycle_costs::CONTROL_PWM;
                pwm
            }
            Mode::Position => {
                let (pwm, step_cost) = self.position_pwm(gains);
                cost += step_cost + if pwm < 0 { cycle_costs::LIMITED } else { 0 };
                pwm.clamp(0, FULL as i16) as u16
            }
        };
        if pwm == self.applied {
            return cost;
        }
        self.applied = pwm;
        cost + match pwm.cmp(&OFF) {
            Ordering::Greater => cycle_costs::SET_PWM_UP,
            Ordering::Less => cycle_costs::SET_PWM_DOWN,
            Ordering::Equal => cycle_costs::SET_PWM_OFF,
        }
    }

    /// Adds the position to the history. The first one fills all elements but the last,
    /// which stays 0 until it is reached: the speed has one false value 7 ms after
    /// power-up. Returns the additional cost.
    fn push_history(&mut self) -> u64 {
        if !self.started {
            self.history[..HISTORY - 1].fill(self.position);
            self.started = true;
            return cycle_costs::HISTORY_FILLED;
        }
        self.history[self.newest] = self.position;
        self.newest = (self.newest + 1) % HISTORY;
        if self.newest == 0 {
            cycle_costs::HISTORY_WRAPS
        } else {
            0
        }
    }

    /// PWM in position mode, and its cost.
    fn position_pwm(&mut self, gains: Gains) -> (i16, u64) {
        if self.position > FULL_SCALE - i16::from(gains.upper_margin) {
            return (300, cycle_costs::CONTROL_ABOVE);
        }
        if self.position < i16::from(gains.lower_margin) {
            return (1700, cycle_costs::CONTROL_BELOW);
        }
        let above = self.goal > self.position + self.goal_speed;
        let below = self.goal < self.position - self.goal_speed;
        let off = OFF as i16;
        if self.moving && (above || below) {
            let (effort, cost) = self.speed_effort(gains);
            return if above {
                let cost = cycle_costs::CONTROL_UP.saturating_add_signed(cost);
                (off.wrapping_add(effort), cost)
            } else {
                let cost = cycle_costs::CONTROL_DOWN.saturating_add_signed(cost);
                (off.wrapping_sub(effort), cost)
            };
        }
        let (effort, cost) = self.hold_effort(gains);
        let mut cost = cycle_costs::CONTROL_HOLD.saturating_add_signed(cost);
        if above {
            cost -= cycle_costs::HOLD_BELOW_GOAL;
        } else if below {
            cost += cycle_costs::HOLD_ABOVE_GOAL;
        }
        (off.wrapping_add(effort), cost)
    }

    fn speed_effort(&mut self, gains: Gains) -> (i16, i64) {
        let before = self.speed_error;
        self.speed_error = self.goal_speed.wrapping_sub(self.speed);
        let integrated = integrate(&mut self.speed_sum, gains.speed[1], before);
        let change = self.speed_error.wrapping_sub(before);
        let (effort, cost) = pid(gains.speed, self.speed_error, self.speed_sum, change, 10);
        (effort, cost + integrated)
    }

    fn hold_effort(&mut self, gains: Gains) -> (i16, i64) {
        self.speed_error = 0;
        self.speed_sum = 0;
        self.moving = false;
        let before = self.position_error;
        self.position_error = self.goal.wrapping_sub(self.position);
        let integrated = integrate(&mut self.position_sum, gains.position[1], before);
        let change = self.position_error.wrapping_sub(before);
        let error = self.position_error;
        let (effort, cost) = pid(gains.position, error, self.position_sum, change, 100);
        (effort, cost + integrated)
    }
}
