//! A line on which nothing happens by itself, and a port on it.

use std::cell::RefCell;
use std::collections::VecDeque;
use std::convert::Infallible;
use std::rc::Rc;

use armbridge_link::message::Sample;
use armbridge_servo::master::{ExpectedReply, Outcome, Payload, Transaction};
use armbridge_servo::morpheus::{HEADER, MASTER, checksum};
use armbridge_servo::port::SetBaud;
use armbridge_servo::protocol1::Status;
use armbridge_servo::protocol1::frame::{self, FRAME_MAX};
use armbridge_servo::{Alarms, Firmware, protocol2};
use embedded_hal::digital::{self, OutputPin};
use embedded_hal_nb::serial::{self, ErrorKind};

/// Room of a transmitter that takes everything.
const PLENTY: usize = 1_000;

/// Sending behaviour of the port.
pub(super) struct Transmitter {
    /// Bytes that it takes.
    pub(super) room: usize,
    /// The last bit is still to be sent.
    pub(super) is_sending: bool,
    /// It takes bytes, but reports errors.
    pub(super) fails: bool,
}

impl Default for Transmitter {
    fn default() -> Self {
        Self {
            room: PLENTY,
            is_sending: false,
            fails: false,
        }
    }
}

#[derive(Default)]
pub(super) struct Line {
    /// Bytes and errors that the port will receive.
    pub(super) coming: VecDeque<Result<u8, ErrorKind>>,
    /// Bytes that the master has read of it.
    read: Vec<u8>,
    /// Bytes sent, and how many of them have been echoed.
    sent: Vec<u8>,
    echoed: usize,
    is_driven: bool,
    pub(super) transmitter: Transmitter,
}

impl Line {
    /// A new transaction begins.
    pub(super) fn forget(&mut self) {
        self.read.clear();
        self.sent.clear();
        self.echoed = 0;
    }

    /// Echoes what was sent.
    pub(super) fn echo(&mut self) {
        self.coming
            .extend(self.sent[self.echoed..].iter().map(|byte| Ok(*byte)));
        self.echoed = self.sent.len();
    }

    /// Checks that all was sent, the line is released, and every accepted reply was
    /// received; counts these.
    pub(super) fn check(
        &self,
        outcome: &Outcome,
        sent: &[u8],
        firmware: Firmware,
        reply: Option<&Payload>,
    ) -> usize {
        let transaction = outcome.transaction;
        assert!(!self.is_driven, "{transaction:?}");
        assert_eq!(self.sent, sent, "{transaction:?}");
        let mut believed = 0;
        let samples = outcome.samples.into_iter().zip(outcome.alarms);
        for (id, (sample, alarms)) in (1..).zip(samples) {
            let Sample::Counts(counts) = sample else {
                continue;
            };
            let most = match firmware {
                Firmware::Morpheus | Firmware::Stock => 1023,
                Firmware::XSeries => 4095,
            };
            assert!(counts <= most, "{outcome:?}");
            let [low, high] = counts.to_le_bytes();
            let reply_bytes = match (transaction, firmware) {
                (Transaction::Ping { joint }, _) if joint + 1 != usize::from(id) => {
                    panic!("{outcome:?} was not asked")
                }
                (
                    Transaction::Drive(_) | Transaction::HoldOff | Transaction::StopWedged { .. },
                    Firmware::Morpheus,
                ) => morpheus(id, &[high, low]),
                (
                    Transaction::Drive(_) | Transaction::HoldOff | Transaction::StopWedged { .. },
                    Firmware::Stock,
                ) => {
                    let replies = self.stock_replies(id);
                    let of_sample = replies.iter().find(|(of_reply, data)| {
                        *data == [low, high] && alarms.contains(*of_reply)
                    });
                    let all = replies.iter().fold(Alarms::NONE, |all, it| all.or(it.0));
                    assert!(all.contains(alarms), "{outcome:?} from {:02x?}", self.read);
                    let Some((alarms, _)) = of_sample else {
                        panic!("{outcome:?} from {:02x?}", self.read)
                    };
                    stock(id, *alarms, &[low, high])
                }
                (
                    Transaction::Drive(_) | Transaction::HoldOff | Transaction::StopWedged { .. },
                    Firmware::XSeries,
                ) => {
                    let is_found = self.has_read_part(id, &[low, high, 0, 0]);
                    assert!(is_found, "{outcome:?} from {:02x?}", self.read);
                    believed += 1;
                    continue;
                }
                (Transaction::Start, _) | (Transaction::Ping { .. }, Firmware::Morpheus) => {
                    morpheus(id, &[1])
                }
                // With any contents beyond its alarms.
                (Transaction::Ping { .. }, Firmware::Stock | Firmware::XSeries) => continue,
                (Transaction::Stop | Transaction::BriefStop | Transaction::Request(_), _) => {
                    panic!("{outcome:?} was believed")
                }
            };
            assert!(
                self.has_read(&reply_bytes),
                "{outcome:?} from {:02x?}",
                self.read
            );
            believed += 1;
        }
        if let (Transaction::Request(ExpectedReply { id, .. }), Some(Payload { alarms, data })) =
            (transaction, reply)
        {
            // A Morpheus servo's answer is to whom the packet came from.
            let reply_bytes = match firmware {
                Firmware::Morpheus => [&[id], data.as_slice()].concat(),
                Firmware::Stock => stock(id, *alarms, data),
                Firmware::XSeries => {
                    let is_found =
                        (0..=u8::MAX).any(|error| self.has_read(&x_series(id, error, data)));
                    assert!(is_found, "{reply:?} from {:02x?}", self.read);
                    return believed + 1;
                }
            };
            assert!(
                self.has_read(&reply_bytes),
                "{reply:?} from {:02x?}",
                self.read
            );
            believed += 1;
        }
        believed
    }

    /// Whether a part of a fast status packet with these data was read, after whole ones.
    fn has_read_part(&self, id: u8, data: &[u8]) -> bool {
        const PART: usize = 8;
        let is_part = |start: usize, index: usize| {
            let begin = start + PART + index * PART;
            let packet = self.read.get(start..begin + PART)?;
            let (body, crc) = packet.split_at_checked(packet.len() - 2)?;
            let is_head = packet.starts_with(&[0xFF, 0xFF, 0xFD, 0, 0xFE]) && packet[7] == 0x55;
            let is_intact = crc == protocol2::crc::checksum(body).to_le_bytes();
            let part = &packet[packet.len() - PART..packet.len() - 2];
            Some(is_head && is_intact && part[1] == id && part[2..] == *data)
        };
        let starts = 0..self.read.len();
        let mut places = starts.flat_map(|start| (0..2).map(move |index| (start, index)));
        places.any(|(start, index)| is_part(start, index) == Some(true))
    }

    /// Alarms and data of every status packet of this servo that was read, wherever it may
    /// begin.
    fn stock_replies(&self, id: u8) -> Vec<(Alarms, &[u8])> {
        let reply = |start: usize| {
            let body = self.read.get(start..)?.strip_prefix(&[frame::HEADER; 2])?;
            let (&[sender, length, alarms], _) = body.split_first_chunk()?;
            let end = usize::from(length) + 1;
            let (checked, data) = (body.get(..end)?, body.get(3..end)?);
            let is_intact = body.get(end) == Some(&frame::checksum(checked));
            (is_intact && sender == id).then_some((Alarms::from_bits(alarms), data))
        };
        (0..self.read.len()).filter_map(reply).collect()
    }

    fn has_read(&self, reply_bytes: &[u8]) -> bool {
        self.read
            .windows(reply_bytes.len())
            .any(|part| part == reply_bytes)
    }
}

/// A Morpheus servo's answer to the master.
fn morpheus(id: u8, data: &[u8]) -> Vec<u8> {
    let mut packet = vec![HEADER, data.len() as u8 + 2, MASTER, id];
    packet.extend(data);
    packet.push(checksum(&packet[1..]));
    packet
}

/// A stock servo's answer.
fn stock(id: u8, alarms: Alarms, parameters: &[u8]) -> Vec<u8> {
    let status = Status {
        id,
        alarms,
        parameters,
    };
    let packet = status.encode::<FRAME_MAX>().expect("a short packet");
    packet.to_vec()
}

/// Serial port and direction pin.
#[derive(Clone, Default)]
pub(super) struct Port(Rc<RefCell<Line>>);

impl Port {
    pub(super) fn edit<R>(&self, change: impl FnOnce(&mut Line) -> R) -> R {
        change(&mut self.0.borrow_mut())
    }
}

impl serial::ErrorType for Port {
    type Error = ErrorKind;
}

impl serial::Read for Port {
    fn read(&mut self) -> nb::Result<u8, ErrorKind> {
        self.edit(|line| {
            let byte = line.coming.pop_front().ok_or(nb::Error::WouldBlock)?;
            line.read.extend(byte);
            byte.map_err(nb::Error::Other)
        })
    }
}

impl serial::Write for Port {
    fn write(&mut self, byte: u8) -> nb::Result<(), ErrorKind> {
        self.edit(|line| {
            assert!(line.is_driven, "sent without the line driver on");
            let transmitter = &mut line.transmitter;
            if transmitter.room == 0 {
                return Err(nb::Error::WouldBlock);
            }
            transmitter.room -= 1;
            line.sent.push(byte);
            if transmitter.fails {
                return Err(nb::Error::Other(ErrorKind::Other));
            }
            Ok(())
        })
    }

    fn flush(&mut self) -> nb::Result<(), ErrorKind> {
        self.edit(|line| match line.transmitter {
            Transmitter { fails: true, .. } => Err(nb::Error::Other(ErrorKind::Other)),
            Transmitter {
                is_sending: true, ..
            } => Err(nb::Error::WouldBlock),
            Transmitter { .. } => Ok(()),
        })
    }
}

impl SetBaud for Port {
    /// A script has no baud rates: it times the bytes itself.
    fn set_baud(&mut self, _baud: u32) {}
}

impl digital::ErrorType for Port {
    type Error = Infallible;
}

impl OutputPin for Port {
    fn set_low(&mut self) -> Result<(), Infallible> {
        self.edit(|line| line.is_driven = false);
        Ok(())
    }

    fn set_high(&mut self) -> Result<(), Infallible> {
        self.edit(|line| line.is_driven = true);
        Ok(())
    }
}

/// Status packet of an X servo.
fn x_series(id: u8, error: u8, data: &[u8]) -> Vec<u8> {
    let frame = protocol2::Frame {
        id,
        code: protocol2::frame::STATUS,
        parameters: &[&[error], data].concat(),
    };
    frame.encode::<300>().expect("a short packet").to_vec()
}
