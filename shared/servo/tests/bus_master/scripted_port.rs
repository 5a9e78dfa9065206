//! A serial port that keeps time, with scripted servos, and a master on it.

use std::cell::RefCell;
use std::collections::VecDeque;
use std::convert::Infallible;
use std::rc::Rc;

use armbridge_servo::Pwm;
use armbridge_servo::master::{Busy, Master, Outcome, Transaction};
use armbridge_servo::morpheus::ServoId;
use armbridge_servo::port::SetBaud;
use armbridge_servo::serial_bus::SerialBus;
use embedded_hal::digital::{ErrorType, OutputPin};
use embedded_hal_nb::serial;

/// Positions of servos 1 and 2, as recorded from the firmware.
pub(crate) const REPLY_1: [u8; 7] = [0xAA, 4, 0xFE, 1, 1, 0xF4, 3];
pub(crate) const REPLY_2: [u8; 7] = [0xAA, 4, 0xFE, 2, 1, 0xF5, 1];

#[derive(Default)]
pub(crate) struct Line {
    pub(crate) now_us: u64,
    pub(crate) sent_until_us: u64,
    pub(crate) sent: Vec<u8>,
    /// Bytes on their way to the receiver, and when they are there.
    pub(crate) coming: VecDeque<(u64, Result<u8, serial::ErrorKind>)>,
    pub(crate) echo: bool,
    pub(crate) sending: bool,
    /// Bytes that were sent without the line driver on.
    pub(crate) undriven: usize,
}

#[derive(Clone, Default)]
pub(crate) struct Port(pub(crate) Rc<RefCell<Line>>);

impl serial::ErrorType for Port {
    type Error = serial::ErrorKind;
}

impl serial::Read for Port {
    fn read(&mut self) -> nb::Result<u8, serial::ErrorKind> {
        let mut line = self.0.borrow_mut();
        match line.coming.front() {
            Some((at_us, _)) if *at_us <= line.now_us => {
                line.coming.pop_front().unwrap().1.map_err(nb::Error::Other)
            }
            _ => Err(nb::Error::WouldBlock),
        }
    }
}

impl serial::Write for Port {
    fn write(&mut self, byte: u8) -> nb::Result<(), serial::ErrorKind> {
        let mut line = self.0.borrow_mut();
        line.sent_until_us = line.sent_until_us.max(line.now_us) + 10;
        line.sent.push(byte);
        line.undriven += usize::from(!line.sending);
        if line.echo {
            let at_us = line.sent_until_us;
            line.coming.push_back((at_us, Ok(byte)));
        }
        Ok(())
    }

    fn flush(&mut self) -> nb::Result<(), serial::ErrorKind> {
        let line = self.0.borrow();
        if line.now_us < line.sent_until_us {
            Err(nb::Error::WouldBlock)
        } else {
            Ok(())
        }
    }
}

impl SetBaud for Port {
    fn set_baud(&mut self, baud: u32) {
        assert_eq!(baud, 1_000_000);
    }
}

impl ErrorType for Port {
    type Error = Infallible;
}

impl OutputPin for Port {
    fn set_low(&mut self) -> Result<(), Infallible> {
        self.0.borrow_mut().sending = false;
        Ok(())
    }

    fn set_high(&mut self) -> Result<(), Infallible> {
        self.0.borrow_mut().sending = true;
        Ok(())
    }
}

/// Bytes that servos send, or errors of the receiver, and when, in µs.
pub(crate) type Script = Vec<(u64, Result<u8, serial::ErrorKind>)>;

pub(crate) fn bytes(after_us: u64, bytes: &[u8]) -> Script {
    (1..)
        .zip(bytes)
        .map(|(i, byte)| (after_us + 10 * i, Ok(*byte)))
        .collect()
}

pub(crate) struct Test {
    pub(crate) port: Port,
    pub(crate) master: Master<SerialBus<Port, Port>>,
}

impl Test {
    /// A master that has run its first stop sequence, as after boot.
    pub(crate) fn new(echo: bool) -> Self {
        let port = Port::default();
        port.0.borrow_mut().echo = echo;
        let ids = [1, 2].map(|id| ServoId::new(id).unwrap());
        let mut test = Self {
            master: Master::new(SerialBus::new(port.clone(), port.clone()), ids),
            port,
        };
        test.run(Transaction::Stop, Vec::new());
        test
    }

    /// Runs a transaction; `script` arrives after the last request of it.
    pub(crate) fn run(&mut self, transaction: Transaction, script: Script) -> Outcome {
        let now_us = self.port.0.borrow().now_us;
        self.port.0.borrow_mut().sent.clear();
        self.master.begin(transaction, now_us).unwrap();
        assert_eq!(self.master.begin(transaction, now_us), Err(Busy));
        let mut script = Some(script);
        for _ in 0..100_000 {
            let now_us = self.port.0.borrow().now_us;
            if let Ok(outcome) = self.master.poll(now_us) {
                assert!(self.master.is_idle() && !self.port.0.borrow().sending);
                return outcome;
            }
            // The driver is off again: the request is out, servos may speak.
            let mut line = self.port.0.borrow_mut();
            if !line.sending && !line.sent.is_empty() {
                let turned_us = line.now_us;
                for (after_us, byte) in script.take().into_iter().flatten() {
                    line.coming.push_back((turned_us + after_us, byte));
                }
            }
            line.now_us += 1;
        }
        panic!("{transaction:?} did not end");
    }

    pub(crate) fn drive(&mut self, script: Script) -> Outcome {
        self.run(
            Transaction::Drive([Pwm::OFF, Pwm::new(1500).unwrap()]),
            script,
        )
    }
}

pub(crate) fn chain() -> Script {
    [bytes(60, &REPLY_1), bytes(180, &REPLY_2)].concat()
}
