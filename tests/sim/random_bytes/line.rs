//! A half-duplex line in virtual time: the master's port, and what comes in.

use std::cell::{Ref, RefCell};
use std::collections::VecDeque;
use std::convert::Infallible;
use std::rc::Rc;

use armbridge_servo::BYTE_US;
use armbridge_servo::morpheus::{HEADER, MASTER, checksum};
use armbridge_servo::port::SetBaud;
use embedded_hal::digital::{self, OutputPin};
use embedded_hal_nb::serial::{self, ErrorKind};

/// A received byte, or an error.
pub(crate) type Heard = Result<u8, ErrorKind>;

#[derive(Default)]
pub(crate) struct Line {
    pub(crate) now_us: u64,
    /// As last set.
    pub(crate) baud: u32,
    sent_until_us: u64,
    /// Bytes that the master has sent.
    pub(crate) sent: Vec<u8>,
    /// Bytes sent without the line driver on.
    pub(crate) undriven: usize,
    /// On their way to the master, and when they are there.
    coming: VecDeque<(u64, Heard)>,
    /// Bytes and errors that the master has read.
    pub(crate) read: Vec<Heard>,
    pub(crate) is_driven: bool,
    pub(crate) echo: bool,
    /// Bytes that fit into the transmitter.
    pub(crate) depth: u64,
    /// The receiver reports an overrun whenever it is asked.
    pub(crate) is_babbling: bool,
}

/// A handle on the line: serial port and direction pin.
#[derive(Clone, Default)]
pub(crate) struct Port(Rc<RefCell<Line>>);

impl Port {
    pub(crate) fn new(echo: bool, depth: u64) -> Self {
        let port = Self::default();
        port.edit(|line| (line.echo, line.depth) = (echo, depth));
        port
    }

    pub(crate) fn line(&self) -> Ref<'_, Line> {
        self.0.borrow()
    }

    pub(crate) fn edit<R>(&self, change: impl FnOnce(&mut Line) -> R) -> R {
        change(&mut self.0.borrow_mut())
    }
}

impl Line {
    /// These arrive so long after now.
    pub(crate) fn expect(&mut self, script: impl IntoIterator<Item = (u64, Heard)>) {
        let now_us = self.now_us;
        let coming = script
            .into_iter()
            .map(|(us, received)| (now_us + us, received));
        self.coming.extend(coming);
        self.coming
            .make_contiguous()
            .sort_by_key(|(at_us, _)| *at_us);
    }

    /// When the next byte arrives.
    pub(crate) fn next_us(&self) -> Option<u64> {
        self.coming.front().map(|(at_us, _)| *at_us)
    }

    /// Nothing is on its way any more, and nothing of before is remembered.
    pub(crate) fn clear(&mut self) {
        self.coming.clear();
        self.sent.clear();
        self.read.clear();
    }
}

impl serial::ErrorType for Port {
    type Error = ErrorKind;
}

impl serial::Read for Port {
    fn read(&mut self) -> nb::Result<u8, ErrorKind> {
        self.edit(|line| {
            if line.is_babbling {
                return Err(nb::Error::Other(ErrorKind::Overrun));
            }
            match line.coming.front() {
                Some((at_us, received)) if *at_us <= line.now_us => {
                    let received = *received;
                    line.coming.pop_front();
                    line.read.push(received);
                    received.map_err(nb::Error::Other)
                }
                _ => Err(nb::Error::WouldBlock),
            }
        })
    }
}

impl serial::Write for Port {
    fn write(&mut self, byte: u8) -> nb::Result<(), ErrorKind> {
        self.edit(|line| {
            let free_us = line.sent_until_us.max(line.now_us);
            if free_us - line.now_us >= line.depth * BYTE_US {
                return Err(nb::Error::WouldBlock);
            }
            line.sent_until_us = free_us + BYTE_US;
            line.sent.push(byte);
            line.undriven += usize::from(!line.is_driven);
            if line.echo {
                let after_us = line.sent_until_us - line.now_us;
                line.expect([(after_us, Ok(byte))]);
            }
            Ok(())
        })
    }

    fn flush(&mut self) -> nb::Result<(), ErrorKind> {
        if self.line().now_us < self.line().sent_until_us {
            Err(nb::Error::WouldBlock)
        } else {
            Ok(())
        }
    }
}

impl SetBaud for Port {
    /// A script does not know of speeds: bytes take as long as ever. Those of another speed
    /// cannot be read.
    fn set_baud(&mut self, baud: u32) {
        self.edit(|line| {
            if std::mem::replace(&mut line.baud, baud) != baud {
                line.coming.clear();
            }
        });
    }
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

/// A servo's answer.
pub(crate) fn reply(id: u8, data: &[u8]) -> Vec<u8> {
    let mut packet = vec![HEADER, data.len() as u8 + 2, MASTER, id];
    packet.extend(data);
    packet.push(checksum(&packet[1..]));
    packet
}

/// The answer to a position request.
pub(crate) fn position(id: u8, counts: u16) -> Vec<u8> {
    reply(id, &counts.to_be_bytes())
}

/// Bytes back to back, the first complete after `after_us`.
pub(crate) fn back_to_back(after_us: u64, bytes: &[u8]) -> Vec<(u64, Heard)> {
    let times = (after_us..).step_by(BYTE_US as usize);
    times.zip(bytes.iter().map(|byte| Ok(*byte))).collect()
}
