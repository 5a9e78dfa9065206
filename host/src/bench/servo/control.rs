//! From converter readings to the PWM: the servo's control step.
//!
//! Either the PWM that was asked for is applied as it is, or a goal position
//! is approached at a set speed and then held by a PID controller. All
//! arithmetic is 16 bits wide and wraps, as on the microcontroller.

use super::costs;

/// Positions kept for the speed, which is the difference over 14 samples.
const HISTORY: usize = 15;
/// The converter's largest reading.
const FULL_SCALE: i16 = 1023;
/// The PWM that switches the motor off.
pub(super) const OFF: u16 = 1000;
/// Largest PWM.
const FULL: u16 = 2000;
/// Integral terms stop growing here.
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
    /// A PWM is applied as it is.
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

/// Adds to an integral unless it is beyond its limit and would grow.
fn integrate(sum: i16, gain: u8, error: i16) -> i16 {
    let term = i16::from(gain).wrapping_mul(sum);
    if (term > WINDUP && error > 0) || (term < -WINDUP && error < 0) {
        sum
    } else {
        sum.wrapping_add(error)
    }
}

fn pid(gains: [u8; 3], error: i16, sum: i16, change: i16, divisor: i16) -> i16 {
    let [p, i, d] = gains.map(i16::from);
    p.wrapping_mul(error)
        .wrapping_add(i.wrapping_mul(sum) / divisor)
        .wrapping_add(d.wrapping_mul(change))
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

    /// Asks for a PWM; one above 2000 is ignored.
    pub(super) fn set_pwm(&mut self, pwm: u16) {
        if pwm <= FULL {
            self.mode = Mode::Pwm(pwm);
        }
    }

    /// Asks for a position; one outside the limits, or a speed above 10, is
    /// ignored.
    pub(super) fn set_goal(&mut self, goal: u16, speed: u16, gains: Gains) {
        let goal = goal as i16;
        let inside = goal >= i16::from(gains.lower_margin)
            && goal <= FULL_SCALE - i16::from(gains.upper_margin);
        if inside && speed <= 10 {
            self.goal = goal;
            self.goal_speed = speed as i16;
            self.moving = true;
            self.mode = Mode::Position;
        }
    }

    /// Takes a new position reading and decides the PWM. Returns what the
    /// step cost, in cycles.
    pub(super) fn step(&mut self, reading: u16, gains: Gains) -> u64 {
        self.position = reading as i16;
        self.remember();
        self.speed = self
            .position
            .wrapping_sub(self.history[self.newest])
            .wrapping_abs();
        let (pwm, cost) = match self.mode {
            Mode::Pwm(pwm) => (pwm, costs::CONTROL_PWM),
            Mode::Position => {
                let (pwm, cost) = self.follow(gains);
                (pwm.clamp(0, FULL as i16) as u16, cost)
            }
        };
        if pwm == self.applied {
            return cost;
        }
        self.applied = pwm;
        cost + costs::SET_PWM
    }

    /// The first reading fills all places but the last, which stays 0 until
    /// it is reached: the speed shows one false value 7 ms after power-up.
    fn remember(&mut self) {
        if self.started {
            self.history[self.newest] = self.position;
            self.newest = (self.newest + 1) % HISTORY;
        } else {
            self.history[..HISTORY - 1].fill(self.position);
            self.started = true;
        }
    }

    fn follow(&mut self, gains: Gains) -> (i16, u64) {
        if self.position > FULL_SCALE - i16::from(gains.upper_margin) {
            return (300, costs::CONTROL_LIMIT);
        }
        if self.position < i16::from(gains.lower_margin) {
            return (1700, costs::CONTROL_LIMIT);
        }
        let up = self.moving && self.goal > self.position + self.goal_speed;
        let down = self.moving && self.goal < self.position - self.goal_speed;
        let off = OFF as i16;
        if up || down {
            let effort = self.speed_effort(gains);
            let pwm = if up {
                off.wrapping_add(effort)
            } else {
                off.wrapping_sub(effort)
            };
            return (pwm, costs::CONTROL_SPEED);
        }
        (
            off.wrapping_add(self.hold_effort(gains)),
            costs::CONTROL_HOLD,
        )
    }

    fn speed_effort(&mut self, gains: Gains) -> i16 {
        let before = self.speed_error;
        self.speed_error = self.goal_speed.wrapping_sub(self.speed);
        self.speed_sum = integrate(self.speed_sum, gains.speed[1], before);
        let change = self.speed_error.wrapping_sub(before);
        pid(gains.speed, self.speed_error, self.speed_sum, change, 10)
    }

    fn hold_effort(&mut self, gains: Gains) -> i16 {
        self.speed_error = 0;
        self.speed_sum = 0;
        self.moving = false;
        let before = self.position_error;
        self.position_error = self.goal.wrapping_sub(self.position);
        self.position_sum = integrate(self.position_sum, gains.position[1], before);
        let change = self.position_error.wrapping_sub(before);
        pid(
            gains.position,
            self.position_error,
            self.position_sum,
            change,
            100,
        )
    }
}
