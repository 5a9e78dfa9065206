//! A line with a scripted reply, at once, and a stock
//! servo on it that is just good enough to be read and written.

use std::io;
use std::time::{Duration, Instant};

use armbridge_client::servo_bus::{BusMaster, Line};
use armbridge_servo::Alarms;
use armbridge_servo::protocol1::frame::FRAME_MAX;
use armbridge_servo::protocol1::{Frame, Instruction, Parser, Status};

/// 210 bytes that no servo answers.
pub(crate) const FLUSH: [u8; 210] = [0xFF; 210];

/// Servos on the bus: the reply to these bytes at this rate.
pub(crate) trait Bus {
    fn answer(&mut self, sent: &[u8], baud: u32) -> Vec<u8>;
}

impl<F: FnMut(&[u8]) -> Vec<u8>> Bus for F {
    fn answer(&mut self, sent: &[u8], _baud: u32) -> Vec<u8> {
        self(sent)
    }
}

/// A line to it.
pub(crate) struct FakeLine<B> {
    pub(crate) bus: B,
    pub(crate) echoes: bool,
    pub(crate) baud: u32,
    /// Delay of everything after the first flush.
    pub(crate) delay: Duration,
    heard_from: Instant,
    /// Everything that was sent, packet by packet.
    pub(crate) sent: Vec<Vec<u8>>,
    pending: Vec<u8>,
}

impl<B: Bus> FakeLine<B> {
    pub(crate) fn new(bus: B) -> Self {
        Self {
            bus,
            echoes: false,
            baud: 1_000_000,
            delay: Duration::ZERO,
            heard_from: Instant::now(),
            sent: Vec::new(),
            pending: Vec::new(),
        }
    }
}

impl<B: Bus> Line for &mut FakeLine<B> {
    fn send(&mut self, bytes: &[u8]) -> io::Result<()> {
        if !self.sent.is_empty() {
            self.heard_from = Instant::now() + self.delay;
        }
        self.sent.push(bytes.to_vec());
        if self.echoes {
            self.pending.extend(bytes);
        }
        let answer = self.bus.answer(bytes, self.baud);
        self.pending.extend(answer);
        Ok(())
    }

    fn receive(&mut self, until: Instant) -> io::Result<Vec<u8>> {
        let ready = if self.pending.is_empty() {
            until
        } else {
            self.heard_from
        };
        std::thread::sleep(ready.min(until).saturating_duration_since(Instant::now()));
        if ready > until {
            return Ok(Vec::new());
        }
        Ok(std::mem::take(&mut self.pending))
    }

    fn set_baud(&mut self, baud: u32) -> io::Result<bool> {
        self.baud = baud;
        Ok(true)
    }

    fn baud(&self) -> Option<u32> {
        Some(self.baud)
    }

    fn latency(&self) -> Duration {
        Duration::ZERO
    }
}

/// A client on it.
pub(crate) fn client<B: Bus>(line: &mut FakeLine<B>) -> BusMaster<&mut FakeLine<B>> {
    BusMaster::new(line, Duration::ZERO).unwrap()
}

/// A stock servo: 50 bytes, of which the EEPROM can be locked.
pub(crate) struct Stock {
    pub(crate) memory: [u8; 50],
    /// Registers that do not take what is written.
    pub(crate) stubborn: Vec<u16>,
}

impl Stock {
    pub(crate) fn new(id: u8) -> Self {
        let mut memory = [0; 50];
        memory[0] = 12;
        memory[2] = 24;
        memory[3] = id;
        memory[4] = 1;
        // Answers everything.
        memory[16] = 2;
        memory[42] = 111;
        memory[43] = 31;
        Self {
            memory,
            stubborn: Vec::new(),
        }
    }

    fn status(&self, parameters: &[u8]) -> Vec<u8> {
        let status = Status {
            id: self.memory[3],
            alarms: Alarms::NONE,
            parameters,
        };
        status.encode::<FRAME_MAX>().unwrap().to_vec()
    }
}

impl Bus for Stock {
    fn answer(&mut self, sent: &[u8], baud: u32) -> Vec<u8> {
        let own = 2_000_000.0 / (f64::from(self.memory[4]) + 1.0);
        if (own / f64::from(baud) - 1.0).abs() > 0.03 {
            return Vec::new();
        }
        let mut parser = Parser::<FRAME_MAX>::new();
        let mut last = None;
        for byte in sent {
            last = parser.push(*byte).and_then(|found| {
                let frame: Frame = found.ok()?;
                (frame.id == self.memory[3]).then_some(())?;
                Some((frame.code, frame.parameters.to_vec()))
            });
        }
        let Some((code, parameters)) = last else {
            return Vec::new();
        };
        let frame = Frame {
            id: self.memory[3],
            code,
            parameters: &parameters,
        };
        let level = self.memory[16];
        match Instruction::decode(&frame).unwrap() {
            Instruction::Ping => self.status(&[]),
            Instruction::Read { address, count } if level >= 1 => {
                let from = usize::from(address);
                self.status(&self.memory[from..from + usize::from(count)])
            }
            Instruction::Write { address, data } => {
                // The status still comes from the old id, at the old level.
                let status = self.status(&[]);
                let is_locked = self.memory[47] == 1 && address < 24;
                if !is_locked && !self.stubborn.contains(&address) {
                    let from = usize::from(address);
                    self.memory[from..from + data.len()].copy_from_slice(data);
                }
                if level >= 2 { status } else { Vec::new() }
            }
            _ => Vec::new(),
        }
    }
}

/// Several on one bus.
impl Bus for Vec<Stock> {
    fn answer(&mut self, sent: &[u8], baud: u32) -> Vec<u8> {
        self.iter_mut()
            .flat_map(|servo| servo.answer(sent, baud))
            .collect()
    }
}
