//! Judge of the output for a relay in the servos' supply.
//!
//! The bench has no relay, so that a stop must succeed without one; the output is compared with
//! what a relay is for:
//!
//! | state of the board                             | output                             |
//! |------------------------------------------------|------------------------------------|
//! | no fault, and the stop switch is not pressed   | on, or nothing could be driven     |
//! | emergency stop, corrupted memory, stop switch  | off                                |
//! | another fault, a motor in truth on for longer than [`BELIEVED_US`] | off            |
//! | another fault, reported for [`CONFIRM_US`] that a motor may be on | off             |
//! | a fault in which it was off before             | off: only clearing it ends that    |
//!
//! Bounds have [`Case::stop_us`] beside them, for the ticks of a slow bus.

use armbridge_board::bridge::supply_relay::{CONFIRM_US, SupplyPermission};
use armbridge_link::message::{Fault, Mode};
use armbridge_servo::JOINTS;

use super::case::Case;
use super::fixture::Fixture;
use super::kind::Kind;
use super::outcome::Outcome;

/// Time in µs for which a motor may be on in a fault: a board may believe for 100 ms what it
/// read before another master switched the motor on, and wait [`CONFIRM_US`] from then.
const BELIEVED_US: u64 = 100_000 + CONFIRM_US;

/// See the [module](self).
#[derive(Debug)]
pub(super) struct SupplyJudge {
    /// Time in µs at which the present fault began.
    fault_us: Option<u64>,
    /// It has been off in this fault.
    was_off: bool,
    /// The switch was pressed at the last event.
    was_pressed: bool,
    slack_us: u64,
    /// A servo answers for another, whose motor the board cannot know of.
    has_duplicate: bool,
}

impl SupplyJudge {
    pub(super) fn new(case: &Case) -> Self {
        Self {
            fault_us: None,
            was_off: false,
            was_pressed: false,
            slack_us: case.stop_us(),
            has_duplicate: case.has(Kind::DuplicateId),
        }
    }

    /// Compares the output with the state of board and motors. `unconfirmed_us` is the time since
    /// when the board reports that a motor may be on.
    pub(super) fn observe(
        &mut self,
        fixture: &Fixture<'_>,
        unconfirmed_us: Option<u64>,
        outcome: &mut Outcome,
    ) {
        let (now_us, mode) = (fixture.now_us(), fixture.mode());
        let is_pressed = fixture.cosim.is_stop_pressed;
        let was_pressed = std::mem::replace(&mut self.was_pressed, is_pressed);
        if fixture.is_down() {
            (self.fault_us, self.was_off) = (None, false);
            return;
        }
        let is_on = fixture.cosim.board.board.supply() == SupplyPermission::On;
        let Mode::Fault(fault) = mode else {
            (self.fault_us, self.was_off) = (None, false);
            if !is_on && !was_pressed {
                outcome.fail(format!("the supply was off in {mode:?}"));
            }
            return;
        };
        let fault_us = *self.fault_us.get_or_insert(now_us);
        let is_over =
            |since_us: u64, allowed_us: u64| now_us > since_us + allowed_us + self.slack_us;
        let is_driven = (0..JOINTS).any(|servo| {
            let on_us = fixture.on_since_us(servo);
            on_us.is_some_and(|on_us| is_over(on_us.max(fault_us), BELIEVED_US))
        });
        let why = if let Fault::EmergencyStop(_) | Fault::Corrupted = fault {
            Some("in an emergency stop, or with corrupted memory")
        } else if is_pressed && was_pressed {
            Some("while the switch was pressed")
        } else if is_driven && !self.has_duplicate {
            Some("in a fault, with a motor on")
        } else if unconfirmed_us.is_some_and(|since_us| is_over(since_us, CONFIRM_US)) {
            Some("in a fault, with a motor not confirmed off")
        } else {
            self.was_off.then_some("again, in the same fault")
        };
        if let (true, Some(why)) = (is_on, why) {
            outcome.fail(format!("the supply was on {why}"));
        }
        self.was_off |= !is_on;
    }
}
