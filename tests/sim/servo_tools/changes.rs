//! Reading back, and finding a servo again after its id or rate has changed.

use armbridge_client::servo_bus::Servo;
use armbridge_client::servo_bus::change::ChangeError;
use armbridge_client::servo_bus::reading::{ServoError, Taken, Value};
use armbridge_client::servo_bus::scan::{Area, scan};
use armbridge_client::servo_table::{AX12A, Register};
use armbridge_servo::Firmware;

use super::scripted_line::{Bus, FakeLine, Stock, client};

fn register(name: &str) -> &'static Register {
    AX12A.by_name(name).unwrap()
}

#[test]
fn what_is_written_is_read_back_whatever_is_answered() {
    for level in [2, 1] {
        let mut stock = Stock::new(1);
        stock.memory[16] = level;
        let mut line = FakeLine::new(stock);
        let mut client = client(&mut line);
        let mut servo = Servo::find(&mut client, 1).unwrap();
        assert_eq!(servo.firmware(), Firmware::Stock);
        let taken = servo.write(register("goal_position"), 700).unwrap();
        assert_eq!(taken, Taken::ReadBack);
        assert_eq!(line.bus.memory[30..32], [0xBC, 2]);
    }
}

#[test]
fn a_servo_that_answers_only_pings_is_named_and_can_be_talked_round() {
    let mut stock = Stock::new(1);
    stock.memory[16] = 0;
    let mut line = FakeLine::new(stock);
    let mut client = client(&mut line);
    let mut servo = Servo::find(&mut client, 1).unwrap();
    let error = servo.read(register("present_voltage")).unwrap_err();
    assert!(matches!(error, ServoError::Mute(1)), "{error}");
    assert!(error.to_string().contains("status_return_level"), "{error}");
    servo.write(register("status_return_level"), 2).unwrap();
    let read = servo.read(register("present_voltage")).unwrap();
    assert_eq!(read.value, Value::Known(111));
}

/// As from the board, whose tick has time for short answers only.
#[test]
fn what_is_refused_as_a_whole_is_read_piece_by_piece() {
    let mut stock = Stock::new(1);
    let mut line = FakeLine::new(|sent: &[u8]| match *sent {
        [0xFF, 0xFF, 1, 4, 2, _, 3..=0xFF, _] => vec![0xFF, 0xFF, 1, 2, 0x40, !0x43],
        _ => stock.answer(sent, 1_000_000),
    });
    let mut client = client(&mut line);
    let all = Servo::find(&mut client, 1).unwrap().read_all().unwrap();
    let voltage = all.iter().find(|it| it.register.name == "present_voltage");
    assert_eq!(voltage.unwrap().value, Value::Known(111));
    assert_eq!(all.len(), AX12A.registers.len());
}

#[test]
fn another_value_than_the_wanted_one_is_an_error() {
    let mut stock = Stock::new(1);
    stock.stubborn = vec![30];
    let mut line = FakeLine::new(stock);
    let mut client = client(&mut line);
    let mut servo = Servo::find(&mut client, 1).unwrap();
    let error = servo.write(register("goal_position"), 700).unwrap_err();
    let words = "keep 700 in goal_position, but keeps 0";
    assert!(error.to_string().contains(words), "{error}");
    assert!(error.is_servo_error());
    for (name, value, words) in [
        ("max_torque", 1024, "from 0 to 1023"),
        ("punch", 31, "from 32 to 1023"),
        ("present_position", 1, "only be read"),
        ("id", 2, "set-id"),
        ("baud_rate", 1, "set-baud"),
    ] {
        let error = servo.write(register(name), value).unwrap_err();
        assert!(error.to_string().contains(words), "{error}");
        assert!(!error.is_servo_error());
    }
    // None of these was sent.
    let writes = line.sent.iter().filter(|sent| sent.get(4) == Some(&3));
    assert_eq!(writes.count(), 1);
}

#[test]
fn an_id_is_given_only_if_nobody_has_it() {
    let mut line = FakeLine::new(vec![Stock::new(1), Stock::new(2)]);
    let mut client = client(&mut line);
    let mut servo = Servo::find(&mut client, 1).unwrap();
    let error = servo.set_id(2).unwrap_err();
    assert!(
        matches!(error, ChangeError::Occupied { id: 2, .. }),
        "{error}"
    );
    let error = servo.set_id(254).unwrap_err();
    assert!(error.to_string().contains("0 to 253"), "{error}");
    servo.set_id(7).unwrap();
    assert_eq!(servo.id(), 7);
    assert_eq!((line.bus[0].memory[3], line.bus[1].memory[3]), (7, 2));
}

#[test]
fn an_id_that_is_not_taken_is_told() {
    let mut stock = Stock::new(1);
    stock.stubborn = vec![3];
    let mut line = FakeLine::new(stock);
    let mut client = client(&mut line);
    let mut servo = Servo::find(&mut client, 1).unwrap();
    let error = servo.set_id(7).unwrap_err();
    assert!(matches!(error, ChangeError::Unchanged { .. }), "{error}");
    assert!(error.to_string().contains("as id 1"), "{error}");
}

#[test]
fn the_line_follows_a_servo_to_its_new_rate_and_back_if_it_did_not_go() {
    for is_stubborn in [false, true] {
        let mut stock = Stock::new(1);
        if is_stubborn {
            stock.stubborn = vec![4];
        }
        let mut line = FakeLine::new(stock);
        let mut client = client(&mut line);
        let mut servo = Servo::find(&mut client, 1).unwrap();
        let result = servo.set_baud(115_200, false);
        if is_stubborn {
            let error = result.unwrap_err();
            assert!(matches!(error, ChangeError::Unchanged { .. }), "{error}");
            assert_eq!(line.baud, 1_000_000);
        } else {
            assert_eq!(result.unwrap(), Taken::ReadBack);
            assert_eq!((line.baud, line.bus.memory[4]), (115_200, 16));
        }
    }
}

/// Servo 1 at a slow rate, where another servo 1 would be met at the fast one.
#[test]
fn nobody_is_sent_to_a_rate_at_which_his_id_is_taken() {
    let mut slow = Stock::new(1);
    slow.memory[4] = 16;
    let mut line = FakeLine::new(vec![slow, Stock::new(1)]);
    line.baud = 115_200;
    let mut client = client(&mut line);
    let mut servo = Servo::find(&mut client, 1).unwrap();
    for error in [
        servo.set_baud(1_000_000, false).unwrap_err(),
        servo.factory_reset().unwrap_err(),
    ] {
        assert!(
            matches!(error, ChangeError::Occupied { id: 1, .. }),
            "{error}"
        );
    }
    assert_eq!((line.baud, line.bus[0].memory[4]), (115_200, 16));
}

#[test]
fn a_rate_that_a_servo_has_not_is_refused_with_those_that_it_has() {
    let mut line = FakeLine::new(Stock::new(1));
    let mut client = client(&mut line);
    let mut servo = Servo::find(&mut client, 1).unwrap();
    let error = servo.set_baud(2_000_000, false).unwrap_err();
    assert!(error.to_string().contains("57600"), "{error}");
    assert_eq!(line.bus.memory[4], 1);
}

#[test]
fn a_scan_looks_at_every_rate_and_ends_where_it_began() {
    let mut slow = Stock::new(5);
    slow.memory[4] = 34;
    let mut twin = Stock::new(9);
    twin.memory[16] = 0;
    let mut line = FakeLine::new(vec![
        Stock::new(0),
        slow,
        twin,
        Stock::new(3),
        Stock::new(3),
    ]);
    let mut client = client(&mut line);
    let area = Area {
        ids: 0..=9,
        bauds: vec![1_000_000, 57_600],
    };
    let mut steps = Vec::new();
    let report = scan(&mut client, &area, |step| steps.push(step.done)).unwrap();
    assert_eq!(steps, (0..60).collect::<Vec<_>>());
    let found: Vec<_> = report.found.iter().map(|it| (it.id, it.baud)).collect();
    let fast = Some(1_000_000);
    assert_eq!(found, [(0, fast), (5, Some(57_600)), (9, fast)]);
    let details = report.found[1].details;
    assert_eq!(
        (
            details.model,
            details.version,
            details.temperature,
            details.decivolt
        ),
        (Some(12), Some(24), Some(31), Some(111))
    );
    // Two with id 3, and one that can only be pinged.
    let troubles: Vec<_> = report.troubles.iter().map(|it| it.id).collect();
    assert_eq!(troubles, [3, 9]);
    assert!(report.troubles[0].diagnosis.contains("one id"));
    assert!(!report.is_mixed());
    assert_eq!(line.baud, 1_000_000);
}
