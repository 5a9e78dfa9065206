//! The bus master, between whose polls anything may happen.
//!
//! The input is a script: the master's requests, and before each poll, the port's input,
//! its free room and the time.
//!
//! | first byte, modulo 8 | then            | what happens                         |
//! |----------------------|-----------------|--------------------------------------|
//! | 0, 1                 | n               | n µs pass, or n times 64 µs          |
//! | 2                    |                 | time passes until the master wants it |
//! | 3, 4                 | n, n % 32 bytes | the port receives these              |
//! | 5                    |                 | the port receives its pending echo   |
//! | 6                    | n               | framing, noise or overrun is reported |
//! | 7                    | n               | the transmitter takes n % 32 bytes and no more; it has sent the last bit if n is even; it fails if n is 224 or more |
//!
//! An idle master is asked for something by one byte, modulo 8:
//!
//! | byte | then                        | what is asked                           |
//! |------|-----------------------------|-----------------------------------------|
//! | 0    |                             | stop; the brief one from 128 on         |
//! | 1    | n                           | a ping of joint n % 3                   |
//! | 2    |                             | START; a tick with motors off from 128 on |
//! | 3, 4 | four bytes                  | drive, with a PWM for each joint        |
//! | 5    | id, m, n, n % 32 bytes      | these, answered with m bytes by this id |
//! | 6, 7 | n                           | nothing: Morpheus or stock servos from now on, at the n-th baud rate, prepared if n is 128 or more |

mod line;

use armbridge_servo::master::{Busy, ExpectedReply, Master, Transaction};
use armbridge_servo::morpheus::{Request, ServoId};
use armbridge_servo::port::BAUD_RATES;
use armbridge_servo::protocol1::{BROADCAST, Instruction, register};
use armbridge_servo::serial_bus::SerialBus;
use armbridge_servo::stop::{StopStep, brief_stop_step_for, stop_step_for};
use armbridge_servo::{ControlMode, Firmware, Packet, Pwm, protocol2};
use embedded_hal_nb::serial::ErrorKind;
use line::{Line, Port, Transmitter};

const ERRORS: [ErrorKind; 3] = [ErrorKind::FrameFormat, ErrorKind::Noise, ErrorKind::Overrun];
/// Longest time in µs in which a servo answers a request of the transparent port's client.
const LATENCY_US: u32 = 100;
/// A poll for each step, for each transmission's end, and some to spare: once
/// nothing happens any more, no transaction takes longer.
const POLLS_MAX: usize = 40;

/// Works through a script, lets the master end what it has begun, and counts
/// the answers that it believed.
///
/// # Panics
/// If a transaction does not end, if something else is sent than it stands for
/// or without the line driver on, or if a reply is accepted that no servo sent.
pub fn check(input: &[u8]) -> usize {
    let port = Port::default();
    let mut run = Run {
        master: Master::new(SerialBus::new(port.clone(), port.clone()), ids()),
        port,
        now_us: 0,
        request: None,
        believed: 0,
    };
    let mut script = input.iter().copied();
    while run.step(&mut script).is_some() {}
    run.port
        .edit(|line| line.transmitter = Transmitter::default());
    for _ in 0..POLLS_MAX {
        if run.master.is_idle() {
            return run.believed;
        }
        run.now_us = run.now_us.max(run.master.wake_at_us());
        run.poll();
    }
    panic!("{:?} does not end", run.request);
}

fn ids() -> [ServoId; 2] {
    [1, 2].map(|id| ServoId::new(id).expect("an id"))
}

/// A master at work.
struct Run {
    port: Port,
    master: Master<SerialBus<Port, Port>>,
    now_us: u64,
    /// The transaction under way, its bytes, and the time of its request.
    request: Option<(Transaction, Vec<u8>, u64)>,
    /// Answers so far.
    believed: usize,
}

impl Run {
    /// Performs the script's next step; `None` at its end.
    fn step(&mut self, script: &mut impl Iterator<Item = u8>) -> Option<()> {
        if self.master.is_idle() {
            self.ask(script)?;
            return Some(());
        }
        assert_eq!(self.master.begin(Transaction::Stop, self.now_us), Err(Busy));
        match script.next()? % 8 {
            0 => self.now_us += u64::from(script.next()?),
            1 => self.now_us += 64 * u64::from(script.next()?),
            2 => self.now_us = self.now_us.max(self.master.wake_at_us()),
            3 | 4 => {
                let count = usize::from(script.next()? % 32);
                let bytes = script.take(count).map(Ok);
                self.port.edit(|line| line.coming.extend(bytes));
            }
            5 => self.port.edit(Line::echo),
            6 => {
                let kind = ERRORS[usize::from(script.next()?) % ERRORS.len()];
                self.port.edit(|line| line.coming.push_back(Err(kind)));
            }
            _ => {
                let state = script.next()?;
                self.port.edit(|line| {
                    line.transmitter = Transmitter {
                        room: usize::from(state % 32),
                        is_sending: state % 2 == 1,
                        fails: state >= 224,
                    };
                });
            }
        }
        self.poll();
        Some(())
    }

    /// Makes the script's next request to the master.
    fn ask(&mut self, script: &mut impl Iterator<Item = u8>) -> Option<()> {
        self.port.edit(Line::forget);
        let kind = script.next()?;
        let transaction = match kind % 8 {
            0 if kind >= 128 => Transaction::BriefStop,
            0 => Transaction::Stop,
            1 => Transaction::Ping {
                joint: usize::from(script.next()? % 3),
            },
            2 if kind >= 128 => Transaction::HoldOff,
            2 => Transaction::Start,
            3 => Transaction::Drive([pwm(script)?, pwm(script)?]),
            4 => Transaction::StopWedged {
                joint: usize::from(script.next()? % 2),
                is_side_step: script.next()? % 2 == 0,
            },
            5 => {
                let request = ExpectedReply {
                    id: script.next()?,
                    reply_bytes: script.next()?.into(),
                    latency_us: LATENCY_US,
                };
                let count = usize::from(script.next()? % 32);
                let packet: Vec<u8> = script.take(count).collect();
                assert_eq!(self.master.request(&packet, request, self.now_us), Ok(()));
                self.request = Some((Transaction::Request(request), packet, self.now_us));
                return Some(());
            }
            kind => {
                let firmware = Firmware::ALL[usize::from(kind - 6)];
                let state = script.next()?;
                let baud = BAUD_RATES[usize::from(state) % BAUD_RATES.len()];
                assert_eq!(self.master.set_line(firmware, baud), Ok(()));
                self.master.set_prepared(match state {
                    0..128 => None,
                    128..192 => Some(ControlMode::Pwm),
                    _ => Some(ControlMode::Current),
                });
                return Some(());
            }
        };
        assert_eq!(self.master.begin(transaction, self.now_us), Ok(()));
        let (firmware, is_prepared) = (self.master.firmware(), self.master.is_prepared());
        let sent = expected(transaction, firmware, is_prepared);
        self.request = Some((transaction, sent, self.now_us));
        Some(())
    }

    fn poll(&mut self) {
        let result = self.master.poll(self.now_us);
        assert_eq!(result.is_ok(), self.master.is_idle());
        if let (Ok(outcome), Some((transaction, sent, begun_us))) = (result, &self.request) {
            assert_eq!(outcome.transaction, *transaction);
            assert!(u64::from(outcome.bus_us) <= self.now_us - begun_us);
            let (firmware, reply) = (self.master.firmware(), self.master.reply());
            self.believed += self
                .port
                .edit(|line| line.check(&outcome, sent, firmware, reply));
        }
    }
}

fn pwm(script: &mut impl Iterator<Item = u8>) -> Option<Pwm> {
    let counts = u16::from_le_bytes([script.next()?, script.next()?]);
    Some(Pwm::saturating(counts))
}

/// Bytes of a transaction.
fn expected(transaction: Transaction, firmware: Firmware, is_prepared: bool) -> Vec<u8> {
    let packets: Vec<Packet> = match (transaction, firmware) {
        (Transaction::Stop, _) => {
            let steps = (0..).map_while(|index| stop_step_for(index, firmware, ids()));
            return steps.flat_map(bytes).collect();
        }
        (Transaction::BriefStop, _) => {
            let steps = (0..).map_while(|index| brief_stop_step_for(index, firmware));
            return steps.flat_map(bytes).collect();
        }
        (Transaction::Ping { joint }, _) => {
            let packet = |id: &ServoId| match firmware {
                Firmware::Morpheus => Request::Ping(*id).encode(),
                Firmware::Stock => stock(Instruction::Ping, id.get()),
                Firmware::XSeries => x_series(protocol2::Instruction::Ping, id.get()),
            };
            let off = (firmware == Firmware::XSeries).then(x_torque_off);
            let ping = ids().get(joint).map(packet);
            off.into_iter().chain(ping).collect()
        }
        (Transaction::Start, _) => vec![Request::Start.encode()],
        (Transaction::Drive([a, b]), Firmware::Morpheus) => {
            let [first, second] = ids();
            let drive = Request::Drive([(first, a), (second, b)]);
            vec![drive.encode(), Request::Cycle.encode()]
        }
        (Transaction::Drive(pwm), Firmware::Stock) => {
            let [[a, b], [c, d]] = pwm.map(|pwm| duty(pwm).to_le_bytes());
            let duties = Instruction::SyncWrite {
                address: register::MOVING_SPEED,
                count: 2,
                blocks: &[1, a, b, 2, c, d],
            };
            // To servos in another mode a duty would be something else.
            let duties = is_prepared.then(|| stock(duties, BROADCAST));
            duties.into_iter().chain(positions()).collect()
        }
        (Transaction::HoldOff, Firmware::Stock) => {
            let let_go = Instruction::Write {
                address: register::TORQUE_ENABLE,
                data: &[0],
            };
            let let_go = stock(let_go, BROADCAST);
            let turns = positions().map(|read| [let_go.clone(), read]);
            turns.into_iter().flatten().collect()
        }
        (
            Transaction::StopWedged {
                joint,
                is_side_step,
            },
            Firmware::Morpheus,
        ) => {
            let off = if is_side_step {
                Request::SideStep([ids()[joint]; 2])
            } else {
                Request::Release([ids()[joint]; 2])
            };
            let rest = Packet::from_slice(&[0xFF; 2]).expect("two bytes");
            vec![off.encode(), rest, Request::Cycle.encode()]
        }
        (Transaction::HoldOff, Firmware::Morpheus)
        | (Transaction::StopWedged { .. }, Firmware::Stock) => {
            let off = Transaction::Drive([Pwm::OFF; 2]);
            return expected(off, firmware, is_prepared);
        }
        (
            Transaction::Drive(_) | Transaction::HoldOff | Transaction::StopWedged { .. },
            Firmware::XSeries,
        ) => {
            let pwm = match transaction {
                Transaction::Drive(pwm) => Some(pwm),
                Transaction::StopWedged { .. } => Some([Pwm::OFF; 2]),
                _ => None,
            };
            let first = match pwm.filter(|_| is_prepared) {
                Some(pwm) => {
                    let [[a, b], [c, d]] = pwm.map(|pwm| x_duty(pwm).to_le_bytes());
                    let goals = protocol2::Instruction::SyncWrite {
                        address: 100,
                        count: 2,
                        blocks: &[1, a, b, 2, c, d],
                    };
                    x_series(goals, BROADCAST)
                }
                // To servos in another mode a goal would be something else.
                None => x_torque_off(),
            };
            let read = protocol2::Instruction::FastSyncRead {
                address: 132,
                count: 4,
                ids: &[1, 2],
            };
            vec![first, x_series(read, BROADCAST)]
        }
        // Known where it is asked for.
        (Transaction::Request(_), _) => Vec::new(),
    };
    packets.concat()
}

fn x_series(instruction: protocol2::Instruction<'_>, id: u8) -> Packet {
    instruction.encode(id).expect("a short packet")
}

fn x_torque_off() -> Packet {
    let off = protocol2::Instruction::Write {
        address: 64,
        data: &[0],
    };
    x_series(off, BROADCAST)
}

/// 885 is full duty.
fn x_duty(pwm: Pwm) -> i16 {
    ((f64::from(pwm.counts()) - 1000.0) * 0.885).round() as i16
}

/// Readings of stock servos' positions.
fn positions() -> [Packet; 2] {
    let position = Instruction::Read {
        address: register::PRESENT_POSITION,
        count: 2,
    };
    [1, 2].map(|id| stock(position, id))
}

/// Bytes of a step of the stop sequence.
fn bytes(step: StopStep) -> Vec<u8> {
    match step {
        StopStep::Send(packet) => packet.to_vec(),
        StopStep::Repeat(byte, count) => vec![byte; count.into()],
        StopStep::Pause { .. } => Vec::new(),
    }
}

fn stock(instruction: Instruction, id: u8) -> Packet {
    instruction.encode(id).expect("a short packet")
}

/// Thousandths of full drive as 1023rds, and the sign in bit 10.
fn duty(pwm: Pwm) -> u16 {
    let thousandths = f64::from(pwm.counts()) - 1000.0;
    let magnitude = (thousandths.abs() * 1023.0 / 1000.0).round() as u16;
    magnitude | u16::from(thousandths < 0.0) << 10
}
