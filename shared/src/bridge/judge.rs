//! What follows from what the core decides, on the bus and for the host.

use crate::servo::port::SetBaud;
use embedded_hal::digital::OutputPin;
use embedded_hal_nb::serial::{Read, Write};

use super::Bridge;
use super::app_core::BusAction;
use super::halt::Halting;
use super::mailbox::Notice;
use super::schedule::Stage;
use crate::JOINTS;
use crate::control_loop::Violation;
use crate::link::message::{Fault, Refusal, Sample, StopSource};
use crate::servo::master::Transaction;
use crate::supervisor::{Event, State};

/// Ticks without an answer after which a servo is taken for deaf.
const SILENT_TICKS: u32 = 3;
/// It is switched off twice in 20 ms at 1 kHz, whichever it is, and else the ticks
/// say off to both.
const QUELL_TICKS: u32 = 4;

impl<S, D> Bridge<'_, S, D>
where
    S: Read<u8> + Write<u8> + SetBaud,
    D: OutputPin,
{
    /// After a fault: are the servos seen to stand?
    pub(super) fn watch_halt(&mut self) {
        let Some(halting) = self.halting.as_mut() else {
            return;
        };
        let counts = self.samples.map(Sample::counts);
        let verdict = halting.watch(self.core.now_us(), counts);
        if verdict.stop_again {
            self.stop_due = true;
            self.core.set_next_start(self.core.now_us());
        }
        if let Some(halt) = verdict.report {
            let _ = self.end.notices.enqueue(Notice::Halted(halt));
        }
    }

    /// After a fault, a servo that says nothing may hear nothing either, but for one
    /// kind of packet: that, in two ticks of [`QUELL_TICKS`] a servo.
    pub(super) fn quell(&self) -> Option<Transaction> {
        if self.core.state() != State::Fault {
            return None;
        }
        let tick = self.core.tick() % (QUELL_TICKS * JOINTS as u32);
        let joint = (tick / QUELL_TICKS) as usize;
        let aside = match tick % QUELL_TICKS {
            0 => true,
            1 => false,
            _ => return None,
        };
        (self.core.lost_in_row(joint) > SILENT_TICKS).then_some(Transaction::Quell { joint, aside })
    }

    /// Emergency stop: the stop sequence begins when the exchange under way is over,
    /// within a tick.
    pub fn emergency_stop(&mut self, source: StopSource) {
        self.trip(Violation::plain(Fault::EmergencyStop(source)));
    }

    /// Torque off, latched with its first cause. The stop sequence follows at once
    /// on the bus.
    pub(super) fn trip(&mut self, violation: Violation) {
        self.core.trip(violation);
        self.heed_core();
    }

    /// Changes the state as the supervisor has it.
    pub(super) fn apply(&mut self, event: Event) -> Result<(), Refusal> {
        let result = self.core.apply(event);
        self.heed_core();
        result
    }

    /// Does on the bus what the core has decided, and tells the host.
    pub(super) fn heed_core(&mut self) {
        let state = self.core.state();
        if state != State::Passthrough && self.gateway.has_bus() {
            self.end_relay();
        }
        if state != State::Fault {
            self.halting = None;
        }
        match self.core.take_bus_action() {
            None => {}
            Some(BusAction::Halt) => {
                self.stop_due = true;
                self.halting = Some(Halting::begin(self.core.now_us()));
            }
            Some(BusAction::Search) => self.search(Stage::Stop),
            // What a client has set moving hears it at that client's speed.
            Some(BusAction::SearchHere) => self.search(Stage::StopHere),
            Some(BusAction::HandOver) => {
                self.stage = Stage::Released;
                // The client finds every motor off.
                self.stop_due = true;
                self.announce();
            }
        }
        if let Some(conclusion) = self.core.take_conclusion() {
            let _ = self.end.notices.enqueue(Notice::Concluded(conclusion));
        }
        if let Some(trip) = self.core.take_trip() {
            let _ = self.end.notices.enqueue(Notice::Tripped(trip));
        }
    }

    fn search(&mut self, from: Stage) {
        self.search.rewind();
        self.stage = from;
    }
}
