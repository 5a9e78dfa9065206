//! The analogue-digital converter and its schedule in the firmware: a position every
//! eleventh tick, and a temperature every 1001 positions.

use super::cycle_costs;

/// A conversion is started on every eleventh tick.
const TICKS_PER_CONVERSION: u8 = 10;
/// Position conversions between two of the temperature.
const POSITIONS_PER_TEMPERATURE: u16 = 1000;

/// State of the present conversion.
#[derive(Debug, Clone, Copy)]
enum Conversion {
    Off,
    Running { ready: u64 },
    Ready,
}

/// Result of a conversion.
#[derive(Debug, Clone, Copy)]
pub(super) enum Sample {
    Position(u16),
    Temperature(u16),
}

/// The converter, and the firmware's flags about it.
#[derive(Debug, Clone)]
#[allow(clippy::struct_excessive_bools)] // Independent flags of the firmware.
pub(super) struct Converter {
    power_up: u64,
    conversion: Conversion,
    is_temperature: bool,
    has_converted: bool,
    reading: u16,
    position_due: bool,
    temperature_due: bool,
    result_waits: bool,
    ticks_to_conversion: u8,
    positions: u16,
}

impl Converter {
    pub(super) fn new(now: u64) -> Self {
        Self {
            power_up: now,
            conversion: Conversion::Off,
            is_temperature: false,
            has_converted: false,
            reading: 0,
            position_due: false,
            temperature_due: false,
            result_waits: false,
            ticks_to_conversion: TICKS_PER_CONVERSION,
            positions: 0,
        }
    }

    /// End of the running conversion.
    pub(super) fn result_at(&self) -> u64 {
        match self.conversion {
            Conversion::Running { ready } => ready,
            Conversion::Off | Conversion::Ready => u64::MAX,
        }
    }

    pub(super) fn finish(&mut self) {
        self.conversion = Conversion::Ready;
    }

    /// Stores the reading of its inputs.
    pub(super) fn converted(&mut self, position: u16, temperature: u16) {
        self.reading = if self.is_temperature {
            temperature
        } else {
            position
        };
    }

    /// Whether its interrupt is pending.
    pub(super) fn interrupts(&self) -> bool {
        matches!(self.conversion, Conversion::Ready)
    }

    /// Acknowledges the interrupt, at the end of its handler.
    pub(super) fn acknowledge(&mut self) {
        self.conversion = Conversion::Off;
        self.result_waits = true;
    }

    pub(super) fn take_result(&mut self) -> Option<Sample> {
        if !std::mem::take(&mut self.result_waits) {
            None
        } else if self.is_temperature {
            Some(Sample::Temperature(self.reading))
        } else {
            Some(Sample::Position(self.reading))
        }
    }

    /// Timer tick: starts a conversion when one is due and the converter is free.
    /// Returns its cost.
    pub(super) fn tick(&mut self, now: u64) -> u64 {
        let due = self.ticks_to_conversion == 0;
        let mut cost = 0;
        if due {
            self.ticks_to_conversion = TICKS_PER_CONVERSION;
            self.position_due = true;
            cost = cycle_costs::TICK_DUE;
            if self.positions == POSITIONS_PER_TEMPERATURE {
                self.positions = 0;
                self.temperature_due = true;
            } else {
                self.positions += 1;
            }
        } else {
            self.ticks_to_conversion -= 1;
        }
        if !matches!(self.conversion, Conversion::Off) || self.result_waits {
            return cost;
        }
        if !self.temperature_due && !self.position_due {
            return cost + cycle_costs::TICK_NOT_CONVERTING;
        }
        self.is_temperature = self.temperature_due;
        let start = if self.temperature_due {
            self.temperature_due = false;
            cost = cycle_costs::TICK_TEMPERATURE;
            cycle_costs::CONVERTER_TO_TEMPERATURE
        } else {
            self.position_due = false;
            cost += cycle_costs::TICK_NOT_CONVERTING + cycle_costs::TICK_CONVERT;
            if due {
                cycle_costs::CONVERTER_TO_CONVERSION
            } else {
                cycle_costs::CONVERTER_TO_LATE_CONVERSION
            }
        };
        let mut length = cycle_costs::CONVERT;
        if !self.has_converted {
            self.has_converted = true;
            length += cycle_costs::CONVERT_FIRST;
        }
        let edge = (now + start - self.power_up - cycle_costs::CONVERTER_PHASE)
            .next_multiple_of(cycle_costs::CONVERTER_CLOCK)
            + self.power_up
            + cycle_costs::CONVERTER_PHASE;
        self.conversion = Conversion::Running {
            ready: edge + length,
        };
        cost
    }
}
