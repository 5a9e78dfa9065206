//! Client of the transparent port that drives the motors: it repeats packets, sends
//! others once, changes its rate, hangs and closes its port, on request or at a time.

use std::cell::RefCell;
use std::collections::VecDeque;
use std::rc::Rc;

use armbridge_board::bridge::transparent_port::ClientLine;
use armbridge_servo::protocol1::{BROADCAST, Instruction};
use armbridge_servo::protocol2::model::OperatingMode;
use armbridge_servo::protocol2::register as x;
use armbridge_servo::{Firmware, morpheus, protocol2};

use crate::cosim::PortClient;

/// Its address on the bus of Morpheus servos.
const ADDRESS: u8 = 0xFE;
/// The servos' ids.
const IDS: [u8; 2] = [1, 2];
/// PWM at which it drives Morpheus servos: half of what there is.
const PWM: u16 = 1500;
/// Moving speed at which it drives stock servos in wheel mode: the same duty.
const SPEED: u16 = 512;
/// Goal of stock servos in joint mode, in counts: beyond an obstacle that is ten from
/// the middle.
const GOAL: u16 = 540;
/// Goal PWM at which it drives X servos: half of what there is.
const DUTY: u16 = 442;

/// Bytes that are written periodically.
#[derive(Debug)]
struct Stream {
    bytes: Vec<u8>,
    period_us: u64,
    next_us: u64,
}

/// Action of a client at a time.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum ClientStep {
    /// Opens the port, or sets its rate.
    Open(u32),
    /// Writes these bytes once.
    Send(Vec<u8>),
    /// Writes these bytes periodically, with this period in µs.
    Stream(Vec<u8>, u64),
    /// Stops writing; the port stays open.
    Hang,
}

#[derive(Debug, Default)]
struct State {
    line: ClientLine,
    /// Steps to come with their times in µs, earliest first.
    script: VecDeque<(u64, ClientStep)>,
    once: Vec<u8>,
    streams: Vec<Stream>,
    now_us: u64,
    /// Time of the last write in µs.
    written_us: u64,
}

impl State {
    fn take(&mut self, step: ClientStep) {
        match step {
            ClientStep::Open(baud) => {
                self.line = ClientLine {
                    is_open: true,
                    baud,
                }
            }
            ClientStep::Send(bytes) => self.once.extend(bytes),
            ClientStep::Stream(bytes, period_us) => self.streams.push(Stream {
                bytes,
                period_us,
                next_us: self.now_us,
            }),
            ClientStep::Hang => self.streams.clear(),
        }
    }
}

/// A handle on the client: one for the run, one for its user.
#[derive(Clone, Debug, Default)]
pub struct ClientHandle(Rc<RefCell<State>>);

impl ClientHandle {
    /// Opens the port, or sets its rate.
    pub fn open(&self, baud: u32) {
        self.0.borrow_mut().take(ClientStep::Open(baud));
    }

    /// Writes these bytes once.
    pub fn send(&self, bytes: &[u8]) {
        self.0.borrow_mut().take(ClientStep::Send(bytes.to_vec()));
    }

    /// Writes these bytes every `period_us` from now on, beside its other streams.
    pub fn stream(&self, bytes: Vec<u8>, period_us: u64) {
        let step = ClientStep::Stream(bytes, period_us);
        self.0.borrow_mut().take(step);
    }

    /// Stops writing; the port stays open.
    pub fn hang(&self) {
        self.0.borrow_mut().take(ClientStep::Hang);
    }

    /// Replaces the steps to come: these, with their times in µs, earliest first.
    pub fn schedule(&self, script: impl IntoIterator<Item = (u64, ClientStep)>) {
        self.0.borrow_mut().script = script.into_iter().collect();
    }

    /// Stops writing and closes the port.
    pub fn close(&self) {
        self.schedule([]);
        self.hang();
        self.0.borrow_mut().line = ClientLine::default();
    }

    /// Time of its last write in µs.
    pub fn written_us(&self) -> u64 {
        self.0.borrow().written_us
    }
}

impl PortClient for ClientHandle {
    fn line(&self) -> ClientLine {
        self.0.borrow().line
    }

    fn transmit(&mut self, now_us: u64) -> Vec<u8> {
        let state = &mut *self.0.borrow_mut();
        state.now_us = now_us;
        while state
            .script
            .front()
            .is_some_and(|(at_us, _)| *at_us <= now_us)
            && let Some((_, step)) = state.script.pop_front()
        {
            state.take(step);
        }
        let mut bytes = std::mem::take(&mut state.once);
        for stream in &mut state.streams {
            if stream.next_us <= now_us {
                stream.next_us = now_us + stream.period_us;
                bytes.extend_from_slice(&stream.bytes);
            }
        }
        if !bytes.is_empty() {
            state.written_us = now_us;
        }
        bytes
    }

    fn receive(&mut self, _now_us: u64, _bytes: &[u8]) {}

    fn wake_at_us(&self) -> u64 {
        let state = self.0.borrow();
        if !state.once.is_empty() {
            return 0;
        }
        let times_us = state.streams.iter().map(|stream| stream.next_us);
        let script_us = state.script.front().map(|(at_us, _)| *at_us);
        times_us.chain(script_us).min().unwrap_or(u64::MAX)
    }
}

/// Method by which a client drives the motors.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Method {
    /// Morpheus servos, by PWM.
    Pwm,
    /// Stock servos in wheel mode, by moving speeds.
    Speeds,
    /// Stock servos in joint mode, by goals, each of which enables torque.
    Goals,
    /// X servos in PWM control mode, by goals.
    Duties,
}

impl Method {
    /// Every method with AX-12A servos.
    pub const AX12A: [Self; 3] = [Self::Pwm, Self::Speeds, Self::Goals];

    /// Firmware of the servos.
    pub fn firmware(self) -> Firmware {
        match self {
            Self::Pwm => Firmware::Morpheus,
            Self::Speeds | Self::Goals => Firmware::Stock,
            Self::Duties => Firmware::XSeries,
        }
    }

    /// Packets that drive both motors.
    pub fn packets(self) -> Vec<u8> {
        match self {
            Self::Pwm => IDS
                .map(|id| self.write(id, 0x10, &PWM.to_le_bytes()))
                .concat(),
            Self::Speeds => sync_write(32, SPEED),
            Self::Goals => sync_write(30, GOAL),
            Self::Duties => IDS
                .map(|id| self.write(id, x::GOAL_PWM, &DUTY.to_le_bytes()))
                .concat(),
        }
    }

    /// Packets that make servos ready for this method: wheel mode, torque enabled.
    pub fn preparation(self) -> Vec<Vec<u8>> {
        match self {
            Self::Speeds => {
                let wheel = IDS.map(|id| self.write(id, 6, &[0; 4]));
                let enable = IDS.map(|id| self.write(id, 24, &[1]));
                wheel.into_iter().chain(enable).collect()
            }
            Self::Duties => {
                let mode = OperatingMode::Pwm.code();
                // A change of the mode has left the goal at its largest.
                let writes: [(u16, &[u8]); 4] = [
                    (x::TORQUE_ENABLE, &[0]),
                    (x::OPERATING_MODE, &[mode]),
                    (x::GOAL_PWM, &[0, 0]),
                    (x::TORQUE_ENABLE, &[1]),
                ];
                let packets =
                    writes.map(|(address, data)| IDS.map(|id| self.write(id, address, data)));
                packets.concat()
            }
            Self::Pwm | Self::Goals => Vec::new(),
        }
    }

    /// Packets that set the rate of a servo. A stock one takes none while its torque is
    /// enabled.
    pub fn rate(self, servo: usize, register: u8) -> Vec<u8> {
        match self.firmware() {
            Firmware::Morpheus => self.write(IDS[servo], 0x0A, &[register]),
            Firmware::Stock => [(24, 0), (4, register)]
                .map(|(address, value)| self.write(IDS[servo], address, &[value]))
                .concat(),
            Firmware::XSeries => [(x::TORQUE_ENABLE, 0), (x::BAUD_RATE, register)]
                .map(|(address, value)| self.write(IDS[servo], address, &[value]))
                .concat(),
        }
    }

    /// Packets that make a servo ready again at its new rate.
    pub fn again(self, servo: usize) -> Vec<u8> {
        match self {
            Self::Speeds => self.write(IDS[servo], 24, &[1]),
            Self::Duties => self.write(IDS[servo], x::TORQUE_ENABLE, &[1]),
            Self::Pwm | Self::Goals => Vec::new(),
        }
    }

    /// Packet that asks the first servo for its position.
    pub fn question(self) -> Vec<u8> {
        let read = Instruction::Read {
            address: 36,
            count: 2,
        };
        match self.firmware() {
            Firmware::Morpheus => morpheus(IDS[0], &[2, 0x0B, 2]),
            Firmware::Stock => stock(IDS[0], &read),
            Firmware::XSeries => x_series(
                IDS[0],
                &protocol2::Instruction::Read {
                    address: x::PRESENT_POSITION,
                    count: 4,
                },
            ),
        }
    }

    /// Packet that writes a servo's registers from `address` on.
    fn write(self, id: u8, address: u16, data: &[u8]) -> Vec<u8> {
        match self.firmware() {
            Firmware::Morpheus => morpheus(id, &[&[3, address as u8], data].concat()),
            Firmware::Stock => stock(id, &Instruction::Write { address, data }),
            Firmware::XSeries => x_series(id, &protocol2::Instruction::Write { address, data }),
        }
    }
}

/// Packet that writes a register of two bytes of both stock servos.
fn sync_write(address: u16, value: u16) -> Vec<u8> {
    let [low, high] = value.to_le_bytes();
    let write = Instruction::SyncWrite {
        address,
        count: 2,
        blocks: &IDS.map(|id| [id, low, high]).concat(),
    };
    stock(BROADCAST, &write)
}

fn morpheus(id: u8, data: &[u8]) -> Vec<u8> {
    let frame = morpheus::Frame {
        destination: id,
        source: ADDRESS,
        data,
    };
    frame.encode::<64>().expect("a short packet").to_vec()
}

fn stock(id: u8, instruction: &Instruction) -> Vec<u8> {
    let packet = instruction.encode::<64>(id);
    packet.expect("a short packet").to_vec()
}

fn x_series(id: u8, instruction: &protocol2::Instruction) -> Vec<u8> {
    let packet = instruction.encode::<64>(id);
    packet.expect("a short packet").to_vec()
}
