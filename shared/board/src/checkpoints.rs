//! Checkpoints: evidence that a tick went through every machine, in order.
//!
//! The watchdog may be fed only if sequencer, control loop and supervisor have each passed
//! their checkpoint in this tick. A checkpoint multiplies by an odd factor and adds a sum, so that
//! none can be left out, repeated or exchanged for another: any other way through a tick, or
//! another tick, gives another number.

/// A machine with a checkpoint.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Machine {
    /// It has carried out the tick's exchange.
    Sequencer,
    /// It has decided the tick.
    ControlLoop,
    /// It has judged what was decided.
    Supervisor,
}

/// Checkpoints that a tick has passed so far.
///
/// ```
/// use armbridge_board::checkpoints::{Checkpoints, Machine};
///
/// let sampled = Checkpoints::begin(7).pass(Machine::Sequencer);
/// let decided = sampled.pass(Machine::ControlLoop).pass(Machine::Supervisor);
/// assert!(decided.is_complete(7));
/// assert!(!decided.is_complete(8), "of another tick");
/// assert!(!sampled.pass(Machine::Supervisor).is_complete(7), "not decided");
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Checkpoints(u32);

impl Checkpoints {
    /// The checkpoints of this tick, none of them passed.
    pub const fn begin(tick: u32) -> Self {
        Self(tick)
    }

    /// The checkpoints with this one passed, too.
    #[must_use]
    pub const fn pass(self, machine: Machine) -> Self {
        let (factor, sum) = match machine {
            Machine::Sequencer => (0x9E37_79B1, 0x7F4A_7C15),
            Machine::ControlLoop => (0x85EB_CA77, 0x27D4_EB2F),
            Machine::Supervisor => (0xC2B2_AE3D, 0x1656_67B1),
        };
        Self(self.0.wrapping_mul(factor).wrapping_add(sum))
    }

    /// Whether all have been passed, in order, in this tick.
    pub const fn is_complete(self, tick: u32) -> bool {
        let complete = Self::begin(tick)
            .pass(Machine::Sequencer)
            .pass(Machine::ControlLoop)
            .pass(Machine::Supervisor);
        self.0 == complete.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use Machine::{ControlLoop, Sequencer, Supervisor};

    #[test]
    fn only_every_checkpoint_in_order_and_in_this_tick_is_complete() {
        let checkpoints = |tick, passed: &[Machine]| {
            let begun = Checkpoints::begin(tick);
            passed
                .iter()
                .fold(begun, |checkpoints, machine| checkpoints.pass(*machine))
        };
        let ways: [&[Machine]; 6] = [
            &[],
            &[Sequencer, ControlLoop],
            &[ControlLoop, Supervisor],
            &[Sequencer, Supervisor, ControlLoop],
            &[Sequencer, ControlLoop, ControlLoop, Supervisor],
            &[Sequencer, Supervisor],
        ];
        for tick in [0, 1, 1_000, u32::MAX] {
            let whole = checkpoints(tick, &[Sequencer, ControlLoop, Supervisor]);
            assert!(whole.is_complete(tick) && !whole.is_complete(tick.wrapping_add(1)));
            for way in ways {
                assert!(!checkpoints(tick, way).is_complete(tick), "{way:?}");
            }
        }
    }
}
