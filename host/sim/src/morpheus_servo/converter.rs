//! The analogue-digital converter and the rhythm in which the firmware uses it:
//! a position every eleventh tick, and a temperature every 1001 positions.

use super::cycle_costs;

/// A conversion is started on every eleventh tick.
const TICKS_PER_CONVERSION: u8 = 10;
/// Position conversions between two of the temperature.
const POSITIONS_PER_TEMPERATURE: u16 = 1000;
#[derive(Debug, Clone, Copy)]
enum Conversion {
    Off,
    Running { ready: u64 },
    Ready,
}

/// A result.
#[derive(Debug, Clone, Copy)]
pub(super) enum Sample {
    Position(u16),
    Temperature(u16),
}

#[derive(Debug, Clone)]
#[allow(clippy::struct_excessive_bools)] // The firmware's flags, each on its own.
pub(super) struct Converter {
    power_up: u64,
    conversion: Conversion,
    of_temperature: bool,
    used: bool,
    reading: u16,
    want_position: bool,
    want_temperature: bool,
    result_waits: bool,
    ticks_to_conversion: u8,
    positions: u16,
}

impl Converter {
    pub(super) fn new(now: u64) -> Self {
        Self {
            power_up: now,
            conversion: Conversion::Off,
            of_temperature: false,
            used: false,
            reading: 0,
            want_position: false,
            want_temperature: false,
            result_waits: false,
            ticks_to_conversion: TICKS_PER_CONVERSION,
            positions: 0,
        }
    }

    /// When the running conversion is done.
    pub(super) fn result_at(&self) -> u64 {
        match self.conversion {
            Conversion::Running { ready } => ready,
            Conversion::Off | Conversion::Ready => u64::MAX,
        }
    }

    pub(super) fn finish(&mut self) {
        self.conversion = Conversion::Ready;
    }

    /// Its inputs.
    pub(super) fn converted(&mut self, position: u16, temperature: u16) {
        self.reading = if self.of_temperature {
            temperature
        } else {
            position
        };
    }

    /// Its interrupt is pending.
    pub(super) fn interrupts(&self) -> bool {
        matches!(self.conversion, Conversion::Ready)
    }

    /// The interrupt handler has run.
    pub(super) fn acknowledge(&mut self) {
        self.conversion = Conversion::Off;
        self.result_waits = true;
    }

    pub(super) fn take_result(&mut self) -> Option<Sample> {
        if !std::mem::take(&mut self.result_waits) {
            None
        } else if self.of_temperature {
            Some(Sample::Temperature(self.reading))
        } else {
            Some(Sample::Position(self.reading))
        }
    }

    /// The timer tick: starts a conversion when one is wanted and the converter
    /// is free. Returns its cost.
    pub(super) fn tick(&mut self, now: u64) -> u64 {
        let due = self.ticks_to_conversion == 0;
        let mut cost = 0;
        if due {
            self.ticks_to_conversion = TICKS_PER_CONVERSION;
            self.want_position = true;
            cost = cycle_costs::TICK_DUE;
            if self.positions == POSITIONS_PER_TEMPERATURE {
                self.positions = 0;
                self.want_temperature = true;
            } else {
                self.positions += 1;
            }
        } else {
            self.ticks_to_conversion -= 1;
        }
        if !matches!(self.conversion, Conversion::Off) || self.result_waits {
            return cost;
        }
        if !self.want_temperature && !self.want_position {
            return cost + cycle_costs::TICK_NOT_CONVERTING;
        }
        self.of_temperature = self.want_temperature;
        let start = if self.want_temperature {
            self.want_temperature = false;
            cost = cycle_costs::TICK_TEMPERATURE;
            cycle_costs::SAMPLE_TO_TEMPERATURE
        } else {
            self.want_position = false;
            cost += cycle_costs::TICK_NOT_CONVERTING + cycle_costs::TICK_CONVERT;
            if due {
                cycle_costs::SAMPLE_TO_CONVERSION
            } else {
                cycle_costs::SAMPLE_TO_LATE_CONVERSION
            }
        };
        let mut length = cycle_costs::CONVERT;
        if !self.used {
            self.used = true;
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
