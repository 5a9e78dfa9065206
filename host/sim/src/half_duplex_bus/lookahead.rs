//! Lookahead: time for which a servo may run ahead of the wire.
//!
//! A servo is affected only by bytes, and a byte takes ten bits. So from the senders that
//! may begin a byte, and from those on the line, follows a time up to which a servo receives
//! nothing. Its internal events before that are executed at once, without a look at the
//! rest of the wire. Everything else happens at its time and in its order, and
//! so the result is the same.

use super::Wire;

/// The next events of a servo.
#[derive(Debug, Clone, Copy)]
pub(super) struct Schedule {
    /// Any event.
    pub(super) next_ns: u64,
    /// Time before which it begins no byte, unless it receives another one.
    pub(super) send_ns: u64,
}

impl Schedule {
    /// That of a servo whose next event at `next_ns` may be to send.
    pub(super) const fn of_sender(next_ns: u64) -> Self {
        Self {
            next_ns,
            send_ns: next_ns,
        }
    }
}

impl Wire {
    /// Executes internal events of all servos up to `to_ns`, as far as no byte can reach them
    /// before.
    pub(super) fn run_ahead(&mut self, to_ns: u64) {
        let start_ns = self.earliest_start_ns();
        // `advance_until` may stop at any byte of the master.
        let stop_ns = self
            .master
            .earliest_byte_ns(start_ns)
            .min(self.faults.next_ns())
            .min(to_ns.saturating_add(1));
        for servo in 0..self.servos.len() {
            let receiver = &self.receivers[servo];
            let device = &mut self.servos[servo];
            let received_ns = if device.heeds_start_bits() {
                receiver.next_ns().min(start_ns)
            } else {
                receiver.earliest_byte_ns(start_ns)
            };
            let limit_ns = received_ns.min(stop_ns);
            if self.schedule[servo].next_ns < limit_ns {
                device.run_ahead(self.now_ns, limit_ns);
                self.servo_changed(servo);
            }
        }
    }

    /// Time before which no further byte begins.
    fn earliest_start_ns(&self) -> u64 {
        let mut start_ns = self.due.front().map_or(u64::MAX, |frame| frame.start_ns);
        for (schedule, receiver) in self.schedule.iter().zip(&self.receivers) {
            start_ns = start_ns.min(schedule.send_ns).min(receiver.next_ns());
        }
        start_ns
    }
}
