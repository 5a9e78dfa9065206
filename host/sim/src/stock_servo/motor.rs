//! Control step of the servo: from the position to the motor's duty.
//!
//! Wheel mode (both angle limits 0): the moving speed register is the duty,
//! open loop, bit 10 for clockwise. Joint mode:
//!
//! ```text
//! duty
//! 1023 |              ____     error = setpoint - position
//!      |            /
//! punch|          _/           none within the margin, then at once the punch,
//!      |         |             and full duty at margin + slope
//!    0 |_________|________ |error|
//!              margin
//! ```
//!
//! The setpoint moves to the goal at the moving speed, or is the goal at once if the
//! speed is 0. Margin and slope are those of the direction in which the servo drives;
//! the e-Manual's figure is ambiguous. The torque limit limits the duty in both modes.
//!
//! Duties are -1023..=1023, positive counter-clockwise, towards higher counts.

use super::memory::{Memory, at};

/// Full duty.
pub(super) const FULL: i16 = 1023;
/// Bit 10: clockwise.
const CLOCKWISE: u16 = 1 << 10;
/// 0.111 rpm in counts of 300/1023 degree a second.
const COUNTS_PER_S: f64 = 0.111 / 60.0 * 360.0 / (300.0 / 1023.0);
/// Samples over which the speed is measured: 32 ms, so that one count is 13
/// units of 0.111 rpm. Assumed; the real servo's speed is as coarse.
const WINDOW: usize = 32;

/// Result of a control step.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Output {
    /// Duty of the motor.
    pub(super) duty: i16,
    /// The torque limit is reached.
    pub(super) is_limited: bool,
}

/// State of the control.
#[derive(Clone, Debug)]
pub(super) struct Motor {
    /// Positions of the last samples; `newest` is the index of the last one.
    history: Option<[u16; WINDOW]>,
    newest: usize,
    /// Setpoint, in counts.
    setpoint: f64,
    /// Samples since the goal was written, until it is reached.
    samples_since_goal: Option<usize>,
}

/// Number of a register with sign and magnitude.
fn signed(raw: u16) -> i16 {
    let magnitude = (raw & (CLOCKWISE - 1)) as i16;
    if raw & CLOCKWISE == 0 {
        magnitude
    } else {
        -magnitude
    }
}

/// Register value of a number, with sign and magnitude.
fn raw(signed: i16) -> u16 {
    let sign = if signed < 0 { CLOCKWISE } else { 0 };
    signed.unsigned_abs().min(CLOCKWISE - 1) | sign
}

/// The representative value of a compliance slope: 2, 4, 8 .. 128.
fn slope(raw: u8) -> u8 {
    1 << raw.max(2).ilog2()
}

impl Motor {
    pub(super) fn new() -> Self {
        Self {
            history: None,
            newest: 0,
            setpoint: 0.0,
            samples_since_goal: None,
        }
    }

    /// Starts the motion to a new goal.
    pub(super) fn new_goal(&mut self) {
        self.samples_since_goal = Some(0);
    }

    /// Processes a sample, `period_s` after the last: updates the registers, and computes
    /// the duty.
    pub(super) fn step(&mut self, memory: &mut Memory, position: u16, period_s: f64) -> Output {
        let speed = self.speed(memory, position);
        let output = if !memory.torque_on() {
            self.setpoint = f64::from(position);
            self.samples_since_goal = None;
            Output::default()
        } else if memory.is_wheel() {
            self.setpoint = f64::from(position);
            self.samples_since_goal = None;
            limited(memory, signed(memory.word(at::MOVING_SPEED)))
        } else {
            self.update_setpoint(memory, period_s);
            limited(
                memory,
                compliance_duty(memory, self.setpoint - f64::from(position)),
            )
        };
        self.update_moving(memory, position, speed);
        memory.set_word(at::PRESENT_POSITION, position);
        memory.set_word(at::PRESENT_SPEED, raw(speed));
        memory.set_word(at::PRESENT_LOAD, raw(output.duty));
        memory.set_byte(at::MOVING, u8::from(self.samples_since_goal.is_some()));
        output
    }

    /// Speed in 0.111 rpm. After power-up the goal is the present position.
    fn speed(&mut self, memory: &mut Memory, position: u16) -> i16 {
        let Some(history) = &mut self.history else {
            self.history = Some([position; WINDOW]);
            memory.set_word(at::GOAL_POSITION, position);
            self.setpoint = f64::from(position);
            return 0;
        };
        self.newest = (self.newest + 1) % WINDOW;
        let oldest = std::mem::replace(&mut history[self.newest], position);
        let moved = f64::from(position) - f64::from(oldest);
        (moved / (WINDOW as f64 * super::PERIOD_S) / COUNTS_PER_S).round() as i16
    }

    fn update_setpoint(&mut self, memory: &Memory, period_s: f64) {
        let goal = f64::from(memory.word(at::GOAL_POSITION));
        let speed = memory.word(at::MOVING_SPEED) & (CLOCKWISE - 1);
        self.setpoint = if speed == 0 {
            goal
        } else {
            let step = f64::from(speed) * COUNTS_PER_S * period_s;
            self.setpoint + (goal - self.setpoint).clamp(-step, step)
        };
    }

    /// Ends the motion when the goal is reached: within the margin, or at rest with the
    /// setpoint at the goal.
    fn update_moving(&mut self, memory: &Memory, position: u16, speed: i16) {
        let Some(samples) = self.samples_since_goal else {
            return;
        };
        let goal = memory.word(at::GOAL_POSITION);
        let margin = margin_and_slope(memory, goal > position).0;
        let is_within_margin = f64::from(goal.abs_diff(position)) <= margin;
        let is_due = (self.setpoint - f64::from(goal)).abs() < 0.5;
        let is_at_rest = samples >= WINDOW && speed == 0 && is_due;
        self.samples_since_goal = (!is_within_margin && !is_at_rest).then_some(samples + 1);
    }
}

fn margin_and_slope(memory: &Memory, counter_clockwise: bool) -> (f64, f64) {
    let [margin, steepness] = if counter_clockwise {
        [at::CCW_MARGIN, at::CCW_SLOPE]
    } else {
        [at::CW_MARGIN, at::CW_SLOPE]
    };
    let steps = slope(memory.byte(steepness));
    (memory.byte(margin).into(), steps.into())
}

/// Duty of the compliance curve, for an error in counts.
fn compliance_duty(memory: &Memory, error: f64) -> i16 {
    let (margin, slope) = margin_and_slope(memory, error > 0.0);
    let beyond = error.abs() - margin;
    if beyond <= 0.0 {
        return 0;
    }
    let (full, punch) = (f64::from(FULL), f64::from(memory.word(at::PUNCH)));
    let duty = punch + beyond / slope * (full - punch);
    duty.min(full).copysign(error).round() as i16
}

fn limited(memory: &Memory, duty: i16) -> Output {
    let limit = memory.word(at::TORQUE_LIMIT).min(FULL as u16) as i16;
    Output {
        duty: duty.clamp(-limit, limit),
        is_limited: duty.abs() >= limit,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::stock_servo::PERIOD_S;

    fn memory(writes: &[(u8, u16)]) -> Memory {
        let mut memory = Memory::new();
        memory.set_byte(at::TORQUE_ENABLE, 1);
        for &(address, value) in writes {
            memory.set_word(address, value);
        }
        memory
    }

    #[test]
    fn wheel_mode_is_open_loop_with_bit_10_for_clockwise() {
        let mut memory = memory(&[(at::CCW_ANGLE_LIMIT, 0)]);
        let mut motor = Motor::new();
        for (speed, limit, duty, is_limited) in [
            (512, 1023, 512, false),
            (1024 + 512, 1023, -512, false),
            (1024, 1023, 0, false),
            (1023, 1023, 1023, true),
            (1024 + 900, 300, -300, true),
            (900, 0, 0, false),
        ] {
            memory.set_word(at::MOVING_SPEED, speed);
            memory.set_word(at::TORQUE_LIMIT, limit);
            let output = motor.step(&mut memory, 500, PERIOD_S);
            assert_eq!(output, Output { duty, is_limited }, "{speed} {limit}");
            assert_eq!(signed(memory.word(at::PRESENT_LOAD)), duty);
        }
        memory.set_byte(at::TORQUE_ENABLE, 0);
        memory.set_word(at::TORQUE_LIMIT, 1023);
        assert_eq!(
            motor.step(&mut memory, 500, PERIOD_S),
            Output::default(),
            "no torque"
        );
    }

    #[test]
    fn duty_grows_from_the_margin_over_the_slope() {
        let memory = memory(&[]);
        // Margin 1, slope 32, punch 32.
        for (error, duty) in [
            (1.0, 0),
            (-1.0, 0),
            (17.0, 528),
            (-17.0, -528),
            (33.0, 1023),
            (500.0, 1023),
        ] {
            assert_eq!(compliance_duty(&memory, error), duty, "{error}");
        }
        let steps = [0, 3, 4, 7, 8, 25, 63, 64, 127, 128, 254].map(slope);
        assert_eq!(steps, [2, 2, 4, 4, 8, 16, 32, 64, 64, 128, 128]);
    }

    #[test]
    fn each_direction_has_its_own_compliance() {
        let mut memory = memory(&[]);
        memory.set_byte(at::CCW_MARGIN, 10);
        memory.set_byte(at::CW_SLOPE, 128);
        assert_eq!(compliance_duty(&memory, 10.0), 0);
        assert_eq!(compliance_duty(&memory, -65.0), -528);
        assert_eq!(compliance_duty(&memory, 42.0), 1023);
    }

    #[test]
    fn the_goal_is_approached_at_the_moving_speed() {
        // 100 of 0.111 rpm are 227 counts a second: to 1 short of 400 more, which
        // is within the margin, it takes 1.76 s.
        let mut memory = memory(&[(at::MOVING_SPEED, 100)]);
        let mut motor = Motor::new();
        motor.step(&mut memory, 100, PERIOD_S);
        memory.set_word(at::GOAL_POSITION, 500);
        motor.new_goal();
        let mut seconds = 0.0;
        let mut position = 100;
        loop {
            motor.step(&mut memory, position, PERIOD_S);
            position = motor.setpoint.floor() as u16;
            if memory.byte(at::MOVING) == 0 {
                break;
            }
            seconds += PERIOD_S;
        }
        assert!((seconds - 1.757).abs() < 0.01, "{seconds} s");
        let speed = signed(memory.word(at::PRESENT_SPEED));
        // One count in the window is 14.
        assert!((86..=114).contains(&speed), "{speed}");
    }
}
