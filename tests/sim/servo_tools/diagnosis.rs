//! Each error of an exchange has a diagnosis of its own.

use std::time::Duration;

use armbridge_client::servo_bus::Diagnosis;
use armbridge_client::servo_bus::diagnosis::Refusal;
use armbridge_client::servo_bus::master::BusError;
use armbridge_client::servo_bus::request::Request;
use armbridge_client::servo_table::{AX12A, MORPHEUS};
use armbridge_servo::{Alarms, Firmware};

use super::scripted_line::{FLUSH, FakeLine, client};

/// Answers of servo 1 and 2 to a ping.
const PONG_1: [u8; 6] = [0xAA, 3, 0xFE, 1, 1, 0xF9];
const PONG_2: [u8; 6] = [0xAA, 3, 0xFE, 2, 1, 0xF8];
const STATUS_1: [u8; 6] = [0xFF, 0xFF, 1, 2, 0, 0xFC];
const STATUS_2: [u8; 6] = [0xFF, 0xFF, 2, 2, 0, 0xFB];

fn ping(firmware: Firmware) -> Request {
    Request::ping(firmware, 1).unwrap()
}

/// Result of a request with this reply.
fn outcome(request: &Request, reply: &[u8], echoes: bool) -> Result<Vec<u8>, Diagnosis> {
    let mut line = FakeLine::new(|sent: &[u8]| {
        let is_flush = sent == FLUSH;
        if is_flush { Vec::new() } else { reply.to_vec() }
    });
    line.echoes = echoes;
    let result = client(&mut line).ask(request);
    match result {
        Ok(packet) => Ok(packet.data),
        Err(BusError::Diagnosis(diagnosis)) => Err(diagnosis),
        Err(error) => panic!("{error}"),
    }
}

#[test]
fn each_has_its_name_and_its_advice() {
    let damaged = |mut packet: [u8; 6]| {
        packet[4] ^= 0x10;
        packet.to_vec()
    };
    #[rustfmt::skip]
    let cases = [
        (Firmware::Morpheus, vec![], Diagnosis::Silence, "nothing was received"),
        (Firmware::Stock, vec![], Diagnosis::Silence, "power"),
        (Firmware::Morpheus, damaged(PONG_1), Diagnosis::BadChecksum { id: 1 }, "checksum"),
        (Firmware::Stock, damaged(STATUS_1), Diagnosis::BadChecksum { id: 1 }, "two servos with one id"),
        (Firmware::Morpheus, PONG_2.to_vec(), Diagnosis::WrongId { answered: 2 }, "servo 2 answered"),
        (Firmware::Stock, STATUS_2.to_vec(), Diagnosis::WrongId { answered: 2 }, "servo 2 answered"),
        (Firmware::Morpheus, PONG_1[..4].to_vec(), Diagnosis::Short { bytes: 4 }, "broke off"),
        (Firmware::Stock, STATUS_1[..5].to_vec(), Diagnosis::Short { bytes: 5 }, "broke off"),
        (Firmware::Morpheus, vec![0x00, 0xE0, 0x1C], Diagnosis::Garbage { bytes: 3 }, "baud rate"),
        (Firmware::Stock, vec![0x00, 0xE0, 0x1C], Diagnosis::Garbage { bytes: 3 }, "baud rate"),
        (Firmware::Morpheus, [PONG_1, PONG_1].concat(), Diagnosis::Several, "more than one answer"),
        (Firmware::Stock, [STATUS_1, STATUS_2].concat(), Diagnosis::Several, "more than one answer"),
        (Firmware::Stock, [STATUS_1.to_vec(), damaged(STATUS_1)].concat(), Diagnosis::Several, "one id"),
        (Firmware::Morpheus, vec![0xAA, 3, 0xFE, 1, 8, 0xF2], Refusal::Nok.into(), "refused: NOK"),
    ];
    for (firmware, reply, expected, words) in cases {
        let request = ping(firmware);
        for echoes in [false, true] {
            let found = outcome(&request, &reply, echoes).unwrap_err();
            let expected = match (&expected, echoes) {
                (Diagnosis::Silence, true) => Diagnosis::EchoOnly,
                (expected, _) => (*expected).clone(),
            };
            assert_eq!(found, expected, "{firmware} {reply:02X?} echo {echoes}");
            let words = if expected == Diagnosis::EchoOnly {
                "only our own bytes"
            } else {
                words
            };
            assert!(found.to_string().contains(words), "{found}");
        }
    }
}

#[test]
fn good_answers_are_taken_with_and_without_echo() {
    for echoes in [false, true] {
        let morpheus = outcome(&ping(Firmware::Morpheus), &PONG_1, echoes);
        assert_eq!(morpheus, Ok(vec![1]));
        assert_eq!(
            outcome(&ping(Firmware::Stock), &STATUS_1, echoes),
            Ok(vec![])
        );
        // A glitch when the wire changes hands.
        let glitched = [&[0x00], STATUS_1.as_slice()].concat();
        assert_eq!(
            outcome(&ping(Firmware::Stock), &glitched, echoes),
            Ok(vec![])
        );
    }
}

#[test]
fn alarms_refuse_only_where_they_mean_the_instruction() {
    let goal = AX12A.by_name("goal_position").unwrap();
    let request = Request::write(Firmware::Stock, 1, goal, 512).unwrap();
    let status = |alarms: Alarms| {
        let bits = alarms.bits();
        [0xFF, 0xFF, 1, 2, bits, !(3 + bits)]
    };
    let hot = Alarms::OVERHEATING.or(Alarms::INPUT_VOLTAGE);
    assert_eq!(outcome(&request, &status(hot), false), Ok(vec![]));
    let refused = outcome(&request, &status(hot.or(Alarms::RANGE)), false).unwrap_err();
    assert_eq!(refused, Refusal::Alarms(Alarms::RANGE).into());
    assert!(refused.to_string().contains("out of range"), "{refused}");
}

/// The board answers in a servo's place when a loop leaves no time, also for
/// ids that no servo has.
#[test]
fn a_ping_that_the_board_refuses_is_no_servo() {
    let mut line = FakeLine::new(|sent: &[u8]| match *sent {
        [0xFF, 0xFF, id, 2, 1, _] => vec![0xFF, 0xFF, id, 2, 0x40, !(id + 0x42)],
        _ => Vec::new(),
    });
    let refused = client(&mut line).ping(Firmware::Stock, 1).unwrap_err();
    assert!(
        refused.to_string().contains("the board guards"),
        "{refused}"
    );
}

/// A servo with a low supply answers its ping with the very bytes of the ping.
#[test]
fn an_answer_that_looks_like_the_request_is_not_taken_for_echo() {
    let request = ping(Firmware::Stock);
    let low_voltage = [0xFF, 0xFF, 1, 2, 1, 0xFB];
    assert_eq!(request.bytes, low_voltage);
    assert_eq!(outcome(&request, &low_voltage, false), Ok(vec![]));
    assert_eq!(outcome(&request, &low_voltage, true), Ok(vec![]));
    assert_eq!(outcome(&request, &[], true), Err(Diagnosis::EchoOnly));
}

/// Nor is a late echo taken for a reply, or missed.
#[test]
fn a_late_echo_is_waited_for() {
    let mut line = FakeLine::new(|sent: &[u8]| {
        let is_ours = sent == ping(Firmware::Stock).bytes;
        if is_ours {
            STATUS_1.to_vec()
        } else {
            Vec::new()
        }
    });
    line.echoes = true;
    line.delay = Duration::from_millis(100);
    let mut client = client(&mut line);
    assert_eq!(client.ping(Firmware::Stock, 2).unwrap(), None);
    assert!(client.ping(Firmware::Stock, 1).unwrap().is_some());
}

#[test]
fn a_changed_echo_is_somebody_else_on_the_wire() {
    let request = ping(Firmware::Stock);
    let mut line = FakeLine::new(|sent: &[u8]| {
        let mut echo = sent.to_vec();
        if echo != FLUSH {
            echo[4] ^= 0x40;
        }
        echo
    });
    let result = client(&mut line).ask(&request);
    assert!(
        matches!(result, Err(BusError::Diagnosis(Diagnosis::EchoDamaged))),
        "{result:?}"
    );
}

/// To a Morpheus servo 0xAA is a header, and a LEN of 2 after it deafens it.
#[test]
fn what_a_morpheus_servo_takes_for_a_header_is_flushed() {
    let flushes_after = |firmware, id| {
        let mut line = FakeLine::new(|_: &[u8]| Vec::new());
        let found = client(&mut line).ping(firmware, id).unwrap();
        assert_eq!(found, None);
        // The first is the client's own.
        assert_eq!(line.sent[0], FLUSH);
        line.sent
            .iter()
            .skip(2)
            .filter(|sent| **sent == FLUSH)
            .count()
    };
    let stock: Vec<u8> = (0..=253)
        .filter(|id| flushes_after(Firmware::Stock, *id) > 0)
        .collect();
    // By its id, and by the checksum.
    assert_eq!(stock, [82, 170]);
    assert_eq!(flushes_after(Firmware::Morpheus, 1), 0);
}

/// Each is asked for from a register that never holds 0x83: the marker, the baud
/// rate, the high byte of position or temperature.
#[test]
fn a_reading_of_morpheus_is_asked_so_that_it_deafens_nobody() {
    for register in MORPHEUS.registers {
        let (address, count) = (register.address, register.size.bytes());
        let request = Request::read(Firmware::Morpheus, 1, address, count);
        if register.name == "position" {
            assert!(request.is_none());
            continue;
        }
        let first = request.unwrap().bytes[5];
        let is_safe = matches!(first, 0x00 | 0x0A | 0x0C | 0x0F);
        assert!(is_safe, "{} is read from {first}", register.name);
    }
}
