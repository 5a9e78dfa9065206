//! Protection of a servo: heat, overload, a wrong supply.
//!
//! | alarm         | condition                                               |
//! |---------------|---------------------------------------------------------|
//! | input voltage | supply outside the voltage limits                       |
//! | overheating   | temperature above its limit                             |
//! | overload      | all that the torque limit allows for [`STALL_NS`], and less than [`PROGRESS_COUNTS`] of motion that way |
//!
//! They are set in every status packet while the condition lasts. An overload lasts until
//! torque is enabled again: with torque off the servo cannot detect its end.
//!
//! # Heat
//!
//! One body that the motor heats and the air cools. The motor turns 18 W into
//! heat at full duty (stall: 1.5 A at 12 V, e-Manual) and as its square below;
//! the lower current of a turning motor is neglected, so the servo is hotter than a
//! real one that moves. Its 54.6 g (e-Manual) hold about 55 J/K, at 1 J/(g K),
//! between steel and plastic; 8 K/W to the air are assumed. So a stalled servo
//! goes from 25 to 70 degrees in 150 s, and half duty is about its continuous
//! rating.

use armbridge_servo::Alarms;

use super::memory::{Memory, at};
use super::motor::{FULL, Output};

/// Time at the torque limit until an overload. Assumed: there is no source.
const STALL_NS: u64 = 1_000_000_000;
/// Motion that excludes an overload: 3 degrees, above the noise.
const PROGRESS_COUNTS: i32 = 10;
/// Heat power of a stalled motor at full duty.
const STALL_W: f64 = 18.0;
/// Heat capacity.
const HEAT_J_PER_K: f64 = 55.0;
/// Thermal resistance from the motor to the air.
const RESISTANCE_K_PER_W: f64 = 8.0;
/// Temperature of the air.
const AIR_C: f64 = 25.0;
/// Supply recommended by the e-Manual.
const SUPPLY_DECIVOLT: u8 = 111;

/// Start of the present time at the torque limit in one direction.
#[derive(Clone, Copy, Debug)]
struct LimitPhase {
    since_ns: u64,
    position: u16,
    direction: i16,
}

/// State of the protection.
#[derive(Clone, Debug)]
pub(super) struct Protection {
    pub(super) temperature_c: f64,
    pub(super) supply_decivolt: u8,
    /// External heating.
    pub(super) external_c_per_s: f64,
    limit_phase: Option<LimitPhase>,
    is_overloaded: bool,
}

impl Protection {
    pub(super) fn new() -> Self {
        Self {
            temperature_c: AIR_C,
            supply_decivolt: SUPPLY_DECIVOLT,
            external_c_per_s: 0.0,
            limit_phase: None,
            is_overloaded: false,
        }
    }

    /// Resets the state of the microcontroller; the temperature remains.
    pub(super) fn power_up(&mut self) {
        self.limit_phase = None;
        self.is_overloaded = false;
    }

    /// Sets the temperature of the air, and ends external heating.
    pub(super) fn cool(&mut self) {
        (self.temperature_c, self.external_c_per_s) = (AIR_C, 0.0);
    }

    /// Evaluates a control step, updates the registers of heat
    /// and supply, and returns the alarms.
    pub(super) fn step(
        &mut self,
        memory: &mut Memory,
        output: Output,
        now_ns: u64,
        period_s: f64,
    ) -> Alarms {
        self.heat(output.duty, period_s);
        memory.set_byte(at::PRESENT_TEMPERATURE, self.temperature_c.round() as u8);
        memory.set_byte(at::PRESENT_VOLTAGE, self.supply_decivolt);
        let is_stalled = self.is_stalled(memory, output, now_ns);
        if memory.torque_on() {
            self.is_overloaded = is_stalled;
        }
        self.alarms(memory)
    }

    /// Present alarms.
    pub(super) fn alarms(&self, memory: &Memory) -> Alarms {
        let supply = memory.byte(at::MIN_VOLTAGE)..=memory.byte(at::MAX_VOLTAGE);
        let is_hot = self.temperature_c > memory.byte(at::TEMPERATURE_LIMIT).into();
        [
            (is_hot, Alarms::OVERHEATING),
            (self.is_overloaded, Alarms::OVERLOAD),
            (
                !supply.contains(&self.supply_decivolt),
                Alarms::INPUT_VOLTAGE,
            ),
        ]
        .into_iter()
        .filter(|(is_active, _)| *is_active)
        .fold(Alarms::NONE, |alarms, (_, alarm)| alarms.or(alarm))
    }

    fn heat(&mut self, duty: i16, period_s: f64) {
        let share = f64::from(duty) / f64::from(FULL);
        let in_w = STALL_W * share * share;
        let out_w = (self.temperature_c - AIR_C) / RESISTANCE_K_PER_W;
        let own_c_per_s = (in_w - out_w) / HEAT_J_PER_K;
        self.temperature_c += (own_c_per_s + self.external_c_per_s) * period_s;
    }

    fn is_stalled(&mut self, memory: &Memory, output: Output, now_ns: u64) -> bool {
        if !output.is_limited {
            self.limit_phase = None;
            return false;
        }
        let (position, direction) = (memory.word(at::PRESENT_POSITION), output.duty.signum());
        let fresh = LimitPhase {
            since_ns: now_ns,
            position,
            direction,
        };
        let limit_phase = self.limit_phase.get_or_insert(fresh);
        let progress = (i32::from(position) - i32::from(limit_phase.position))
            * i32::from(limit_phase.direction);
        if limit_phase.direction != direction || progress >= PROGRESS_COUNTS {
            *limit_phase = fresh;
        }
        now_ns - limit_phase.since_ns >= STALL_NS
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const STEP_NS: u64 = 1_000_000;

    /// Full duty at these positions, a step each; the step at which it switches off.
    fn overload_step(positions: impl Iterator<Item = u16>) -> Option<u64> {
        let (mut memory, mut protection) = (Memory::new(), Protection::new());
        memory.set_byte(at::TORQUE_ENABLE, 1);
        let output = Output {
            duty: -FULL,
            is_limited: true,
        };
        let mut steps = 0..;
        for (position, step) in positions.zip(&mut steps) {
            memory.set_word(at::PRESENT_POSITION, position);
            let alarms = protection.step(&mut memory, output, step * STEP_NS, 1e-3);
            if alarms.contains(Alarms::OVERLOAD) {
                return Some(step);
            }
        }
        None
    }

    #[test]
    fn overload_needs_a_load_without_motion() {
        let noise = |step: u64| 500 + (step * 7 % 5) as u16;
        assert_eq!(overload_step((0..3_000).map(noise)), Some(1_000));
        // 12 counts a second clockwise, and the same the other way.
        let turning = |step: u64| 500 - (step * 12 / 1_000) as u16;
        assert_eq!(overload_step((0..3_000).map(turning)), None);
        let back = |step: u64| 500 + (step * 12 / 1_000) as u16;
        assert_eq!(overload_step((0..3_000).map(back)), Some(1_000));
    }

    #[test]
    fn stalled_servos_overheat_in_minutes_and_cool_down() {
        let mut memory = Memory::new();
        let mut protection = Protection::new();
        let mut hold = |duty, seconds: u32| {
            let output = Output {
                duty,
                is_limited: false,
            };
            for _ in 0..seconds {
                protection.step(&mut memory, output, 0, 1.0);
            }
            (
                memory.byte(at::PRESENT_TEMPERATURE),
                protection.alarms(&memory),
            )
        };
        assert_eq!(hold(FULL, 120), (59, Alarms::NONE));
        assert_eq!(hold(FULL, 60).1, Alarms::OVERHEATING);
        assert_eq!(hold(0, 600).1, Alarms::NONE);
        // Half duty for an hour.
        assert_eq!(hold(FULL / 2, 3_600), (61, Alarms::NONE));
    }

    #[test]
    fn supply_outside_its_limits_is_an_alarm() {
        let memory = Memory::new();
        let mut protection = Protection::new();
        for (supply, alarms) in [
            (59, Alarms::INPUT_VOLTAGE),
            (60, Alarms::NONE),
            (140, Alarms::NONE),
            (141, Alarms::INPUT_VOLTAGE),
        ] {
            protection.supply_decivolt = supply;
            assert_eq!(protection.alarms(&memory), alarms, "{supply}");
        }
    }
}
