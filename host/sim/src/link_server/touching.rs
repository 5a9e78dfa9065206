//! Touches of the simulated arm by programs: checked, and passed on to the simulation.
//!
//! Any connected program may touch the arm, also while another one commands the board: a touch
//! is an event of the simulation, as a real hand would be, and not a command. A hand is refused
//! while the board is armed: the first torque would end its hold.

use std::sync::mpsc::{Receiver, Sender, channel};

use armbridge_link::message::ToHost;
use armbridge_link::server::{Touch, TouchRefusal};

use crate::cosim::Interaction;

/// The arm as programs may touch it.
#[derive(Debug, Default)]
pub(super) struct Touching {
    /// `None` if there is no simulated arm.
    arm: Option<Sender<Interaction>>,
    /// By the board's latest record.
    is_armed: bool,
}

impl Touching {
    /// The end of the simulation that has the arm.
    pub(super) fn connect(&mut self) -> Receiver<Interaction> {
        let (sender, interactions) = channel();
        self.arm = Some(sender);
        interactions
    }

    /// Whether there is an arm.
    pub(super) fn is_possible(&self) -> bool {
        self.arm.is_some()
    }

    /// Takes a message of the board.
    pub(super) fn take(&mut self, message: &ToHost) {
        if let ToHost::Record(record) = message {
            self.is_armed = record.mode.is_armed();
        }
    }

    /// Touches the arm.
    pub(super) fn touch(&self, touch: Touch) -> Result<(), TouchRefusal> {
        let arm = self.arm.as_ref().ok_or(TouchRefusal::NoArm)?;
        touch.check()?;
        if touch.motion_us() > 0 && self.is_armed {
            return Err(TouchRefusal::Armed);
        }
        arm.send(touch.into()).map_err(|_| TouchRefusal::NoArm)
    }
}
