//! Protection of a servo: heat, overload, a wrong supply.
//!
//! | alarm         | condition                                               |
//! |---------------|---------------------------------------------------------|
//! | input voltage | supply outside the voltage limits                       |
//! | overheating   | temperature above its limit                             |
//! | overload      | all that the torque limit allows for [`STALL_NS`], and less than [`PROGRESS_COUNTS`] of motion that way |
//!
//! They show in every status packet for as long as the condition lasts. That of
//! an overload lasts until torque is allowed again: off, the servo cannot know.
//!
//! # Heat
//!
//! One body that the motor heats and the air cools. The motor turns 18 W into
//! heat at full duty (stall: 1.5 A at 12 V, e-Manual) and as its square below;
//! that a turning motor draws less is left out, so the servo is hotter than a
//! real one that moves. Its 54.6 g (e-Manual) hold about 55 J/K, at 1 J/(g K),
//! between steel and plastic; 8 K/W to the air are assumed. So a stalled servo
//! goes from 25 to 70 degrees in 150 s, and half duty is about its continuous
//! rating.

use armbridge_shared::servo::protocol1::Alarms;

use super::memory::{Memory, at};
use super::motor::{FULL, Output};

/// Time until a load counts as too large. Assumed: there is no source.
const STALL_NS: u64 = 1_000_000_000;
/// Motion that shows that the load can be moved: 3 degrees, beyond any noise.
const PROGRESS_COUNTS: i32 = 10;
/// Heat of a stalled motor at full duty.
const STALL_W: f64 = 18.0;
/// Heat for one degree.
const HEAT_J_PER_K: f64 = 55.0;
/// From the motor to the air.
const RESISTANCE_K_PER_W: f64 = 8.0;
/// Temperature of the air.
const AIR_C: f64 = 25.0;
/// Recommendation of the e-Manual.
const SUPPLY_DECIVOLT: u8 = 111;

/// Since when, and where, the motor does all it may in one direction.
#[derive(Clone, Copy, Debug)]
struct Effort {
    since_ns: u64,
    position: u16,
    towards: i16,
}

/// State of the protection.
#[derive(Clone, Debug)]
pub(super) struct Protection {
    pub(super) temperature_c: f64,
    pub(super) supply_decivolt: u8,
    /// Heating from outside.
    pub(super) heated_c_per_s: f64,
    effort: Option<Effort>,
    is_overloaded: bool,
}

impl Protection {
    pub(super) fn new() -> Self {
        Self {
            temperature_c: AIR_C,
            supply_decivolt: SUPPLY_DECIVOLT,
            heated_c_per_s: 0.0,
            effort: None,
            is_overloaded: false,
        }
    }

    /// The microcontroller forgets; the motor stays as hot as it is.
    pub(super) fn power_up(&mut self) {
        self.effort = None;
        self.is_overloaded = false;
    }

    /// As cold as the air, and heated by nothing outside.
    pub(super) fn cool(&mut self) {
        (self.temperature_c, self.heated_c_per_s) = (AIR_C, 0.0);
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
        .filter(|(is_so, _)| *is_so)
        .fold(Alarms::NONE, |alarms, (_, alarm)| alarms.or(alarm))
    }

    fn heat(&mut self, duty: i16, period_s: f64) {
        let share = f64::from(duty) / f64::from(FULL);
        let in_w = STALL_W * share * share;
        let out_w = (self.temperature_c - AIR_C) / RESISTANCE_K_PER_W;
        let own_c_per_s = (in_w - out_w) / HEAT_J_PER_K;
        self.temperature_c += (own_c_per_s + self.heated_c_per_s) * period_s;
    }

    fn is_stalled(&mut self, memory: &Memory, output: Output, now_ns: u64) -> bool {
        if !output.is_limited {
            self.effort = None;
            return false;
        }
        let (position, towards) = (memory.word(at::PRESENT_POSITION), output.duty.signum());
        let fresh = Effort {
            since_ns: now_ns,
            position,
            towards,
        };
        let effort = self.effort.get_or_insert(fresh);
        let progress =
            (i32::from(position) - i32::from(effort.position)) * i32::from(effort.towards);
        if effort.towards != towards || progress >= PROGRESS_COUNTS {
            *effort = fresh;
        }
        now_ns - effort.since_ns >= STALL_NS
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const STEP_NS: u64 = 1_000_000;

    /// Full duty at these positions, a step each; the step at which it switches off.
    fn gives_up_at(positions: impl Iterator<Item = u16>) -> Option<u64> {
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
    fn overload_is_a_load_that_does_not_move() {
        let noise = |step: u64| 500 + (step * 7 % 5) as u16;
        assert_eq!(gives_up_at((0..3_000).map(noise)), Some(1_000));
        // 12 counts a second clockwise, and the same the other way.
        let turning = |step: u64| 500 - (step * 12 / 1_000) as u16;
        assert_eq!(gives_up_at((0..3_000).map(turning)), None);
        let back = |step: u64| 500 + (step * 12 / 1_000) as u16;
        assert_eq!(gives_up_at((0..3_000).map(back)), Some(1_000));
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
