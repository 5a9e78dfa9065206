//! Debug units, as a program sees them: DEMCR and the cycle counter.
//!
//! A reset of the processor leaves them as they are. Source: DDI 0403, C1.6.5 and C1.8.

use super::Core;
use super::nvic::number;

const TRCENA: u32 = 1 << 24;
const MON_EN: u32 = 1 << 16;

/// DEMCR and the counter of the DWT.
#[derive(Clone, Debug, Default)]
pub(crate) struct Debug {
    pub(crate) demcr: u32,
    /// `DWT_CTRL.CYCCNTENA`.
    pub(crate) counts: bool,
    /// The counter while it stands; while it counts, less the time of its start.
    count: u32,
}

impl Core {
    fn is_counting(&self) -> bool {
        self.debug.counts && self.debug.demcr & TRCENA != 0
    }

    /// The counter's value.
    pub(crate) fn cycle_count(&self) -> u32 {
        if self.is_counting() {
            self.debug.count.wrapping_add(self.time as u32)
        } else {
            self.debug.count
        }
    }

    pub(crate) fn set_cycle_count(&mut self, value: u32) {
        self.debug.count = if self.is_counting() {
            value.wrapping_sub(self.time as u32)
        } else {
            value
        };
    }

    pub(crate) fn set_counting(&mut self, counts: bool) {
        let value = self.cycle_count();
        self.debug.counts = counts;
        self.set_cycle_count(value);
    }

    pub(crate) fn set_demcr(&mut self, demcr: u32) {
        let value = self.cycle_count();
        self.debug.demcr = demcr;
        self.set_cycle_count(value);
        self.nvic
            .set_enabled(number::DEBUG_MONITOR, demcr & MON_EN != 0);
    }
}
