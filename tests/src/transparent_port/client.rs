//! A client of the transparent port that asks one thing after the other, as
//! fast as it is answered.

use std::cell::RefCell;
use std::rc::Rc;

use armbridge_board::bridge::transparent_port::ClientLine;
use armbridge_client::servo_table::{AX12A, MORPHEUS, X_SERIES};
use armbridge_servo::protocol1::{BROADCAST, Instruction, Status, frame};
use armbridge_servo::{Alarms, Firmware, morpheus, protocol2};
use armbridge_sim::cosim::PortClient;

/// Time-out of a client's answer in µs: that of the vendor's SDK on a serial port.
const PATIENCE_US: u64 = 34_000;
/// Wait where it expects none.
const SILENCE_US: u64 = 2_000;

/// Expected reply.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Expected {
    /// This number of data bytes from the servo of this id, without alarm.
    Data(u8, usize),
    /// "I will not", in the name of the servo of this id.
    Refusal(u8),
    /// This number of bytes, with any contents.
    Bytes(usize),
    /// Nothing.
    Silence,
}

/// One thing to ask.
#[derive(Clone, Debug)]
pub struct Question {
    /// Its bytes.
    pub bytes: Vec<u8>,
    /// The answer to it.
    pub expected: Expected,
}

/// Results of the client's requests.
#[derive(Debug, Default)]
pub struct Tally {
    /// Questions.
    pub requests: usize,
    /// Questions answered.
    pub answered: usize,
    /// Questions refused in words.
    pub refused: usize,
    /// Questions without an answer.
    pub silent: usize,
    /// Unexpected replies, in words.
    pub wrong: Vec<String>,
    /// Longest wait for an answer in µs.
    pub slowest_us: u64,
    /// All bytes that ever came.
    pub received: Vec<u8>,
}

#[derive(Debug)]
struct State {
    questions: Vec<Question>,
    next: usize,
    /// When the question under way was asked.
    asked_us: Option<u64>,
    next_us: u64,
    ends_us: u64,
    answer: Vec<u8>,
    tally: Tally,
}

/// A handle on the client: one for the run, one for the test.
#[derive(Clone, Debug)]
pub struct Hammer(Rc<RefCell<State>>);

impl Hammer {
    /// Asks these, over and over, between these times in µs.
    pub fn new(questions: Vec<Question>, from_us: u64, ends_us: u64) -> Self {
        Self(Rc::new(RefCell::new(State {
            questions,
            next: 0,
            asked_us: None,
            next_us: from_us,
            ends_us,
            answer: Vec::new(),
            tally: Tally::default(),
        })))
    }

    /// Results so far.
    pub fn tally(&self) -> Tally {
        std::mem::take(&mut self.0.borrow_mut().tally)
    }
}

impl State {
    fn question(&self) -> &Question {
        &self.questions[self.next % self.questions.len()]
    }

    /// The question under way is over.
    fn settle(&mut self, now_us: u64) {
        let question = self.question().clone();
        let data = reply(&self.answer);
        let verdict = match (question.expected, &data) {
            (Expected::Data(id, count), Some((from, 0, data)))
                if *from == id && data.len() == count =>
            {
                self.tally.answered += 1;
                None
            }
            (Expected::Refusal(id), Some((from, error, data)))
                if *from == id && (*error == Alarms::INSTRUCTION.bits() || data == &[8]) =>
            {
                self.tally.refused += 1;
                None
            }
            (Expected::Bytes(count), _) if self.answer.len() == count => {
                self.tally.answered += 1;
                None
            }
            (Expected::Silence, None) if self.answer.is_empty() => {
                self.tally.silent += 1;
                None
            }
            _ => Some(format!("{question:02x?} was answered {:02x?}", self.answer)),
        };
        self.tally.wrong.extend(verdict);
        let asked_us = self.asked_us.take().unwrap_or(now_us);
        if question.expected != Expected::Silence {
            self.tally.slowest_us = self.tally.slowest_us.max(now_us - asked_us);
        }
        self.next += 1;
        self.next_us = now_us;
        self.answer.clear();
    }
}

/// Id, error byte and data of a reply; `None` if it is no packet.
fn reply(bytes: &[u8]) -> Option<(u8, u8, Vec<u8>)> {
    let mut stock = frame::Parser::<{ frame::FRAME_MAX }>::new();
    let mut morpheus = morpheus::frame::Parser::<{ morpheus::frame::FRAME_MAX }>::new();
    let mut x_series = protocol2::Parser::<260>::new();
    bytes.iter().find_map(|byte| {
        if let Some(Ok(found)) = stock.push(*byte) {
            let status = Status::decode(&found)?;
            return Some((status.id, status.alarms.bits(), status.parameters.to_vec()));
        }
        if let Some(Ok(found)) = x_series.push(*byte) {
            let status = protocol2::Status::decode(&found)?;
            let error = match status.error {
                None => 0,
                Some(_) => Alarms::INSTRUCTION.bits(),
            };
            return Some((status.id, error, status.parameters.to_vec()));
        }
        let Some(Ok(found)) = morpheus.push(*byte) else {
            return None;
        };
        Some((found.source, 0, found.data.to_vec()))
    })
}

impl PortClient for Hammer {
    fn line(&self) -> ClientLine {
        ClientLine {
            is_open: true,
            baud: 0,
        }
    }

    fn transmit(&mut self, now_us: u64) -> Vec<u8> {
        let state = &mut *self.0.borrow_mut();
        if state.asked_us.is_some() && now_us >= state.next_us {
            state.settle(now_us);
        }
        if state.asked_us.is_some() || now_us < state.next_us || now_us >= state.ends_us {
            return Vec::new();
        }
        state.asked_us = Some(now_us);
        state.tally.requests += 1;
        let question = state.question().clone();
        let wait_us = match question.expected {
            Expected::Silence => SILENCE_US,
            Expected::Data(..) | Expected::Refusal(_) | Expected::Bytes(_) => PATIENCE_US,
        };
        state.next_us = now_us + wait_us;
        question.bytes
    }

    fn receive(&mut self, now_us: u64, bytes: &[u8]) {
        let state = &mut *self.0.borrow_mut();
        state.tally.received.extend(bytes);
        if state.asked_us.is_none() {
            if !bytes.is_empty() {
                state.tally.wrong.push(format!("{bytes:02x?} unasked"));
            }
            return;
        }
        state.answer.extend(bytes);
        let is_whole = match state.question().expected {
            Expected::Silence => false,
            Expected::Bytes(count) => state.answer.len() >= count,
            Expected::Data(..) | Expected::Refusal(_) => reply(&state.answer).is_some(),
        };
        if is_whole {
            state.settle(now_us);
        }
    }

    fn wake_at_us(&self) -> u64 {
        let state = self.0.borrow();
        if state.asked_us.is_none() && state.next_us >= state.ends_us {
            u64::MAX
        } else {
            state.next_us
        }
    }
}

/// Every request of a client to servos 1 and 2 that is answered, and every one that is
/// refused, while a control loop runs.
pub fn curious(firmware: Firmware) -> Vec<Question> {
    let mut questions = Vec::new();
    for id in [1, 2] {
        match firmware {
            Firmware::Stock => curious_stock(id, &mut questions),
            Firmware::XSeries => curious_x(id, &mut questions),
            Firmware::Morpheus => curious_morpheus(id, &mut questions),
        }
    }
    questions
}

/// A packet of Protocol 1.0.
pub fn stock(id: u8, instruction: &Instruction) -> Vec<u8> {
    instruction.encode::<64>(id).unwrap().to_vec()
}

fn curious_stock(id: u8, questions: &mut Vec<Question>) {
    let mut ask = |instruction: Instruction, expected| {
        questions.push(Question {
            bytes: stock(id, &instruction),
            expected,
        });
    };
    ask(Instruction::Ping, Expected::Data(id, 0));
    for register in AX12A.registers {
        let count = register.size.bytes();
        let read = Instruction::Read {
            address: register.address,
            count,
        };
        ask(read, Expected::Data(id, count.into()));
    }
    let whole = Instruction::Read {
        address: 0,
        count: AX12A.size,
    };
    ask(whole, Expected::Data(id, AX12A.size.into()));
    let write = |address, data| Instruction::Write { address, data };
    ask(write(25, &[1]), Expected::Data(id, 0));
    // Move it, rename it, slow it down, switch it off.
    ask(write(30, &[0, 2]), Expected::Refusal(id));
    ask(write(3, &[9]), Expected::Refusal(id));
    ask(write(4, &[34]), Expected::Refusal(id));
    ask(write(24, &[0]), Expected::Refusal(id));
    ask(Instruction::Action, Expected::Refusal(id));
    ask(Instruction::FactoryReset, Expected::Refusal(id));
    let push = Instruction::SyncWrite {
        address: 32,
        count: 2,
        blocks: &[id, 0xFF, 3],
    };
    ask(push, Expected::Silence);
    questions.push(Question {
        bytes: stock(BROADCAST, &write(24, &[0])),
        expected: Expected::Silence,
    });
}

fn curious_x(id: u8, questions: &mut Vec<Question>) {
    use armbridge_servo::protocol2::Instruction;
    let mut ask = |instruction: Instruction, expected| {
        questions.push(Question {
            bytes: instruction.encode::<64>(id).unwrap().to_vec(),
            expected,
        });
    };
    ask(Instruction::Ping, Expected::Data(id, 3));
    // An XL430 does not measure its current.
    let has = |name: &str| !matches!(name, "current_limit" | "goal_current");
    let registers = X_SERIES.registers.iter();
    for register in registers.filter(|register| has(register.name)) {
        let count = register.size.bytes();
        let read = Instruction::Read {
            address: register.address,
            count,
        };
        ask(read, Expected::Data(id, count.into()));
    }
    let whole = Instruction::Read {
        address: 0,
        count: X_SERIES.size,
    };
    // Not across a gap.
    ask(whole, Expected::Refusal(id));
    let write = |address, data| Instruction::Write { address, data };
    ask(write(65, &[1]), Expected::Data(id, 0));
    // Move it, rename it, slow it down, let it run on without a bus, switch it off.
    ask(write(100, &[0, 2]), Expected::Refusal(id));
    ask(write(7, &[9]), Expected::Refusal(id));
    ask(write(12, &[9]), Expected::Refusal(id));
    ask(write(8, &[1]), Expected::Refusal(id));
    ask(write(98, &[0]), Expected::Refusal(id));
    ask(write(64, &[0]), Expected::Refusal(id));
    ask(Instruction::Reboot, Expected::Refusal(id));
    ask(Instruction::FactoryReset(0xFF), Expected::Refusal(id));
    let push = Instruction::SyncWrite {
        address: 100,
        count: 2,
        blocks: &[id, 0xFF, 3],
    };
    ask(push, Expected::Silence);
    let read = Instruction::FastSyncRead {
        address: 132,
        count: 4,
        ids: &[1, 2],
    };
    ask(read, Expected::Silence);
}

/// Address of the client.
const CLIENT: u8 = 0xFE;

/// A Morpheus packet.
pub fn morpheus_request(destination: u8, data: &[u8]) -> Vec<u8> {
    let frame = morpheus::Frame {
        destination,
        source: CLIENT,
        data,
    };
    frame.encode::<64>().unwrap().to_vec()
}

fn curious_morpheus(id: u8, questions: &mut Vec<Question>) {
    let mut ask = |destination, data: &[u8], expected| {
        questions.push(Question {
            bytes: morpheus_request(destination, data),
            expected,
        });
    };
    ask(id, &[1], Expected::Data(id, 1));
    for register in MORPHEUS.registers {
        let count = register.size.bytes();
        ask(
            id,
            &[2, register.address as u8, count as u8],
            Expected::Data(id, count.into()),
        );
    }
    ask(morpheus::BROADCAST, &[7], Expected::Bytes(14));
    // Drive it, rename it, reset it, drive it otherwise, and disturb the chain.
    ask(id, &[3, 0x10, 0, 0], Expected::Refusal(id));
    ask(id, &[3, 1, 9], Expected::Refusal(id));
    ask(id, &[9], Expected::Refusal(id));
    ask(
        morpheus::BROADCAST,
        &[0x83, 0x10, 2, id, 0, 0],
        Expected::Silence,
    );
    ask(morpheus::BROADCAST, &[6], Expected::Silence);
}
