//! The bus master, between whose polls anything may happen.
//!
//! The input is a script: what is asked of the master, and before each poll,
//! what the port hears, how much it takes and how late it is.
//!
//! | first byte, modulo 8 | then          | what happens                           |
//! |----------------------|---------------|----------------------------------------|
//! | 0, 1                 | n             | n µs pass, or n times 64 µs            |
//! | 2                    |               | time passes until the master wants it  |
//! | 3, 4                 | n, n % 32 bytes | these are heard                      |
//! | 5                    |               | all that was sent and not yet heard is |
//! | 6                    | n             | framing, noise or overrun is reported  |
//! | 7                    | n             | the transmitter takes n % 32 bytes and no more; it has sent the last bit if n is even; it fails if n is 224 or more |
//!
//! An idle master is asked for something by one byte, modulo 4: stop, ping (n:
//! which joint), START, or drive (four bytes: a PWM for each joint).

mod line;

use armbridge_shared::actuator::Pwm;
use armbridge_shared::servo::master::{Busy, Master, Transaction};
use armbridge_shared::servo::morpheus::{Request, ServoId};
use armbridge_shared::servo::stop::{StopStep, stop_steps};
use embedded_hal_nb::serial::ErrorKind;
use line::{Line, Port, Transmitter};

const ERRORS: [ErrorKind; 3] = [ErrorKind::FrameFormat, ErrorKind::Noise, ErrorKind::Overrun];
/// A poll for each step, for each transmission's end, and some to spare: once
/// nothing happens any more, no transaction takes longer.
const POLLS_MAX: usize = 40;

/// Works through a script, lets the master end what it has begun, and counts
/// the answers that it believed.
///
/// # Panics
/// If a transaction does not end, if something else is sent than it stands for
/// or without the line driver on, or if an answer is believed that nobody gave.
pub fn check(input: &[u8]) -> usize {
    let port = Port::default();
    let mut run = Run {
        master: Master::new(port.clone(), port.clone(), ids()),
        port,
        now_us: 0,
        asked: None,
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
    panic!("{:?} does not end", run.asked);
}

fn ids() -> [ServoId; 2] {
    [1, 2].map(|id| ServoId::new(id).expect("an id"))
}

/// A master at work.
struct Run {
    port: Port,
    master: Master<Port, Port>,
    now_us: u64,
    /// The transaction under way, and when it was asked for.
    asked: Option<(Transaction, u64)>,
    /// Answers so far.
    believed: usize,
}

impl Run {
    /// Does what the script says next; `None` at its end.
    fn step(&mut self, script: &mut impl Iterator<Item = u8>) -> Option<()> {
        if self.master.is_idle() {
            let transaction = transaction(script)?;
            self.port.edit(Line::forget);
            assert_eq!(self.master.begin(transaction, self.now_us), Ok(()));
            self.asked = Some((transaction, self.now_us));
        }
        assert_eq!(self.master.begin(Transaction::Stop, self.now_us), Err(Busy));
        match script.next()? % 8 {
            0 => self.now_us += u64::from(script.next()?),
            1 => self.now_us += 64 * u64::from(script.next()?),
            2 => self.now_us = self.now_us.max(self.master.wake_at_us()),
            3 | 4 => {
                let count = usize::from(script.next()? % 32);
                let heard = script.take(count).map(Ok);
                self.port.edit(|line| line.coming.extend(heard));
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

    fn poll(&mut self) {
        let result = self.master.poll(self.now_us);
        assert_eq!(result.is_ok(), self.master.is_idle());
        if let (Ok(outcome), Some((transaction, begun_us))) = (result, self.asked) {
            assert_eq!(outcome.transaction, transaction);
            assert!(u64::from(outcome.bus_us) <= self.now_us - begun_us);
            self.believed += self.port.edit(|line| line.check(&outcome));
        }
    }
}

fn transaction(script: &mut impl Iterator<Item = u8>) -> Option<Transaction> {
    Some(match script.next()? % 4 {
        0 => Transaction::Stop,
        1 => Transaction::Ping {
            joint: usize::from(script.next()? % 3),
        },
        2 => Transaction::Start,
        _ => Transaction::Drive([pwm(script)?, pwm(script)?]),
    })
}

fn pwm(script: &mut impl Iterator<Item = u8>) -> Option<Pwm> {
    let counts = u16::from_le_bytes([script.next()?, script.next()?]);
    Some(Pwm::saturating(counts))
}

/// What goes out for a transaction.
fn expected(transaction: Transaction) -> Vec<u8> {
    match transaction {
        Transaction::Stop => stop_steps(ids())
            .flat_map(|step| match step {
                StopStep::Send(packet) => packet.to_vec(),
                StopStep::Repeat(byte, count) => vec![byte; count.into()],
                StopStep::Pause { .. } => Vec::new(),
            })
            .collect(),
        Transaction::Ping { joint } => {
            let id = ids().get(joint).copied();
            id.map_or_else(Vec::new, |id| Request::Ping(id).encode().to_vec())
        }
        Transaction::Start => Request::Start.encode().to_vec(),
        Transaction::Drive([a, b]) => {
            let [first, second] = ids();
            let mut sent = Request::Drive([(first, a), (second, b)]).encode().to_vec();
            sent.extend(Request::Cycle.encode());
            sent
        }
    }
}
