//! Control step of the servo: from the encoder's count to the motor's duty, and the registers of
//! position, speed, duty and current.
//!
//! ```text
//! PWM                    duty = goal PWM
//! current                duty = (current / stall + speed / no-load speed) nominal / supply * 885
//! velocity               duty = P/128 e + I/65536 sum e            e in 0.229 rpm
//! position, extended     duty = P/128 e + I/65536 sum e - D/16 v   e in counts, v in counts/ms
//! current-based position the same, between the duties of -goal current and goal current
//! ```
//!
//! Outside PWM mode the goal PWM limits the duty, and everywhere the PWM limit. The gains'
//! divisors are the e-Manual's ("Position PID Gain", "Velocity PI Gain"), except 256 for P of
//! XL330 and XC330, see `specification`. XL330 and XC330 change the duty by at most their PWM
//! slope. Duties are -885..=885, positive towards higher positions.
//!
//! Assumptions: sums are over control steps, and stay within full duty; the differential acts on
//! the measured speed, which is the mean of [`WINDOW`] steps; the current follows from duty and
//! the shaft's own speed as in a motor without inductance, and is controlled without error; the load
//! of a model
//! without it is the duty. Profiles, feedforward and the moving status are registers only.

use armbridge_servo::protocol2::model::{Model, OperatingMode};
use armbridge_servo::protocol2::register as at;

use super::PERIOD_S;
use super::memory::Memory;
use super::specification::Specification;

/// Control steps over which the speed is measured: one count is 4 units of 0.229 rpm.
const WINDOW: usize = 16;
/// Counts of a turn.
const TURN: i32 = 4_096;
/// Unit of the speed in rpm (e-Manual, "Present Velocity").
const RPM_PER_UNIT: f64 = 0.229;
/// Largest homing offset, either way, that counts in position control mode (e-Manual, "Homing
/// Offset").
const JOINT_HOMING_MAX: i32 = 1_024;
/// Operating modes with a goal position.
const POSITION_MODES: [OperatingMode; 3] = [
    OperatingMode::Position,
    OperatingMode::ExtendedPosition,
    OperatingMode::CurrentBasedPosition,
];

/// Result of a control step.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Output {
    /// Duty of the motor, positive towards higher counts of the encoder.
    pub(super) duty: i16,
    /// Without what balances the back-EMF, where it controls the current.
    pub(super) at_rest: i16,
    /// It is full duty.
    pub(super) is_full: bool,
}

/// Speed of the shaft in counts a second.
#[derive(Clone, Copy, Debug)]
struct Speed {
    /// By the encoder.
    measured: f64,
    /// Its own.
    shaft: f64,
}

/// State of the control.
#[derive(Clone, Debug)]
pub(super) struct Motor {
    model: &'static Model,
    specification: &'static Specification,
    /// Position in counts over all turns, without homing offset.
    position: Option<i32>,
    /// Positions of the last steps; `newest` is the index of the last one.
    history: [i32; WINDOW],
    newest: usize,
    /// Sum of the errors.
    sum: f64,
    duty: f64,
}

impl Motor {
    pub(super) fn new(model: &'static Model, specification: &'static Specification) -> Self {
        Self {
            model,
            specification,
            position: None,
            history: [0; WINDOW],
            newest: 0,
            sum: 0.0,
            duty: 0.0,
        }
    }

    /// Processes a count of the encoder, with the speed of the shaft where it is known: updates the
    /// registers, and computes the duty at this supply.
    pub(super) fn step(
        &mut self,
        memory: &mut Memory,
        count: u16,
        shaft_counts_per_s: Option<f64>,
        supply_v: f64,
    ) -> Output {
        self.update_position(memory, count);
        let measured = self.counts_per_s();
        let shaft = shaft_counts_per_s.map_or(measured, |counts_per_s| {
            if memory.is_reverse() {
                -counts_per_s
            } else {
                counts_per_s
            }
        });
        let speed = Speed { measured, shaft };
        let wanted = if memory.torque_on() {
            self.wanted_duty(memory, speed, supply_v)
        } else {
            self.stop(memory);
            0.0
        };
        self.apply(memory, wanted, supply_v);
        let duty = self.duty.round() as i16;
        self.update_registers(memory, speed, supply_v);
        let is_full = duty.unsigned_abs() >= self.model.full_pwm;
        let is_by_current = memory.torque_on() && memory.has_mode(&[OperatingMode::Current]);
        let at_rest = if is_by_current {
            self.duty - self.duty_of_current(0.0, speed.shaft, supply_v)
        } else {
            self.duty
        };
        let sign = if memory.is_reverse() { -1 } else { 1 };
        Output {
            duty: sign * duty,
            at_rest: sign * at_rest.round() as i16,
            is_full,
        }
    }

    /// Resets the turns: the position is within one.
    pub(super) fn clear_turns(&mut self) {
        if let Some(position) = &mut self.position {
            let turns = position.div_euclid(TURN) * TURN;
            *position -= turns;
            for before in &mut self.history {
                *before = before.wrapping_sub(turns);
            }
        }
    }

    /// Begins anew with the next count: the direction of rotation has changed.
    pub(super) fn turn_round(&mut self) {
        self.position = None;
    }

    /// Makes the present state the goal of the operating mode.
    pub(super) fn stop(&mut self, memory: &mut Memory) {
        self.sum = 0.0;
        if memory.has_mode(&POSITION_MODES) {
            memory.set_long(at::GOAL_POSITION, self.present(memory));
        }
    }

    fn update_position(&mut self, memory: &mut Memory, count: u16) {
        let count = i32::from(count) % TURN;
        let count = if memory.is_reverse() {
            TURN - 1 - count
        } else {
            count
        };
        let Some(before) = self.position else {
            self.position = Some(count);
            self.history = [count; WINDOW];
            return self.stop(memory);
        };
        let half = TURN / 2;
        let step = (count - before.rem_euclid(TURN) + half).rem_euclid(TURN) - half;
        let position = before.wrapping_add(step);
        self.position = Some(position);
        self.newest = (self.newest + 1) % WINDOW;
        self.history[self.newest] = position;
    }

    /// The position register.
    fn present(&self, memory: &Memory) -> i32 {
        let homing = memory.long(at::HOMING_OFFSET);
        let is_joint = memory.has_mode(&[OperatingMode::Position]);
        let is_ignored = is_joint && homing.abs() > JOINT_HOMING_MAX;
        let position = self.position.unwrap_or_default();
        position.wrapping_add(if is_ignored { 0 } else { homing })
    }

    fn counts_per_s(&self) -> f64 {
        let oldest = self.history[(self.newest + 1) % WINDOW];
        let moved = self.history[self.newest].wrapping_sub(oldest);
        f64::from(moved) / ((WINDOW - 1) as f64 * PERIOD_S)
    }

    fn wanted_duty(&mut self, memory: &Memory, speed: Speed, supply_v: f64) -> f64 {
        let counts_per_s = speed.measured;
        let gain = |address: u16, divisor: f64| f64::from(memory.short(address)) / divisor;
        let goal_pwm = f64::from(memory.short(at::GOAL_PWM));
        if memory.has_mode(&[OperatingMode::Pwm]) {
            return goal_pwm;
        }
        let at_goal_current = |sign: f64| {
            let goal = f64::from(memory.short(at::GOAL_CURRENT));
            let current_a = sign * goal * self.a_per_count();
            self.duty_of_current(current_a, speed.shaft, supply_v)
        };
        let full = f64::from(self.model.full_pwm);
        let limit = goal_pwm.abs();
        if memory.has_mode(&[OperatingMode::Current]) {
            return at_goal_current(1.0).clamp(-limit, limit);
        }
        let current_range = memory
            .has_mode(&[OperatingMode::CurrentBasedPosition])
            .then(|| [-1.0, 1.0].map(at_goal_current));
        let (error, proportional, integral, differential) =
            if memory.has_mode(&[OperatingMode::Velocity]) {
                let speed = units_of_speed(counts_per_s);
                (
                    f64::from(memory.long(at::GOAL_VELOCITY)) - speed,
                    gain(at::VELOCITY_P_GAIN, 128.0),
                    gain(at::VELOCITY_I_GAIN, 65_536.0),
                    0.0,
                )
            } else {
                let goal = f64::from(memory.long(at::GOAL_POSITION));
                (
                    goal - f64::from(self.present(memory)),
                    gain(at::POSITION_P_GAIN, self.specification.position_p_divisor),
                    gain(at::POSITION_I_GAIN, 65_536.0),
                    gain(at::POSITION_D_GAIN, 16.0),
                )
            };
        let sum_max = if integral > 0.0 { full / integral } else { 0.0 };
        self.sum = (self.sum + error).clamp(-sum_max, sum_max);
        let duty = proportional * error + integral * self.sum - differential * counts_per_s * 1e-3;
        let duty = match current_range {
            Some([a, b]) => duty.clamp(a.min(b), a.max(b)),
            None => duty,
        };
        duty.clamp(-limit, limit)
    }

    fn a_per_count(&self) -> f64 {
        self.model
            .current
            .map_or(0.0, |current| current.a_per_count.into())
    }

    /// Speed as a share of that without a load.
    fn speed_share(&self, counts_per_s: f64) -> f64 {
        units_of_speed(counts_per_s) * RPM_PER_UNIT / f64::from(self.model.no_load_rpm)
    }

    fn duty_of_current(&self, current_a: f64, counts_per_s: f64, supply_v: f64) -> f64 {
        let share = current_a / self.specification.stall_a + self.speed_share(counts_per_s);
        share * f64::from(self.model.nominal_v) / supply_v * f64::from(self.model.full_pwm)
    }

    /// Changes the duty as far as slope and limit permit; off is at once.
    fn apply(&mut self, memory: &Memory, wanted: f64, supply_v: f64) {
        let full = f64::from(self.model.full_pwm);
        let limit = f64::from(memory.short(at::PWM_LIMIT)).min(full);
        let wanted = wanted.clamp(-limit, limit);
        self.duty = match self.specification.slope {
            Some(slope) if memory.torque_on() => {
                let mv_per_ms = f64::from(memory.byte(at::PWM_SLOPE)) * slope.mv_per_ms;
                let most = mv_per_ms * PERIOD_S / supply_v * full;
                self.duty + (wanted - self.duty).clamp(-most, most)
            }
            _ => wanted,
        };
    }

    fn update_registers(&self, memory: &mut Memory, speed: Speed, supply_v: f64) {
        let full = f64::from(self.model.full_pwm);
        let share = self.duty / full;
        let current = if self.model.current.is_some() {
            let driven = share * supply_v / f64::from(self.model.nominal_v);
            let current_a = self.specification.stall_a * (driven - self.speed_share(speed.shaft));
            // A winding that is not driven is open.
            if memory.torque_on() {
                current_a / self.a_per_count()
            } else {
                0.0
            }
        } else {
            1e3 * share
        };
        let speed = units_of_speed(speed.measured).round() as i32;
        let is_moving = speed.abs() > memory.long(at::MOVING_THRESHOLD);
        memory.set_byte(at::MOVING, u8::from(is_moving));
        memory.set_short(at::PRESENT_PWM, self.duty.round() as i16);
        memory.set_short(at::PRESENT_CURRENT, current.round() as i16);
        memory.set_long(at::PRESENT_VELOCITY, speed);
        memory.set_long(at::PRESENT_POSITION, self.present(memory));
        memory.set_long(at::VELOCITY_TRAJECTORY, memory.long(at::GOAL_VELOCITY));
        memory.set_long(at::POSITION_TRAJECTORY, memory.long(at::GOAL_POSITION));
    }
}

fn units_of_speed(counts_per_s: f64) -> f64 {
    counts_per_s / f64::from(TURN) * 60.0 / RPM_PER_UNIT
}
