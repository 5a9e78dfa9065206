//! Requests of the bridge to Morpheus servos.

use super::codes::{command, register};
use super::frame::{BROADCAST, Frame};
use crate::{JOINTS, Packet, Pwm, ServoId};

/// Address of the bridge. At least 0x20, so that no servo mistakes it for a register,
/// and never a servo's: [`ServoId`] excludes it.
pub const MASTER: u8 = 0xFE;

/// All requests of the bridge to Morpheus servos.
///
/// A tick is [`Request::Drive`], [`Request::Cycle`], and a position of each servo:
///
/// ```
/// use armbridge_servo::morpheus::{MASTER, Parser, Request};
/// use armbridge_servo::{Pwm, ServoId};
///
/// let [first, second] = [1, 2].map(|id| ServoId::new(id).unwrap());
/// let drive = Request::Drive([(first, Pwm::new(1_500).unwrap()), (second, Pwm::OFF)]);
/// assert_eq!(
///     drive.encode(),
///     [0xAA, 13, 0xFF, 0xFE, 0x83, 0x0F, 3, 1, 0, 0xDC, 5, 2, 0, 0xE8, 3, 0x84],
/// );
/// assert_eq!(Request::Cycle.encode(), [0xAA, 3, 0xFF, 0xFE, 7, 0xF5]);
///
/// // Servo 1 reports 500 counts; of servo 2 a bit was damaged.
/// let mut parser = Parser::to(MASTER);
/// let mut replies = Vec::new();
/// for byte in [0xAA, 4, 0xFE, 1, 1, 0xF4, 3, 0xAA, 4, 0xFE, 2, 1, 0xF5, 3] {
///     if let Some(packet) = parser.push(byte) {
///         replies.push(packet.map(|frame| (frame.source, frame.data.to_vec())));
///     }
/// }
/// assert_eq!(replies[0], Ok((1, 500_u16.to_be_bytes().to_vec())));
/// assert!(replies[1].is_err());
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Request {
    /// Presence test, answered with one byte.
    Ping(ServoId),
    /// Forms the position chain: each servo answers in turn, 4.74 ms times its id
    /// later, and learns its predecessor in [`Request::Cycle`].
    Start,
    /// Every started servo sends its position, one after another in the order
    /// of their ids. High byte first, so never 0x83.
    Cycle,
    /// A PWM for each servo, by the checked SYNC_WR. No reply. Wants a pause of
    /// 20 µs before the next packet.
    Drive([(ServoId, Pwm); JOINTS]),
    /// PWM 1000 by broadcast WRITE: motors off in every control mode. No reply.
    StopAll,
    /// PWM 1001, by the unchecked SYNC_WR: the only packet that a servo still
    /// accepts after a packet of LEN 128 or more. 1000 is ignored where the last
    /// such value was 1000, hence the step aside first. No reply.
    SideStep([ServoId; JOINTS]),
    /// PWM 1000 by the unchecked SYNC_WR, after [`Request::SideStep`].
    Release([ServoId; JOINTS]),
}

impl Request {
    /// The bytes on the wire.
    pub fn encode(&self) -> Packet {
        use command::{CYCLE, PING, START, SYNC_WR, WRITE};
        let [off_low, off_high] = Pwm::OFF.counts().to_le_bytes();
        match *self {
            Self::Ping(id) => packet(id.get(), &[PING]),
            Self::Start => packet(BROADCAST, &[START]),
            Self::Cycle => packet(BROADCAST, &[CYCLE]),
            Self::StopAll => packet(BROADCAST, &[WRITE, register::PWM, off_low, off_high]),
            Self::Drive([a, b]) => {
                let ([a_low, a_high], [b_low, b_high]) =
                    (a.1.counts().to_le_bytes(), b.1.counts().to_le_bytes());
                let (a, b) = (a.0.get(), b.0.get());
                #[rustfmt::skip]
                let data = [SYNC_WR, register::BEFORE_PWM, 3,
                    a, 0, a_low, a_high,
                    b, 0, b_low, b_high];
                packet(BROADCAST, &data)
            }
            Self::SideStep(ids) => unchecked_sync(ids, Pwm::OFF.counts() + 1),
            Self::Release(ids) => unchecked_sync(ids, Pwm::OFF.counts()),
        }
    }
}

/// SYNC_WR of one value to the PWM register. Private: taken without regard to
/// its checksum, it must never carry a torque.
fn unchecked_sync([a, b]: [ServoId; JOINTS], pwm: u16) -> Packet {
    let [low, high] = pwm.to_le_bytes();
    #[rustfmt::skip]
    let data = [command::SYNC_WR, register::PWM, 2, a.get(), low, high, b.get(), low, high];
    packet(BROADCAST, &data)
}

/// Frames `data`; the caller's data always fits [`REQUEST_MAX`](super::REQUEST_MAX).
pub(super) fn packet(destination: u8, data: &[u8]) -> Packet {
    let frame = Frame {
        destination,
        source: MASTER,
        data,
    };
    // Capacity is REQUEST_MAX, the longest request there is.
    frame.encode().unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn id(id: u8) -> ServoId {
        ServoId::new(id).unwrap()
    }

    /// All but the last were recorded on a bus with the firmware, which did as
    /// it should; the last was computed from the packet layout.
    #[test]
    fn requests_encode_as_recorded() {
        let drive = Request::Drive(
            [(1, 1500), (2, 900)].map(|(servo, pwm)| (id(servo), Pwm::new(pwm).unwrap())),
        );
        #[rustfmt::skip]
        let vectors: [(Request, &[u8]); 6] = [
            (Request::Ping(id(1)), &[0xAA, 3, 1, 0xFE, 1, 0xF9]),
            (Request::Start, &[0xAA, 3, 0xFF, 0xFE, 6, 0xF6]),
            (Request::Cycle, &[0xAA, 3, 0xFF, 0xFE, 7, 0xF5]),
            (
                Request::StopAll,
                &[0xAA, 6, 0xFF, 0xFE, 3, 0x10, 0xE8, 3, 0xF8],
            ),
            (
                drive,
                &[0xAA, 13, 0xFF, 0xFE, 0x83, 0x0F, 3, 1, 0, 0xDC, 5, 2, 0, 0x84, 3, 0xE8],
            ),
            (
                Request::Release([id(1), id(2)]),
                &[
                    0xAA, 11, 0xFF, 0xFE, 0x83, 0x10, 2, 1, 0xE8, 3, 2, 0xE8, 3, 0x7E,
                ],
            ),
        ];
        for (request, bytes) in vectors {
            assert_eq!(request.encode(), bytes, "{request:?}");
        }
    }
}
