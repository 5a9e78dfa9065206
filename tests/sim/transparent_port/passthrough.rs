//! The bus while only the client uses it, through a plain transparent port.

use std::cell::RefCell;
use std::rc::Rc;

use armbridge_board::bridge::Channels;
use armbridge_board::bridge::transparent_port::ClientLine;
use armbridge_client::Host;
use armbridge_link::message::Mode;
use armbridge_servo::protocol1::Instruction;
use armbridge_servo::{Firmware, protocol2};
use armbridge_sim::board::{Board, Input, Output, VirtualBoard, Wake};
use armbridge_sim::cosim::{Cosim, PortClient};
use armbridge_tests::plant;
use armbridge_tests::transparent_port::bench;
use armbridge_tests::transparent_port::client::{
    Expected, Hammer, Question, morpheus_request, stock,
};

/// When servos of either kind have been brought up, in µs.
const UP_US: u64 = 400_000;

/// A control link without a host.
struct Nobody {
    ends_us: u64,
    now_us: u64,
}

impl Host for Nobody {
    type Error = std::convert::Infallible;

    fn transmit(&mut self, now_us: u64) -> Result<&[u8], Self::Error> {
        self.now_us = now_us;
        Ok(&[])
    }

    fn receive(&mut self, _now_us: u64, _bytes: &[u8]) -> Result<(), Self::Error> {
        Ok(())
    }

    fn wake_at_us(&self) -> u64 {
        self.ends_us
    }

    fn is_done(&self) -> bool {
        self.now_us >= self.ends_us
    }
}

/// When bytes went in and out of a board, in µs, and what went to the bus.
#[derive(Debug, Default)]
struct Seen {
    from_client: Vec<u64>,
    to_bus: Vec<(u64, Vec<u8>)>,
    from_bus: Vec<u64>,
    to_client: Vec<u64>,
    modes: Vec<Mode>,
}

/// A board that is watched.
struct Watched<'a> {
    board: VirtualBoard<'a>,
    seen: Rc<RefCell<Seen>>,
}

impl Board for Watched<'_> {
    type Error = std::convert::Infallible;

    fn run(
        &mut self,
        now_us: u64,
        input: Input<'_>,
        output: &mut Output,
    ) -> Result<Wake, Self::Error> {
        let wake = self.board.run(now_us, input, output)?;
        let seen = &mut *self.seen.borrow_mut();
        let mark = |is_there: bool, times: &mut Vec<u64>| times.extend(is_there.then_some(now_us));
        mark(!input.client.is_empty(), &mut seen.from_client);
        mark(!input.bus.is_empty(), &mut seen.from_bus);
        mark(!output.client.is_empty(), &mut seen.to_client);
        if !output.bus.is_empty() {
            seen.to_bus.push((now_us, output.bus.clone()));
        }
        if seen.modes.last() != Some(&self.board.mode()) {
            seen.modes.push(self.board.mode());
        }
        Ok(wake)
    }
}

fn run(firmware: Firmware, client: impl PortClient + 'static, ends_us: u64) -> Seen {
    let mut channels = Channels::new();
    let seen = Rc::new(RefCell::new(Seen::default()));
    let board = Watched {
        board: VirtualBoard::new(channels.split()).unwrap(),
        seen: Rc::clone(&seen),
    };
    let bench = bench(&plant([0.0; 2], true), [firmware; 2], 1_000_000);
    let host = Nobody { ends_us, now_us: 0 };
    let mut cosim = Cosim::new(board, bench, host).with_client(client);
    cosim.run().unwrap();
    drop(cosim);
    Rc::into_inner(seen).unwrap().into_inner()
}

#[test]
fn a_disarmed_board_adds_less_than_100_us() {
    for firmware in Firmware::ALL {
        let ask = |id: u8| {
            let bytes = match firmware {
                Firmware::Stock => stock(
                    id,
                    &Instruction::Read {
                        address: 38,
                        count: 2,
                    },
                ),
                Firmware::Morpheus => morpheus_request(id, &[1]),
                Firmware::XSeries => {
                    let ping = protocol2::Instruction::Ping.encode::<16>(id);
                    ping.unwrap().to_vec()
                }
            };
            let count = match firmware {
                Firmware::Stock => 2,
                Firmware::Morpheus => 1,
                Firmware::XSeries => 3,
            };
            Question {
                bytes,
                expected: Expected::Data(id, count),
            }
        };
        let client = Hammer::new(vec![ask(1), ask(2)], UP_US, UP_US + 300_000);
        let seen = run(firmware, client.clone(), UP_US + 300_000);
        let tally = client.tally();
        assert_eq!(tally.wrong, [""; 0], "{firmware}");
        assert!(tally.answered > 100, "{firmware}: {tally:?}");
        // After the first, which waits for the stop sequence.
        let ours = [ask(1).bytes, ask(2).bytes];
        let sent = seen.to_bus.iter();
        let sent = sent.filter(|(at_us, bytes)| *at_us >= UP_US && ours.contains(bytes));
        let ways = seen.from_client.iter().zip(sent.map(|(at_us, _)| at_us));
        let in_us = ways.skip(1).map(|(came, went)| went - came).max();
        let received = seen
            .from_bus
            .iter()
            .filter(|at_us| **at_us >= seen.to_client[0]);
        let ways = received.zip(&seen.to_client);
        let out_us = ways.map(|(came, went)| went - came).max();
        println!("{firmware}: {in_us:?} us in, {out_us:?} us out");
        assert!(
            in_us.unwrap() + out_us.unwrap() < 100,
            "{in_us:?} {out_us:?}"
        );
        assert_eq!(*seen.modes.last().unwrap(), Mode::Passthrough);
    }
}

/// Sends these bytes at these times, then closes its port.
#[derive(Debug)]
struct Speaker {
    words: Vec<(u64, Vec<u8>)>,
    now_us: u64,
}

impl PortClient for Speaker {
    fn line(&self) -> ClientLine {
        ClientLine {
            is_open: !self.words.is_empty(),
            baud: 0,
        }
    }

    fn transmit(&mut self, now_us: u64) -> Vec<u8> {
        self.now_us = now_us;
        match self.words.first() {
            Some((at_us, _)) if *at_us <= now_us => self.words.remove(0).1,
            _ => Vec::new(),
        }
    }

    fn receive(&mut self, _now_us: u64, _bytes: &[u8]) {}

    fn wake_at_us(&self) -> u64 {
        self.words.first().map_or(u64::MAX, |(at_us, _)| *at_us)
    }
}

#[test]
fn packets_stay_whole_and_half_a_packet_never_reaches_the_bus() {
    let ping = stock(1, &Instruction::Ping);
    let (head, tail) = ping.split_at(3);
    let flush = vec![0xFF; 210];
    let words = vec![
        // The first has to wait for the stop sequence.
        (UP_US - 50_000, stock(9, &Instruction::Ping)),
        // In two parts, the second of them late: whole on the bus.
        (UP_US, head.to_vec()),
        (UP_US + 60_000, tail.to_vec()),
        // A half that stays one.
        (UP_US + 100_000, head.to_vec()),
        (UP_US + 300_000, ping.clone()),
        // No packet at all: it passes as it is.
        (UP_US + 400_000, flush.clone()),
        (UP_US + 600_000, Vec::new()),
    ];
    let speaker = Speaker { words, now_us: 0 };
    let seen = run(Firmware::Stock, speaker, UP_US + 900_000);
    let window = UP_US..UP_US + 590_000;
    let sent = seen
        .to_bus
        .iter()
        .filter(|(at_us, _)| window.contains(at_us));
    let sent: Vec<_> = sent.map(|(_, bytes)| bytes.clone()).collect();
    assert_eq!(sent, [ping.clone(), ping, flush]);
    // The port is closed: the board takes the bus back, from the stop on.
    let last = seen.modes.len();
    let expected = [Mode::Idle, Mode::Passthrough, Mode::Boot, Mode::Idle];
    assert_eq!(seen.modes[last - 4..], expected, "{:?}", seen.modes);
}

#[test]
fn what_a_client_has_set_moving_is_stopped_at_its_own_speed() {
    const FROM_US: u64 = 1_000_000;
    let words = vec![
        (FROM_US, morpheus_request(1, &[3, 0x10, 0xDC, 5])),
        (FROM_US + 100_000, Vec::new()),
    ];
    let mut channels = Channels::new();
    let board = VirtualBoard::new(channels.split()).unwrap();
    let bench = bench(&plant([0.0; 2], true), [Firmware::Morpheus; 2], 57_600);
    let host = Nobody {
        ends_us: 2 * FROM_US,
        now_us: 0,
    };
    let speaker = Speaker { words, now_us: 0 };
    let mut cosim = Cosim::new(board, bench, host).with_client(speaker);
    let mut pwm_at = |at_us| {
        while cosim.now_us() < at_us {
            cosim.step().unwrap();
        }
        cosim.bench.applied_pwm(0)
    };
    assert_eq!(pwm_at(FROM_US + 95_000), 1500);
    // The port was closed 10 ms ago. The search begins with other speeds.
    assert_eq!(pwm_at(FROM_US + 110_000), 1000);
}
