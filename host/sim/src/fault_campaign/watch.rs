//! Monitor of a case: the board's bytes on the servo bus, the messages on its link, and its
//! restarts.

use std::ops::Range;

use armbridge_client::event::{Direction, Event, LinkDecoder};
use armbridge_link::board::HELLO_BITS;
use armbridge_link::frame::Decoder;
use armbridge_link::message::{BoardReport, End, LastEnd, Mode, OffReport, Record, ToHost};
use armbridge_servo::protocol2::model;
use armbridge_servo::{JOINTS, Pwm};

use super::fixture::Ends;
use crate::board::{Board, Input, Output, VirtualBoard, Wake};

/// Packet of a tick that sets the PWM of both servos of one firmware.
struct PwmPacket {
    /// Its first bytes.
    head: &'static [u8],
    len: usize,
    /// Bytes of each servo's value in it, low byte first.
    at: [Range<usize>; JOINTS],
    /// Deviation of a value from off, in counts.
    deviation: fn(u16) -> u16,
}

const PWM_PACKETS: [PwmPacket; 3] = [
    // Morpheus: `SYNC_WR` from 0x0F on, three bytes each, of which the last two are
    // the PWM.
    PwmPacket {
        head: &[0xAA, 13, 0xFF, 0xFE, 0x83, 0x0F, 3],
        len: 16,
        at: [9..11, 13..15],
        deviation: |pwm| pwm.abs_diff(Pwm::OFF.counts()),
    },
    // Stock: `SYNC_WRITE` of the moving speed, two bytes each: the duty, 1023 for all,
    // with bit 10 for the sign.
    PwmPacket {
        head: &[0xFF, 0xFF, 0xFE, 10, 0x83, 32, 2],
        len: 14,
        at: [8..10, 11..13],
        deviation: |duty| {
            let share = f64::from(duty & 1023) / 1023.0;
            (share * f64::from(Pwm::OFF.counts())).round() as u16
        },
    },
    // X: Sync Write of the goal PWM, two bytes each: the duty with its sign, 885 for all.
    PwmPacket {
        head: &[0xFF, 0xFF, 0xFD, 0, 0xFE, 13, 0, 0x83, 100, 0, 2, 0],
        len: 20,
        at: [13..15, 16..18],
        deviation: |duty| {
            let share = f64::from(duty.cast_signed()) / f64::from(model::FULL);
            (share.abs() * f64::from(Pwm::OFF.counts())).round() as u16
        },
    },
];

/// The board of a case.
pub(super) struct MonitoredBoard<'a> {
    pub(super) board: VirtualBoard<'a>,
    /// Largest deviation from off that it may send, in counts.
    pub(super) max_deviation: u16,
    /// First packet beyond that: its time in µs, and its deviation in counts.
    pub(super) beyond: Option<(u64, u16)>,
    /// Decoder of the link, and the receiver of its messages.
    decoder: Option<(LinkDecoder, &'a mut dyn FnMut(Event))>,
    /// The latest record, whether the host receives it or not.
    record: Option<Record>,
    /// The latest report on motors that must be off.
    pub(super) off_report: Option<OffReport>,
    messages: Decoder,
    /// Channels of the board after a restart, and its time in µs while it restarts.
    spare: Option<Ends<'a>>,
    restart_us: Option<u64>,
}

impl<'a> MonitoredBoard<'a> {
    /// A board with the channels of its first restart, which may send so much PWM.
    pub(super) fn new(board: VirtualBoard<'a>, spare: Ends<'a>, max_deviation: u16) -> Self {
        Self {
            board,
            max_deviation,
            beyond: None,
            decoder: None,
            record: None,
            off_report: None,
            messages: Decoder::default(),
            spare: Some(spare),
            restart_us: None,
        }
    }

    /// Takes the latest record.
    pub(super) fn take_record(&mut self) -> Option<Record> {
        self.record.take()
    }

    /// Mode of the board; that before, while it restarts.
    pub(super) fn mode(&self) -> Mode {
        self.board.mode()
    }

    /// Whether the supply has failed and the board does not run.
    pub(super) fn is_down(&self) -> bool {
        self.restart_us.is_some()
    }

    /// Lets the supply fail until this time. It does so once in a case.
    pub(super) fn brown_out(&mut self, until_us: u64) {
        self.restart_us = self.spare.is_some().then_some(until_us);
    }

    /// Boots with the settings in flash.
    fn restart(&mut self, now_us: u64) {
        let Some(ends) = self.spare.take() else {
            return;
        };
        let flash = self.board.flash().clone();
        let report = BoardReport {
            session: 2 << HELLO_BITS,
            last_end: LastEnd {
                cause: End::BrownOut,
                ..LastEnd::default()
            },
            ..BoardReport::default()
        };
        if let Ok(mut board) = VirtualBoard::after_reset(ends, flash, report) {
            board.shift_clock(-(now_us as i64));
            self.board = board;
        }
    }

    /// Decodes the link from now on.
    pub(super) fn decode_link(&mut self, on_event: &'a mut dyn FnMut(Event)) {
        self.decoder = Some((LinkDecoder::default(), on_event));
    }

    fn is_driven(&self) -> bool {
        // The board relays a client's packets.
        let mode = self.board.mode();
        mode.is_on() || mode == Mode::Passthrough
    }
}

impl Board for MonitoredBoard<'_> {
    type Error = <VirtualBoard<'static> as Board>::Error;

    fn run(
        &mut self,
        now_us: u64,
        input: Input<'_>,
        output: &mut Output,
    ) -> Result<Wake, Self::Error> {
        if let Some(at_us) = self.restart_us {
            if now_us < at_us {
                return Ok(Wake {
                    at_us,
                    bus_bytes: None,
                });
            }
            self.restart_us = None;
            self.restart(now_us);
        }
        let was_driven = self.is_driven();
        if let Some((decoder, on_event)) = &mut self.decoder {
            decoder.take(Direction::ToBoard, now_us * 1_000, input.link, on_event);
        }
        let wake = self.board.run(now_us, input, output)?;
        if let Some((decoder, on_event)) = &mut self.decoder {
            decoder.take(Direction::ToHost, now_us * 1_000, &output.link, on_event);
        }
        for byte in &output.link {
            if let Some(Ok(received)) = self.messages.push::<ToHost>(*byte) {
                match received.message {
                    ToHost::Record(record) => self.record = Some(record),
                    ToHost::Off(report) => self.off_report = Some(report),
                    _ => {}
                }
            }
        }
        let max_deviation = if was_driven || self.is_driven() {
            self.max_deviation
        } else {
            0
        };
        for counts in sent_deviations(&output.bus) {
            if counts > max_deviation {
                self.beyond.get_or_insert((now_us, counts));
            }
        }
        Ok(wake)
    }
}

/// Deviations from off, in counts, of all PWM values in these bytes.
fn sent_deviations(bytes: &[u8]) -> impl Iterator<Item = u16> {
    PWM_PACKETS.iter().flat_map(|layout| {
        bytes
            .windows(layout.len)
            .filter(|packet| packet.starts_with(layout.head))
            .flat_map(|packet| {
                layout.at.clone().map(|at| {
                    let bytes = at.rev().filter_map(|byte| packet.get(byte));
                    let number = bytes.fold(0, |number, byte| number << 8 | u16::from(*byte));
                    (layout.deviation)(number)
                })
            })
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use armbridge_board::bridge::SERVO_IDS;
    use armbridge_servo::morpheus::Request;
    use armbridge_servo::protocol1::{BROADCAST, Instruction};
    use armbridge_servo::protocol2;

    #[test]
    fn pwm_packets_are_decoded() {
        let [a, b] = [1_200, 3].map(|pwm| Pwm::new(pwm).unwrap());
        let mut bytes = Request::Cycle.encode().to_vec();
        bytes.extend(Request::Drive([(SERVO_IDS[0], a), (SERVO_IDS[1], b)]).encode());
        assert_eq!(sent_deviations(&bytes).collect::<Vec<_>>(), [200, 997]);
        let speeds = Instruction::SyncWrite {
            address: 32,
            count: 2,
            blocks: &[1, 0xFF, 0x03, 2, 0x00, 0x06],
        };
        let bytes = speeds.encode::<16>(BROADCAST).unwrap();
        assert_eq!(sent_deviations(&bytes).collect::<Vec<_>>(), [1_000, 500]);
        let [forth, back] = [708_i16, -885].map(i16::to_le_bytes);
        let goals = protocol2::Instruction::SyncWrite {
            address: protocol2::register::GOAL_PWM,
            count: 2,
            blocks: &[1, forth[0], forth[1], 2, back[0], back[1]],
        };
        let bytes = goals.encode::<20>(protocol2::BROADCAST).unwrap();
        assert_eq!(sent_deviations(&bytes).collect::<Vec<_>>(), [800, 1_000]);
    }
}
