//! The bus master against a simulated serial port with scripted servos.
//!
//! The port keeps time: a byte takes 10 µs, and what the script answers arrives
//! that long after the last stop bit of the request.

mod scripted_port;

use scripted_port::{Port, REPLY_1, REPLY_2, Script, Test, bytes, chain};

use armbridge_servo::bus::{Bus, LineAfter, Received, Transmission};
use armbridge_servo::master::{Master, Transaction};
use armbridge_servo::morpheus::{MASTER, Parser, ServoId};
use armbridge_servo::{Alarms, ControlMode, Firmware, Missing, Pwm, Sample};
use embedded_hal_nb::serial;
use proptest::prelude::*;

#[test]
fn a_tick_on_the_wire() {
    for echo in [false, true] {
        let mut test = Test::new(echo);
        let outcome = test.drive(chain());
        assert_eq!(
            outcome.samples,
            [Sample::Counts(500), Sample::Counts(501)],
            "echo {echo}"
        );
        // 16 bytes, 80 µs of pause, 6 bytes, and the second reply 250 µs later.
        assert_eq!(outcome.bus_us, 160 + 80 + 60 + 250);
        let line = test.port.0.borrow();
        assert_eq!(line.undriven, 0);
        #[rustfmt::skip]
        assert_eq!(line.sent, [
            0xAA, 13, 0xFF, 0xFE, 0x83, 0x0F, 3, 1, 0, 0xE8, 3, 2, 0, 0xDC, 5, 0x84,
            0xAA, 3, 0xFF, 0xFE, 7, 0xF5,
        ]);
    }
}

/// The port as a bus whose line is released by hardware, at the end of each transmission.
struct Hardware {
    port: Port,
    received: Vec<u8>,
}

impl Bus for Hardware {
    const RELEASES_BY_ITSELF: bool = true;
    const BAUD_MAX: u32 = 4_500_000;

    fn set_baud(&mut self, baud: u32) {
        assert_eq!(baud, 1_000_000);
    }

    fn send(&mut self, bytes: &[u8], _after: LineAfter) {
        assert_eq!(self.transmission(), Transmission::Complete);
        self.port.0.borrow_mut().sending = true;
        for byte in bytes {
            serial::Write::write(&mut self.port, *byte).unwrap();
        }
    }

    fn send_delay_us(&self) -> u32 {
        DELAY_US
    }

    fn transmission(&mut self) -> Transmission {
        let end_us = self.port.0.borrow().sent_until_us + u64::from(DELAY_US);
        if self.port.0.borrow().now_us < end_us {
            Transmission::Sending
        } else {
            Transmission::Complete
        }
    }

    fn release(&mut self) {}

    fn received(&mut self) -> Received<'_> {
        self.received.clear();
        while let Ok(byte) = serial::Read::read(&mut self.port) {
            self.received.push(byte);
        }
        Received {
            bytes: &self.received,
            error: None,
        }
    }
}

/// Time from a poll to the begin of its transmission, in µs.
const DELAY_US: u32 = 7;

/// Polled only when the master asks for it, a tick takes three polls, and each step is timed
/// from the end of the transmission before, however late that began.
#[test]
fn a_bus_that_releases_the_line_itself_needs_three_polls_a_tick() {
    for echo in [false, true] {
        let ids = [1, 2].map(|id| ServoId::new(id).unwrap());
        let port = Port::default();
        let bus = Hardware {
            port: port.clone(),
            received: Vec::new(),
        };
        port.0.borrow_mut().echo = echo;
        let mut master = Master::new(bus, ids);
        let run = |master: &mut Master<Hardware>, transaction| {
            let begun_us = port.0.borrow().now_us;
            master.begin(transaction, begun_us).unwrap();
            let mut polled_us = Vec::new();
            loop {
                let now_us = port.0.borrow().now_us;
                polled_us.push(now_us - begun_us);
                if let Ok(outcome) = master.poll(now_us) {
                    return (outcome, polled_us);
                }
                let mut line = port.0.borrow_mut();
                let wanted = master.bytes_wanted();
                if wanted.is_some() && line.coming.len() < 14 {
                    let end_us = line.sent_until_us + u64::from(DELAY_US);
                    let replies = chain().into_iter().map(|(us, byte)| (end_us + us, byte));
                    line.coming.extend(replies);
                }
                let last = wanted.and_then(|wanted| line.coming.get(wanted - 1));
                let wake_us = master.wake_at_us();
                line.now_us = last.map_or(wake_us, |(at_us, _)| wake_us.min(*at_us));
            }
        };
        run(&mut master, Transaction::Stop);
        let (outcome, polled_us) = run(&mut master, Transaction::Drive([Pwm::OFF; 2]));
        assert_eq!(outcome.samples, [Sample::Counts(500), Sample::Counts(501)]);
        let cycle_us = u64::from(DELAY_US) + 160 + 80;
        let end_us = cycle_us + u64::from(DELAY_US) + 60 + 250;
        assert_eq!(polled_us, [0, cycle_us, end_us], "echo {echo}");
    }
}

#[test]
fn kinds_of_missing_samples_are_told_apart() {
    let mut bad = REPLY_2;
    bad[5] ^= 1;
    let mut stranger = REPLY_2;
    (stranger[3], stranger[6]) = (3, 0);
    let first = bytes(60, &REPLY_1);
    let then = |more: &[u8]| [first.clone(), bytes(180, more)].concat();
    let line_error = vec![(70, Err(serial::ErrorKind::FrameFormat))];
    let cases = [
        (false, first.clone(), Missing::Silence),
        (false, then(&bad), Missing::BadChecksum),
        (false, then(&stranger), Missing::WrongId),
        (false, then(&REPLY_2[..6]), Missing::Short),
        (false, [first.clone(), line_error].concat(), Missing::Line),
        (true, Vec::new(), Missing::EchoOnly),
        (false, Vec::new(), Missing::Silence),
    ];
    for (echo, script, missing) in cases {
        let mut test = Test::new(echo);
        let got = test.drive(script.clone()).samples[1];
        assert_eq!(got, Sample::Missing(missing));
        // Whatever it was, the next tick is not affected.
        let next = test.drive(chain());
        assert_eq!(
            next.samples,
            [Sample::Counts(500), Sample::Counts(501)],
            "after {missing:?}"
        );
    }
}

#[test]
fn the_stop_sequence_keeps_its_gaps() {
    let mut test = Test::new(false);
    let before_us = test.port.0.borrow().now_us;
    test.run(Transaction::Stop, Vec::new());
    let line = test.port.0.borrow();
    let stop_all = [0xAA, 6, 0xFF, 0xFE, 3, 0x10, 0xE8, 3, 0xF8];
    assert_eq!(line.sent[..9], stop_all);
    assert!(line.sent[9..219].iter().all(|byte| *byte == 0xFF));
    assert_eq!(line.sent[219..228], stop_all);
    // SYNC_WR twice for Morpheus, then torque off twice for stock servos.
    let torque_off = [0xFF, 0xFF, 0xFE, 4, 3, 24, 0, 0xE2];
    assert_eq!(line.sent[228 + 2 * 14..], [torque_off; 2].concat());
    assert_eq!(line.undriven, 0);
    assert!(
        line.now_us - before_us < 8_000,
        "{} µs",
        line.now_us - before_us
    );
}

#[test]
fn the_brief_stop_takes_less_than_half_a_millisecond() {
    let mut test = Test::new(false);
    let before_us = test.port.0.borrow().now_us;
    test.run(Transaction::BriefStop, Vec::new());
    let line = test.port.0.borrow();
    #[rustfmt::skip]
    assert_eq!(line.sent, [
        0xFF, 0xFF,
        0xAA, 6, 0xFF, 0xFE, 3, 0x10, 0xE8, 3, 0xF8,
        0xFF, 0xFF, 0xFE, 4, 3, 24, 0, 0xE2,
    ]);
    assert_eq!(line.undriven, 0);
    let took_us = line.now_us - before_us;
    assert!((390..500).contains(&took_us), "{took_us} µs");
}

#[test]
fn a_tick_with_motors_off_says_so_in_either_protocol() {
    let mut test = Test::new(false);
    let outcome = test.run(Transaction::HoldOff, chain());
    assert_eq!(outcome.samples, [Sample::Counts(500), Sample::Counts(501)]);
    #[rustfmt::skip]
    assert_eq!(test.port.0.borrow().sent, [
        0xAA, 13, 0xFF, 0xFE, 0x83, 0x0F, 3, 1, 0, 0xE8, 3, 2, 0, 0xE8, 3, 0x7A,
        0xAA, 3, 0xFF, 0xFE, 7, 0xF5,
    ]);
    // Prepared or not: torque enable 0 to all before each READ.
    for is_prepared in [false, true] {
        let mut test = Test::new(false);
        test.master.set_line(Firmware::Stock, 1_000_000).unwrap();
        test.master
            .set_prepared(is_prepared.then_some(ControlMode::Pwm));
        test.run(Transaction::HoldOff, Vec::new());
        #[rustfmt::skip]
        assert_eq!(test.port.0.borrow().sent, [
            0xFF, 0xFF, 0xFE, 4, 3, 24, 0, 0xE2,
            0xFF, 0xFF, 1, 4, 2, 36, 2, 0xD2,
            0xFF, 0xFF, 0xFE, 4, 3, 24, 0, 0xE2,
            0xFF, 0xFF, 2, 4, 2, 36, 2, 0xD1,
        ]);
    }
}

/// A status packet without the position comes first, with an overheating alarm: the
/// position's own packet, without one, does not hide it.
#[test]
fn alarms_of_all_replies_of_a_servo_are_reported() {
    let mut test = Test::new(false);
    test.master.set_line(Firmware::Stock, 1_000_000).unwrap();
    let alarm = [0xFF, 0xFF, 1, 2, 4, 0xF8];
    let position = [0xFF, 0xFF, 1, 4, 0, 7, 2, 0xF1];
    let outcome = test.run(
        Transaction::HoldOff,
        bytes(60, &[&alarm[..], &position].concat()),
    );
    assert_eq!(outcome.samples[0], Sample::Counts(519));
    assert_eq!(outcome.alarms, [Alarms::OVERHEATING, Alarms::NONE]);
}

/// Servo 1 answers as late as with the return delay that it has ex works.
#[test]
fn an_answer_after_its_window_is_no_other_servos() {
    let late = bytes(600, &[0xFF, 0xFF, 1, 4, 0, 7, 2, 0xF1]);
    let hold_off = |test: &mut Test| test.run(Transaction::HoldOff, late.clone());
    let mut test = Test::new(false);
    test.master.set_line(Firmware::Stock, 1_000_000).unwrap();
    let unknown = hold_off(&mut test);
    let silent = Sample::Missing(Missing::Silence);
    assert_eq!(unknown.samples, [Sample::Counts(519), silent]);
    // Servos that let go keep their return delay: what is later is not theirs.
    test.master.set_prepared(Some(ControlMode::Pwm));
    test.master.mark_released();
    assert!(!test.master.is_prepared());
    let released = hold_off(&mut test);
    let stranger = Sample::Missing(Missing::WrongId);
    assert_eq!(released.samples, [silent, stranger]);
    assert_eq!(released.bus_us, 2 * (50 + 80 + 50 + 80 + 302));
    // What is not known is not known after a stop either.
    test.master.set_prepared(None);
    test.master.mark_released();
    assert_eq!(hold_off(&mut test).samples, unknown.samples);
}

#[test]
fn an_order_to_drive_is_taken_back_before_it_is_sent_and_not_after() {
    let full = Transaction::Drive([Pwm::MAX; 2]);
    for (firmware, polls, is_back) in [
        (Firmware::Morpheus, 0, true),
        (Firmware::Morpheus, 100, false),
        (Firmware::Stock, 0, true),
        (Firmware::Stock, 100, false),
    ] {
        let mut test = Test::new(false);
        test.master.set_line(firmware, 1_000_000).unwrap();
        test.master.set_prepared(Some(ControlMode::Pwm));
        let now_us = test.port.0.borrow().now_us;
        test.master.begin(full, now_us).unwrap();
        for _ in 0..polls {
            let now_us = test.port.0.borrow().now_us;
            assert!(test.master.poll(now_us).is_err());
            test.port.0.borrow_mut().now_us += 1;
        }
        test.master.cancel_drive();
        let outcome = loop {
            let now_us = test.port.0.borrow().now_us;
            if let Ok(outcome) = test.master.poll(now_us) {
                break outcome;
            }
            test.port.0.borrow_mut().now_us += 1;
        };
        assert_eq!(
            outcome.transaction.is_off(),
            is_back,
            "{firmware:?} {polls}"
        );
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 256, ..ProptestConfig::default() })]

    /// Whatever is on the wire, a transaction ends, and in time.
    #[test]
    fn noise_neither_stops_nor_delays_the_master(
        noise in prop::collection::vec((0u64..600, prop::option::of(any::<u8>())), 0..80),
        echo: bool,
    ) {
        let mut test = Test::new(echo);
        let mut script: Script = noise
            .into_iter()
            .map(|(at, byte)| (at, byte.ok_or(serial::ErrorKind::Noise)))
            .collect();
        script.sort_by_key(|(at, _)| *at);
        let outcome = test.drive(script);
        prop_assert!(outcome.bus_us <= 160 + 80 + 60 + 450);
        for sample in outcome.samples {
            prop_assert!(sample.counts().is_none_or(|counts| counts <= 1023));
        }
    }

    /// The reply parser survives any stream.
    #[test]
    fn parser_takes_any_bytes(stream in prop::collection::vec(any::<u8>(), 0..400)) {
        let mut parser = Parser::to(MASTER);
        let packets = stream.iter().filter(|byte| parser.push(**byte).is_some_and(|found| found.is_ok())).count();
        prop_assert!(packets <= stream.len() / 6);
    }
}
