//! Flow token: evidence that a tick went through every machine, in order.
//!
//! The watchdog may be fed only with a token that sequencer, control loop and supervisor
//! have each stamped in this tick. Each stamp is an odd factor and a sum, so that none can
//! be left out, repeated or exchanged for another: the token of any other way through a
//! tick, or of another tick, is another number.

/// A machine that stamps.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Machine {
    /// It has carried out the tick's exchange.
    Sequencer,
    /// It has decided the tick.
    ControlLoop,
    /// It has judged what was decided.
    Supervisor,
}

/// Stamps of a tick so far.
///
/// ```
/// use armbridge_board::flow_token::{FlowToken, Machine};
///
/// let sampled = FlowToken::begin(7).stamp(Machine::Sequencer);
/// let decided = sampled.stamp(Machine::ControlLoop).stamp(Machine::Supervisor);
/// assert!(decided.is_complete(7));
/// assert!(!decided.is_complete(8), "of another tick");
/// assert!(!sampled.stamp(Machine::Supervisor).is_complete(7), "not decided");
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct FlowToken(u32);

impl FlowToken {
    /// The token of this tick, without any stamp.
    pub const fn begin(tick: u32) -> Self {
        Self(tick)
    }

    /// The token with one stamp more.
    #[must_use]
    pub const fn stamp(self, machine: Machine) -> Self {
        let (factor, sum) = match machine {
            Machine::Sequencer => (0x9E37_79B1, 0x7F4A_7C15),
            Machine::ControlLoop => (0x85EB_CA77, 0x27D4_EB2F),
            Machine::Supervisor => (0xC2B2_AE3D, 0x1656_67B1),
        };
        Self(self.0.wrapping_mul(factor).wrapping_add(sum))
    }

    /// Whether all have stamped it, in order, in this tick.
    pub const fn is_complete(self, tick: u32) -> bool {
        let complete = Self::begin(tick)
            .stamp(Machine::Sequencer)
            .stamp(Machine::ControlLoop)
            .stamp(Machine::Supervisor);
        self.0 == complete.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use Machine::{ControlLoop, Sequencer, Supervisor};

    #[test]
    fn only_every_stamp_in_order_and_in_this_tick_is_complete() {
        let token = |tick, stamps: &[Machine]| {
            let begun = FlowToken::begin(tick);
            stamps
                .iter()
                .fold(begun, |token, stamp| token.stamp(*stamp))
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
            let whole = token(tick, &[Sequencer, ControlLoop, Supervisor]);
            assert!(whole.is_complete(tick) && !whole.is_complete(tick.wrapping_add(1)));
            for way in ways {
                assert!(!token(tick, way).is_complete(tick), "{way:?}");
            }
        }
    }
}
