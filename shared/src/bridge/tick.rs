//! The tick, once its samples are in.

use embedded_hal::digital::OutputPin;
use embedded_hal_nb::serial::{Read, Write};

use super::Bridge;
use super::app_core::TickSamples;
use crate::link::message::Record;
use crate::servo::port::SetBaud;

impl<S, D> Bridge<'_, S, D>
where
    S: Read<u8> + Write<u8> + SetBaud,
    D: OutputPin,
{
    /// Everything that is decided in a tick. Bracket it with a stopwatch for
    /// [`Bridge::publish`].
    pub fn decide(&mut self) -> Record {
        let sampled = TickSamples {
            samples: self.samples,
            alarms: self.alarms,
            bus_us: self.bus_us,
        };
        let record = self.core.decide(&sampled);
        self.watch_halt();
        self.heed_core();
        record
    }

    /// Publishes the tick's record. True if the tick began and ended in time:
    /// feed the watchdog then.
    pub fn publish(&mut self, mut record: Record, compute_ns: u32) -> bool {
        record.timing.compute_ns = compute_ns;
        record.dropped = self.dropped;
        if self.end.records.enqueue(record).is_err() {
            self.dropped = self.dropped.wrapping_add(1);
        }
        self.core.is_in_time()
    }
}
