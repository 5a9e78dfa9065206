//! The bus master on a line with any input.

use armbridge_link::message::Sample;
use armbridge_servo::master::timing::GUARD_US;
use armbridge_servo::master::{ExpectedReply, Master, Outcome, Transaction};
use armbridge_servo::morpheus::{Request, ServoId};
use armbridge_servo::serial_bus::SerialBus;
use armbridge_servo::stop::{StopStep, brief_stop_step, stop_steps};
use armbridge_servo::{BYTE_US, Pwm};
use armbridge_tests::random::Random;
use embedded_hal_nb::serial::ErrorKind;

use super::line::{Heard, Port, back_to_back, position, reply};

const STREAMS: usize = 300_000;
/// Transactions of one master, the first of which is a stop.
const STREAMS_PER_MASTER: usize = 20;
/// The most frequent packet of a Morpheus bus.
const FREQUENT: [u8; 9] = [0xAA, 3, 4, 0xFE, 1, 2, 0xFF, 0xF4, 0xF9];
const ERRORS: [ErrorKind; 3] = [ErrorKind::FrameFormat, ErrorKind::Noise, ErrorKind::Overrun];

/// A client's request: servo 2, four registers from 0x0C on.
const QUESTION: [u8; 8] = [0xAA, 5, 2, 0xFE, 2, 0x0C, 4, 0xE3];
const ASKED: ExpectedReply = ExpectedReply {
    id: 2,
    reply_bytes: 9,
    latency_us: 110,
};

type Script = Vec<(u64, Heard)>;

fn ids() -> [ServoId; 2] {
    [1, 2].map(|id| ServoId::new(id).unwrap())
}

/// Bytes sent for a transaction, and its longest duration in µs: bytes, pauses, windows.
fn expected(transaction: Transaction) -> (Vec<u8>, u64) {
    match transaction {
        Transaction::Stop => steps(stop_steps(ids())),
        Transaction::BriefStop => steps((0..).map_while(brief_stop_step)),
        Transaction::Ping { joint } => match ids().get(joint) {
            Some(id) => (Request::Ping(*id).encode().to_vec(), 60 + 400),
            None => (Vec::new(), 0),
        },
        Transaction::Start => (Request::Start.encode().to_vec(), 60 + 3 * 5_000 + 60),
        Transaction::Drive([a, b]) => {
            let [first, second] = ids();
            let mut sent = Request::Drive([(first, a), (second, b)]).encode().to_vec();
            sent.extend(Request::Cycle.encode());
            (sent, 160 + 80 + 60 + 450)
        }
        Transaction::HoldOff => expected(Transaction::Drive([Pwm::OFF; 2])),
        Transaction::StopWedged {
            joint,
            is_side_step,
        } => {
            let off = if is_side_step {
                Request::SideStep([ids()[joint]; 2])
            } else {
                Request::Release([ids()[joint]; 2])
            };
            let mut sent = off.encode().to_vec();
            sent.extend([0xFF; 2]);
            sent.extend(Request::Cycle.encode());
            (sent, 160 + 80 + 60 + 450)
        }
        Transaction::Request(_) => (QUESTION.to_vec(), 80 + 90 + 110),
    }
}

/// Bytes that these steps send, and their duration in µs.
fn steps(steps: impl Iterator<Item = StopStep>) -> (Vec<u8>, u64) {
    let (mut sent, mut pauses_us) = (Vec::new(), 0);
    for step in steps {
        match step {
            StopStep::Send(packet) => sent.extend(packet),
            StopStep::Repeat(byte, count) => sent.extend(vec![byte; count.into()]),
            StopStep::Pause { us } => pauses_us += u64::from(us),
        }
    }
    let limit_us = pauses_us + BYTE_US * sent.len() as u64;
    (sent, limit_us)
}

/// Replies of servos without errors.
fn answers(random: &mut Random, transaction: Transaction) -> ([u16; 2], Vec<Vec<u8>>) {
    let ping = |id| reply(id, &[1]);
    match transaction {
        Transaction::Stop | Transaction::BriefStop => ([0; 2], Vec::new()),
        Transaction::Ping { joint } => ([0; 2], vec![ping(joint as u8 + 1)]),
        Transaction::Start => ([0; 2], vec![ping(1), ping(2)]),
        Transaction::Drive(_) | Transaction::HoldOff | Transaction::StopWedged { .. } => {
            let counts = [0; 2].map(|_| random.below(1024) as u16);
            let [a, b] = counts;
            (counts, vec![position(1, a), position(2, b)])
        }
        Transaction::Request(_) => ([0; 2], vec![reply(2, &[1, 0x22, 0, 44])]),
    }
}

struct Test {
    port: Port,
    master: Master<SerialBus<Port, Port>>,
    random: Random,
    /// Samples believed so far.
    believed: usize,
}

impl Test {
    fn replace_master(&mut self) {
        let (echo, depth) = (self.random.once_in(2), self.random.one_of(&[1, 16, 1000]));
        self.port = Port::new(echo, depth);
        self.master = Master::new(SerialBus::new(self.port.clone(), self.port.clone()), ids());
    }

    fn transaction(&mut self) -> Transaction {
        let random = &mut self.random;
        match random.below(10) {
            0 => Transaction::Stop,
            1 | 2 => Transaction::Ping {
                joint: random.below(3) as usize,
            },
            3 => Transaction::Start,
            4 => Transaction::Request(ASKED),
            5 => Transaction::StopWedged {
                joint: random.below(2) as usize,
                is_side_step: random.once_in(2),
            },
            6 => Transaction::BriefStop,
            7 => Transaction::HoldOff,
            _ => Transaction::Drive([0; 2].map(|_| Pwm::saturating(random.below(2100) as u16))),
        }
    }

    /// Anything, at any time within `within_us`.
    fn noise(&mut self, within_us: u64) -> Script {
        let random = &mut self.random;
        let choice: &[u8] = random.one_of(&[&[], &FREQUENT]);
        let bytes = random.bytes(24, choice);
        bytes
            .into_iter()
            .map(|byte| {
                let byte = if random.once_in(20) {
                    Err(random.one_of(&ERRORS))
                } else {
                    Ok(byte)
                };
                (random.below(within_us), byte)
            })
            .collect()
    }

    /// Real answers that something has happened to.
    fn damaged(&mut self, transaction: Transaction) -> Script {
        let (_, mut packets) = answers(&mut self.random, transaction);
        let random = &mut self.random;
        if random.once_in(4) {
            packets.reverse();
        }
        if random.once_in(4) {
            let counts = random.below(0x1_0000) as u16;
            packets.push(position(random.byte(), counts));
        }
        let mut bytes = packets.concat();
        for _ in 0..random.below(3) {
            random.damage(&mut bytes);
        }
        let mut script = back_to_back(random.below(200), &bytes);
        if random.once_in(3) && !script.is_empty() {
            let at = random.below(script.len() as u64) as usize;
            script[at].1 = Err(random.one_of(&ERRORS));
        }
        script
    }

    /// Runs a transaction: `early` arrives from its begin on, `late` from when
    /// the master listens.
    fn run(&mut self, transaction: Transaction, early: Script, late: Script) -> Outcome {
        let Self { port, master, .. } = self;
        let begun_us = port.line().now_us;
        port.edit(|line| line.expect(early));
        match transaction {
            Transaction::Request(request) => master.request(&QUESTION, request, begun_us).unwrap(),
            _ => master.begin(transaction, begun_us).unwrap(),
        }
        let (sent, limit_us) = expected(transaction);
        // Polled while the transmitter is full, the master comes back a byte
        // later; polled before the last stop bit, as well.
        let waits = if port.line().depth == 1 {
            sent.len()
        } else {
            6
        };
        let limit_us = limit_us + BYTE_US * waits as u64;
        let mut late = Some(late);
        // A poll for each byte either way and each step, and some to spare.
        let most_polls = 2 * sent.len() + port.line().read.len() + 400;
        for _ in 0..most_polls {
            let now_us = port.line().now_us;
            if let Ok(outcome) = master.poll(now_us) {
                let line = port.line();
                assert!(master.is_idle() && !line.is_driven);
                assert_eq!(line.undriven, 0);
                assert_eq!(line.sent, sent, "{transaction:?}");
                let took_us = line.now_us - begun_us;
                assert!(
                    took_us <= limit_us + GUARD_US && u64::from(outcome.bus_us) <= limit_us,
                    "{transaction:?}: {took_us} µs, {outcome:?}"
                );
                return outcome;
            }
            port.edit(|line| {
                if master.bytes_wanted().is_some() {
                    line.expect(late.take().into_iter().flatten());
                }
                let next_us = line.next_us().filter(|_| !line.is_babbling);
                let next_us = next_us.map_or(master.wake_at_us(), |us| us.min(master.wake_at_us()));
                line.now_us = line.now_us.max(next_us);
            });
        }
        panic!("{transaction:?} did not end");
    }

    /// Nothing is believed but an intact answer to what was asked.
    fn check(&mut self, transaction: Transaction, outcome: &Outcome) {
        assert_eq!(outcome.transaction, transaction);
        let read: Vec<u8> = {
            let line = self.port.line();
            // Line errors break a packet; 0 is in no place of an answer where
            // it could mend one.
            let after_error = line.read.split(Result::is_err);
            let parts: Vec<Vec<u8>> = after_error
                .map(|part| part.iter().filter_map(|byte| byte.ok()).collect())
                .collect();
            parts.join(&[0xAA, 0][..])
        };
        for (sample, id) in outcome.samples.iter().zip(1..) {
            let Sample::Counts(counts) = *sample else {
                continue;
            };
            let answer = match transaction {
                Transaction::Drive(_) | Transaction::HoldOff | Transaction::StopWedged { .. } => {
                    position(id, counts)
                }
                Transaction::Ping { joint } if joint + 1 == usize::from(id) => reply(id, &[1]),
                Transaction::Start => reply(id, &[1]),
                _ => panic!("{outcome:?} was believed"),
            };
            assert!(counts <= 1023, "{outcome:?}");
            assert!(
                read.windows(answer.len()).any(|part| part == answer),
                "{outcome:?} from {read:02x?}"
            );
            self.believed += 1;
        }
    }
}

#[test]
fn the_master_ends_in_time_and_believes_only_answers() {
    let port = Port::new(false, 1000);
    let mut test = Test {
        master: Master::new(SerialBus::new(port.clone(), port.clone()), ids()),
        port,
        random: Random::new(0x5EED_0002),
        believed: 0,
    };
    let mut is_quiet = true;
    let mut right = 0;
    for stream in 0..STREAMS {
        test.port.edit(|line| {
            line.clear();
            line.is_babbling = false;
        });
        if stream % STREAMS_PER_MASTER == 0 {
            test.replace_master();
            // The echo of the bus is learnt from the first stop.
            is_quiet = test.random.once_in(2);
            let early = if is_quiet {
                Vec::new()
            } else {
                test.noise(9_000)
            };
            let outcome = test.run(Transaction::Stop, early, Vec::new());
            test.check(Transaction::Stop, &outcome);
            continue;
        }
        let transaction = test.transaction();
        let kind = test.random.below(8);
        let (early, late) = match kind {
            0 => (test.noise(1_000), test.noise(500)),
            1 => (Vec::new(), test.noise(500)),
            2 => (Vec::new(), test.noise(15_000)),
            3 => {
                test.port.edit(|line| line.is_babbling = true);
                (Vec::new(), Vec::new())
            }
            4 | 5 => (Vec::new(), test.damaged(transaction)),
            6 => (test.noise(300), test.damaged(transaction)),
            _ => {
                let (counts, packets) = answers(&mut test.random, transaction);
                let late = back_to_back(60, &packets.concat());
                let outcome = test.run(transaction, Vec::new(), late);
                if is_quiet {
                    for (joint, counts) in counts.into_iter().enumerate() {
                        let is_asked = match transaction {
                            Transaction::Stop
                            | Transaction::BriefStop
                            | Transaction::Request(_) => false,
                            Transaction::Ping { joint: pinged } => pinged == joint,
                            Transaction::Start
                            | Transaction::Drive(_)
                            | Transaction::HoldOff
                            | Transaction::StopWedged { .. } => true,
                        };
                        let sample = outcome.samples[joint];
                        assert_eq!(
                            sample.counts(),
                            is_asked.then_some(counts),
                            "{transaction:?}"
                        );
                        right += usize::from(is_asked);
                    }
                    if let Transaction::Request(_) = transaction {
                        let reply = test.master.reply().expect("an intact answer");
                        assert_eq!(reply.data, [1, 0x22, 0, 44]);
                    }
                }
                test.check(transaction, &outcome);
                continue;
            }
        };
        let outcome = test.run(transaction, early, late);
        test.check(transaction, &outcome);
    }
    assert!(right > STREAMS / 20, "{right} intact answers");
    assert!(test.believed > 2 * right, "{} samples", test.believed);
}
