//! Reads along what the board puts on the servo bus, and what is said on its link.

use std::ops::Range;

use armbridge_shared::JOINTS;
use armbridge_shared::actuator::Pwm;

use crate::bench::board::{Board, Input, Output, VirtualBoard, Wake};
use crate::log::event::{Direction, Ear, Event};

/// The tick's order to both Morpheus servos: `SYNC_WR` from 0x0F on, three bytes
/// each, of which the last two are the PWM.
const DRIVE: [u8; 7] = [0xAA, 13, 0xFF, 0xFE, 0x83, 0x0F, 3];
const DRIVE_LEN: usize = 16;
/// Where in it the PWMs are.
const PWM_AT: [Range<usize>; JOINTS] = [9..11, 13..15];

/// The board of a case.
pub(super) struct Watched<'a> {
    pub(super) board: VirtualBoard<'a>,
    /// Counts away from off that it may ask for.
    pub(super) allowed: u16,
    /// The first order that it should not have given: when in µs, and the PWM.
    pub(super) beyond: Option<(u64, u16)>,
    /// Is told what is said on the link, as the board hears it.
    ear: Option<(Ear, &'a mut dyn FnMut(Event))>,
}

impl<'a> Watched<'a> {
    pub(super) fn new(board: VirtualBoard<'a>, allowed: u16) -> Self {
        Self {
            board,
            allowed,
            beyond: None,
            ear: None,
        }
    }

    /// Tells what is said on the link from now on.
    pub(super) fn overhear(&mut self, hear: &'a mut dyn FnMut(Event)) {
        self.ear = Some((Ear::default(), hear));
    }

    fn is_driven(&self) -> bool {
        self.board.mode().drive().is_some()
    }
}

impl Board for Watched<'_> {
    type Error = <VirtualBoard<'static> as Board>::Error;

    fn run(
        &mut self,
        now_us: u64,
        input: Input<'_>,
        output: &mut Output,
    ) -> Result<Wake, Self::Error> {
        let was_driven = self.is_driven();
        if let Some((ear, hear)) = &mut self.ear {
            ear.take(Direction::ToBoard, now_us * 1_000, input.link, hear);
        }
        let wake = self.board.run(now_us, input, output)?;
        if let Some((ear, hear)) = &mut self.ear {
            ear.take(Direction::ToHost, now_us * 1_000, &output.link, hear);
        }
        let allowed = if was_driven || self.is_driven() {
            self.allowed
        } else {
            0
        };
        for pwm in ordered(&output.bus) {
            if pwm.abs_diff(Pwm::OFF.counts()) > allowed {
                self.beyond.get_or_insert((now_us, pwm));
            }
        }
        Ok(wake)
    }
}

/// The PWMs in the orders among these bytes.
fn ordered(bytes: &[u8]) -> impl Iterator<Item = u16> {
    bytes
        .windows(DRIVE_LEN)
        .filter(|packet| packet.starts_with(&DRIVE))
        .flat_map(|packet| {
            PWM_AT.map(|at| {
                at.into_iter()
                    .rev()
                    .fold(0, |pwm, byte| pwm << 8 | u16::from(packet[byte]))
            })
        })
}

#[cfg(test)]
mod tests {
    use super::*;
    use armbridge_shared::bridge::SERVO_IDS;
    use armbridge_shared::servo::morpheus::Request;

    #[test]
    fn orders_are_read() {
        let [a, b] = [1_200, 3].map(|pwm| Pwm::new(pwm).unwrap());
        let mut bytes = Request::Cycle.encode().to_vec();
        bytes.extend(Request::Drive([(SERVO_IDS[0], a), (SERVO_IDS[1], b)]).encode());
        assert_eq!(ordered(&bytes).collect::<Vec<_>>(), [1_200, 3]);
    }
}
