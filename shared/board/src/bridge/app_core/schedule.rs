//! Schedule: number, beginning and lateness of the ticks. All times in µs.
//!
//! A tick that begins a whole period late or more has made others impossible: these are counted
//! as missed, and not made up for.

use armbridge_link::message::Timing;

/// See the [module](self).
#[derive(Clone, Debug)]
pub(crate) struct Schedule {
    pub(crate) now_us: u64,
    /// Planned beginning of the next tick.
    pub(crate) next_start_us: u64,
    /// Beginning of the tick under way.
    pub(crate) start_us: u64,
    /// Number of the tick under way.
    pub(crate) tick: u32,
    /// Number of the last decided tick.
    pub(crate) decided: u32,
    pub(crate) timing: Timing,
}

impl Schedule {
    /// A schedule whose first tick is due now.
    pub(crate) fn new(now_us: u64) -> Self {
        Self {
            now_us,
            next_start_us: now_us,
            start_us: 0,
            tick: 0,
            decided: 0,
            timing: Timing::default(),
        }
    }

    /// Puts the beginning of the next tick to now.
    pub(crate) fn start_now(&mut self) {
        self.next_start_us = self.now_us;
    }

    /// Plans the tick after the one that begins now, at this period. Returns the lateness of that
    /// one, and the number of ticks missed.
    pub(crate) fn plan_next(&mut self, period_us: u64) -> (u64, u32) {
        let late_us = self.now_us.saturating_sub(self.next_start_us);
        let missed = if late_us < period_us {
            0
        } else {
            late_us.checked_div(period_us).unwrap_or(0)
        };
        self.next_start_us += (missed + 1) * period_us;
        (late_us, missed as u32)
    }

    /// Begins the tick. Apart from [`plan_next`](Self::plan_next), because an overrun in between is
    /// a fault of the tick before.
    pub(crate) fn begin_tick(&mut self, late_us: u64, missed: u32) {
        self.start_us = self.now_us;
        self.tick = self.tick.wrapping_add(1);
        self.timing = Timing {
            start_error_us: late_us as u32,
            missed: self.timing.missed.wrapping_add(missed),
            ..Timing::default()
        };
    }

    /// Time from the beginning of the tick to the planned beginning of the next.
    pub(crate) fn lead_us(&self) -> u32 {
        self.next_start_us.saturating_sub(self.start_us) as u32
    }

    /// Time in ms since `us`, rounded up.
    pub(crate) fn ms_since(&self, us: u64) -> u16 {
        // The processor divides 32 bits in hardware.
        let since_us = u32::try_from(self.now_us.saturating_sub(us)).unwrap_or(u32::MAX);
        u16::try_from(since_us.div_ceil(1_000)).unwrap_or(u16::MAX)
    }
}
