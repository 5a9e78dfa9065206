//! Protection of a servo: heat, overload, a wrong supply.
//!
//! | hardware error   | bit | condition                                                    |
//! |------------------|-----|--------------------------------------------------------------|
//! | input voltage    | 0   | supply outside the voltage limits                            |
//! | overheating      | 2   | temperature above its limit                                  |
//! | overload         | 5   | full duty for [`STALL_NS`] with less than [`PROGRESS_COUNTS`] |
//!
//! One that is in the shutdown register clears torque enable, and only a reboot permits torque
//! again (e-Manual, "Shutdown"). Assumptions: those stay in the hardware error status until then,
//! others while their condition lasts; the time of an overload; encoder error and electrical shock
//! do not occur.
//!
//! # Heat
//!
//! One body that the motor heats and the air cools. The motor turns the stall power of the
//! e-Manual into heat at full duty and as its square below. The body holds 1 J/(g K), and cools
//! with a time constant of 440 s: assumed, as those of the AX-12A's simulation.

use armbridge_servo::protocol2::model::Model;
use armbridge_servo::protocol2::register as at;

use super::memory::Memory;
use super::motor::Output;
use super::specification::Specification;

/// Bits of the hardware error status.
pub(super) mod error {
    pub(in super::super) const INPUT_VOLTAGE: u8 = 1;
    pub(in super::super) const OVERHEATING: u8 = 1 << 2;
    pub(in super::super) const OVERLOAD: u8 = 1 << 5;
}

/// Time at full duty until an overload. Assumed: there is no source.
const STALL_NS: u64 = 1_000_000_000;
/// Motion that excludes an overload: 3 degrees.
const PROGRESS_COUNTS: i32 = 34;
/// Heat capacity of a gram.
const HEAT_J_PER_G_K: f64 = 1.0;
/// Time constant of cooling.
const COOLING_S: f64 = 440.0;
/// Temperature of the air.
const AIR_C: f64 = 25.0;

/// Start of the present time at full duty in one direction.
#[derive(Clone, Copy, Debug)]
struct FullPhase {
    since_ns: u64,
    position: i32,
    direction: i16,
}

/// State of the protection.
#[derive(Clone, Debug)]
pub(super) struct Protection {
    pub(super) temperature_c: f64,
    pub(super) supply_decivolt: u8,
    /// External heating.
    pub(super) external_c_per_s: f64,
    /// Heating at standstill and full duty.
    stall_c_per_s: f64,
    full_pwm: f64,
    full_phase: Option<FullPhase>,
    is_overloaded: bool,
    /// Errors that have switched torque off.
    latched: u8,
}

impl Protection {
    pub(super) fn new(model: &Model, specification: &Specification) -> Self {
        let stall_w = specification.stall_a * f64::from(model.nominal_v);
        Self {
            temperature_c: AIR_C,
            supply_decivolt: (10.0 * model.nominal_v).round() as u8,
            external_c_per_s: 0.0,
            stall_c_per_s: stall_w / (specification.mass_g * HEAT_J_PER_G_K),
            full_pwm: model.full_pwm.into(),
            full_phase: None,
            is_overloaded: false,
            latched: 0,
        }
    }

    /// Resets the state of the microcontroller; the temperature remains.
    pub(super) fn power_up(&mut self) {
        self.full_phase = None;
        self.is_overloaded = false;
        self.latched = 0;
    }

    /// Sets the temperature of the air, and ends external heating.
    pub(super) fn cool(&mut self) {
        (self.temperature_c, self.external_c_per_s) = (AIR_C, 0.0);
    }

    /// The supply in V, at least 0.1.
    pub(super) fn supply_v(&self) -> f64 {
        0.1 * f64::from(self.supply_decivolt.max(1))
    }

    /// Evaluates a control step, and updates the registers of heat, supply and errors. Returns
    /// whether torque is to be switched off.
    pub(super) fn step(
        &mut self,
        memory: &mut Memory,
        output: Output,
        now_ns: u64,
        period_s: f64,
    ) -> bool {
        self.heat(output.at_rest, period_s);
        let temperature = self.temperature_c.round().clamp(0.0, 255.0);
        memory.set_byte(at::PRESENT_TEMPERATURE, temperature as u8);
        memory.set_short(at::PRESENT_VOLTAGE, self.supply_decivolt.into());
        let is_stalled = self.is_stalled(memory, output, now_ns);
        if memory.torque_on() {
            self.is_overloaded = is_stalled;
        }
        let errors = self.errors(memory);
        let stopping = errors & memory.byte(at::SHUTDOWN);
        self.latched |= stopping;
        memory.set_byte(at::HARDWARE_ERROR, errors | self.latched);
        stopping != 0
    }

    /// Present errors.
    fn errors(&self, memory: &Memory) -> u8 {
        let limit = |address| memory.short(address);
        let supply = limit(at::MIN_VOLTAGE_LIMIT)..=limit(at::MAX_VOLTAGE_LIMIT);
        let is_hot = self.temperature_c > memory.byte(at::TEMPERATURE_LIMIT).into();
        let all = [
            (
                !supply.contains(&self.supply_decivolt.into()),
                error::INPUT_VOLTAGE,
            ),
            (is_hot, error::OVERHEATING),
            (self.is_overloaded, error::OVERLOAD),
        ];
        let active = all.into_iter().filter(|(is_active, _)| *is_active);
        active.fold(0, |errors, (_, error)| errors | error)
    }

    fn heat(&mut self, at_rest: i16, period_s: f64) {
        let share = f64::from(at_rest) / self.full_pwm;
        let cooling = (self.temperature_c - AIR_C) / COOLING_S;
        let own_c_per_s = self.stall_c_per_s * share * share - cooling;
        self.temperature_c += (own_c_per_s + self.external_c_per_s) * period_s;
    }

    fn is_stalled(&mut self, memory: &Memory, output: Output, now_ns: u64) -> bool {
        if !output.is_full {
            self.full_phase = None;
            return false;
        }
        let position = memory.long(at::PRESENT_POSITION);
        let sign = if memory.is_reverse() { -1 } else { 1 };
        let fresh = FullPhase {
            since_ns: now_ns,
            position,
            direction: sign * output.duty.signum(),
        };
        let phase = self.full_phase.get_or_insert(fresh);
        let progress = position.wrapping_sub(phase.position);
        let progress = progress.saturating_mul(phase.direction.into());
        if phase.direction != fresh.direction || progress >= PROGRESS_COUNTS {
            *phase = fresh;
        }
        now_ns.saturating_sub(phase.since_ns) >= STALL_NS
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::x_servo::specification;
    use armbridge_servo::protocol2::model;

    #[test]
    fn stalled_servos_overheat_in_minutes() {
        for number in [1060, 1200] {
            let model = model::find(number).unwrap();
            let specification = specification::find(model);
            let mut memory = Memory::new(model, specification);
            let mut protection = Protection::new(model, specification);
            let full = Output {
                duty: 885,
                at_rest: 885,
                is_full: false,
            };
            let seconds = (0..).take_while(|_| !protection.step(&mut memory, full, 0, 1.0));
            let seconds = seconds.count();
            assert!((100..300).contains(&seconds), "{}: {seconds} s", model.name);
            assert_eq!(memory.byte(at::HARDWARE_ERROR), error::OVERHEATING);
            // It stays after the servo has cooled down.
            protection.cool();
            protection.step(&mut memory, Output::default(), 0, 1.0);
            assert_eq!(memory.byte(at::HARDWARE_ERROR), error::OVERHEATING);
        }
    }

    #[test]
    fn a_wrong_supply_shuts_down_if_the_mask_says_so() {
        for (number, supply, errors, is_off) in [
            (1060, 59, 1, false),
            (1060, 60, 0, false),
            (1200, 34, 1, true),
            (1200, 71, 1, true),
            (1200, 70, 0, false),
        ] {
            let model = model::find(number).unwrap();
            let specification = specification::find(model);
            let mut memory = Memory::new(model, specification);
            let mut protection = Protection::new(model, specification);
            protection.supply_decivolt = supply;
            let found = protection.step(&mut memory, Output::default(), 0, 1e-3);
            assert_eq!(
                (memory.byte(at::HARDWARE_ERROR), found),
                (errors, is_off),
                "{supply}"
            );
        }
    }
}
