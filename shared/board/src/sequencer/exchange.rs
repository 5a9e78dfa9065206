//! The exchange of a tick: a torque with permission to drive, and motors off otherwise.

use super::{BusSequencer, Dropouts, State};
use armbridge_servo::bus::Bus;
use armbridge_servo::master::Transaction;
use armbridge_servo::{Firmware, JOINTS, Pwm};

/// Ticks without a reply after which a servo may be wedged.
const SILENT_TICKS: u32 = 3;
/// Ticks in which a wedged servo is switched off, two of this many for each joint: twice
/// in 20 ms at 1 kHz; the other ticks command both.
const WEDGED_TICKS: u32 = 4;

impl<B: Bus> BusSequencer<B> {
    /// Begins a tick: sends the servos `pwm` with permission to drive, and motors off
    /// otherwise. The exchange may take `available_us`.
    pub fn begin_tick(
        &mut self,
        pwm: [Pwm; JOINTS],
        tick: u32,
        dropouts: &Dropouts,
        available_us: u32,
    ) {
        self.tick = tick;
        self.master.set_available(available_us);
        let transaction = match self.state {
            State::Drive if self.permission.drives_motors() => Transaction::Drive(pwm),
            State::ForceOff => self.off_exchange(tick, dropouts),
            State::Drive | State::Search(_) | State::Passthrough => return,
        };
        // The bus is idle when a tick is due.
        let _ = self.master.begin(transaction, self.now_us);
        let _ = self.master.poll(self.now_us);
    }

    /// The exchange of a tick that commands every motor off. A silent Morpheus servo may be
    /// wedged, and accepts only one kind of packet. A silent stock servo may be inside a
    /// packet that was cut off, and receives the first packet after its end: each tick has one.
    fn off_exchange(&self, tick: u32, dropouts: &Dropouts) -> Transaction {
        if !self.off.is_order_due() {
            return Transaction::Drive([Pwm::OFF; JOINTS]);
        }
        let turn = tick % (WEDGED_TICKS * JOINTS as u32);
        let joint = (turn / WEDGED_TICKS) as usize;
        let is_silent = dropouts
            .in_row
            .get(joint)
            .is_some_and(|silent| *silent > SILENT_TICKS);
        let may_be_wedged = is_silent && self.firmware() == Firmware::Morpheus;
        match turn % WEDGED_TICKS {
            turn @ (0 | 1) if may_be_wedged => Transaction::StopWedged {
                joint,
                is_side_step: turn == 0,
            },
            // Prepared servos are off at speed 0.
            _ if self.is_prepared() => Transaction::Drive([Pwm::OFF; JOINTS]),
            _ => Transaction::HoldOff,
        }
    }
}
