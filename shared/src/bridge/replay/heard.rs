//! What only the record's mode tells of a tick.

use super::Replay;
use crate::link::message::{Drive, Fault, Mode};

/// What a record's mode says that cannot be decided again.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Heard {
    /// Nothing of that kind.
    Nothing,
    /// The host was silent for so long that the arm was braked, or let go.
    Silence,
    /// For so long that it was a fault.
    LongSilence,
    /// Numbers in memory had changed.
    Corruption,
}

impl Replay<'_> {
    /// What its mode says beside what is decided again, for the bridge as it is
    /// before the decision.
    pub fn heard(&self, told: Mode) -> Heard {
        let bridge = &self.bridge;
        match (told, bridge.drive) {
            _ if !bridge.state.is_armed() => Heard::Nothing,
            (Mode::Fault(Fault::HostSilent), _) => Heard::LongSilence,
            (Mode::Fault(Fault::Corrupted), _) => Heard::Corruption,
            // An experiment that ends by itself in this tick does so before it heeds that.
            (
                Mode::Running(Drive::Hold) | Mode::Degraded(Drive::Hold),
                Drive::Track | Drive::Experiment,
            )
            | (Mode::Armed, Drive::Torque)
                if bridge.state.is_driven() =>
            {
                Heard::Silence
            }
            _ => Heard::Nothing,
        }
    }
}
