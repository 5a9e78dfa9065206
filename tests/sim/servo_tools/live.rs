//! The virtual servos, over TCP, in wall-clock time. A busy machine may be
//! late, so the client is more patient than it is by itself, and most lines
//! echo: on those it counts from when the request has left.

use armbridge_client::servo_bus::Servo;
use armbridge_client::servo_bus::change::ChangeError;
use armbridge_client::servo_bus::reading::{Taken, Value};
use armbridge_client::servo_bus::scan::{Area, scan};
use armbridge_client::servo_table::{AX12A, Access, MORPHEUS, Register, Unit};
use armbridge_servo::{Firmware, Firmware as Kind};
use armbridge_tests::served_servos::{MORPHEUS_ARM, STOCK_ARM, await_temperature, connect, serve};

fn register(name: &str) -> &'static Register {
    MORPHEUS.by_name(name).unwrap()
}

#[test]
fn a_scan_finds_both_with_and_without_echo() {
    for echo in [false, true] {
        let at = serve(&MORPHEUS_ARM, echo);
        await_temperature(&at);
        let mut client = connect(&at);
        assert_eq!(client.echoes(), echo);
        let area = Area {
            ids: 0..=3,
            bauds: vec![1_000_000],
        };
        let report = scan(&mut client, &area, |_| {}).unwrap();
        let found: Vec<_> = report
            .found
            .iter()
            .map(|it| (it.id, it.firmware, it.baud, it.details.temperature))
            .collect();
        let morpheus = |id| (id, Firmware::Morpheus, None, Some(300));
        assert_eq!(found, [morpheus(1), morpheus(2)]);
        assert!(report.troubles.is_empty(), "{:?}", report.troubles);
    }
}

#[test]
fn every_register_is_read_and_what_is_written_is_kept() {
    let at = serve(&MORPHEUS_ARM, true);
    await_temperature(&at);
    let mut client = connect(&at);
    let mut servo = Servo::find(&mut client, 2).unwrap();
    let all = servo.read_all().unwrap();
    let names: Vec<_> = all.iter().map(|reading| reading.register.name).collect();
    let expected: Vec<_> = MORPHEUS.registers.iter().map(|it| it.name).collect();
    assert_eq!(names, expected);
    for reading in &all {
        match (reading.register.name, reading.value) {
            ("position", Value::Known(counts)) => assert!((1..1023).contains(&counts)),
            // Never a number that is not true.
            ("speed", Value::Known(_)) | ("pwm", Value::LowByte(0)) => {}
            ("temperature", value) => assert_eq!(value, Value::Known(300)),
            ("id", value) => assert_eq!(value, Value::Known(2)),
            (name, value) => {
                let initial = reading.register.initial.map(Value::Known);
                assert_eq!(Some(value), initial, "{name}");
            }
        }
    }

    assert_eq!(
        servo.write(register("speed_ki"), 77).unwrap(),
        Taken::ReadBack
    );
    let pwm = register("pwm");
    assert_eq!(servo.write(pwm, 1300).unwrap(), Taken::LowByteReadBack);
    assert_eq!(servo.read(pwm).unwrap().value, Value::LowByte(0x14));
    assert_eq!(servo.write(pwm, 1000).unwrap(), Taken::LowByteReadBack);
    let position = register("position");
    let error = servo.write(position, 1022).unwrap_err().to_string();
    assert!(error.contains("from 2 to 1021"), "{error}");
    assert_eq!(servo.write(position, 512).unwrap(), Taken::NotReadable);
    let error = servo.write(register("speed"), 11).unwrap_err().to_string();
    assert!(error.contains("from 0 to 10"), "{error}");
    let error = servo
        .write(register("magic"), 0xAA)
        .unwrap_err()
        .to_string();
    assert!(error.contains("only be read"), "{error}");
}

/// As they come from the shop: both with id 1, and their answers to a ping are
/// one on the wire, bit for bit.
#[test]
fn two_stock_servos_with_one_id_are_noticed() {
    let mut client = connect(&serve(&[(Kind::Stock, 1), (Kind::Stock, 1)], true));
    assert!(client.ping(Firmware::Stock, 1).unwrap().is_some());
    let area = Area {
        ids: 1..=1,
        bauds: vec![],
    };
    let report = scan(&mut client, &area, |_| {}).unwrap();
    assert_eq!(report.found.len(), 1);
    let [trouble] = report.troubles.as_slice() else {
        panic!("{:?}", report.troubles);
    };
    assert!(
        trouble.diagnosis.contains("two servos with one id"),
        "{trouble:?}"
    );
}

/// An answer that begins with 0x83 would: here are an id and gains that are.
#[test]
fn reading_one_servo_never_deafens_the_other() {
    let mut client = connect(&serve(&MORPHEUS_ARM, true));
    let mut first = Servo::find(&mut client, 1).unwrap();
    first.set_id(0x83).unwrap();
    for gain in ["upper_margin", "position_kp", "speed_kd"] {
        assert_eq!(first.write(register(gain), 0x83).unwrap(), Taken::ReadBack);
    }
    for reading in MORPHEUS.registers {
        let mut first = Servo::find(&mut client, 0x83).unwrap();
        first.read(reading).unwrap();
        let second = client.ping(Firmware::Morpheus, 2).unwrap();
        assert!(second.is_some(), "deaf after {}", reading.name);
    }
}

#[test]
fn id_and_settings_change_and_come_back() {
    let mut client = connect(&serve(&MORPHEUS_ARM, true));
    let mut servo = Servo::find(&mut client, 1).unwrap();
    let error = servo.set_id(2).unwrap_err();
    assert!(
        matches!(error, ChangeError::Occupied { id: 2, .. }),
        "{error}"
    );
    let error = servo.set_id(0).unwrap_err();
    assert!(error.to_string().contains("1 to 253"), "{error}");
    servo.set_id(5).unwrap();
    servo.write(register("speed_kp"), 9).unwrap();
    let mut second = Servo::find(&mut client, 2).unwrap();
    second.set_id(1).unwrap();

    // Now id 1 is taken, and a reset would make a second one.
    let mut servo = Servo::find(&mut client, 5).unwrap();
    let error = servo.factory_reset().unwrap_err();
    assert!(
        matches!(error, ChangeError::Occupied { id: 1, .. }),
        "{error}"
    );
    Servo::find(&mut client, 1).unwrap().set_id(2).unwrap();
    let mut servo = Servo::find(&mut client, 5).unwrap();
    servo.factory_reset().unwrap();
    assert_eq!(servo.id(), 1);
    let gain = servo.read(register("speed_kp")).unwrap();
    assert_eq!(gain.value, Value::Known(40));
}

#[test]
fn a_rate_that_cannot_be_followed_is_not_set_unless_insisted_on() {
    let mut client = connect(&serve(&MORPHEUS_ARM, true));
    let mut servo = Servo::find(&mut client, 1).unwrap();
    let error = servo.set_baud(57_600, false).unwrap_err();
    assert!(matches!(error, ChangeError::RateFixed { .. }), "{error}");
    let rate = servo.read(register("baud_rate")).unwrap();
    assert_eq!(rate.value, Value::Known(1));
    assert_eq!(servo.set_baud(57_600, true).unwrap(), Taken::NotReadable);
    let error = Servo::find(&mut client, 1).unwrap_err();
    assert!(error.is_servo_error(), "{error}");
}

/// Every register of a stock servo is read, and every one that can be written
/// takes another value of its range.
#[test]
fn every_register_of_a_stock_servo_is_read_and_written() {
    let mut client = connect(&serve(&STOCK_ARM, true));
    let mut servo = Servo::find(&mut client, 2).unwrap();
    assert_eq!(servo.firmware(), Firmware::Stock);
    let all = servo.read_all().unwrap();
    assert_eq!(all.len(), AX12A.registers.len());
    for reading in all {
        let register = reading.register;
        let Value::Known(value) = reading.value else {
            panic!("{} is cut", register.name);
        };
        assert!(register.range.contains(&value), "{} {value}", register.name);
        let is_special = matches!(
            register.name,
            "id" | "baud_rate" | "lock" | "status_return_level"
        );
        if register.access == Access::Read || is_special || register.unit == Unit::DeciVolt {
            continue;
        }
        let is_most = value == *register.range.end();
        let other = if is_most { value - 1 } else { value + 1 };
        let taken = servo.write(register, other);
        assert_eq!(taken.unwrap(), Taken::ReadBack, "{}", register.name);
    }
}

#[test]
fn a_stock_servo_says_why_it_refuses_and_is_reset() {
    let register = |name| AX12A.by_name(name).unwrap();
    let mut client = connect(&serve(&STOCK_ARM, true));
    let mut servo = Servo::find(&mut client, 1).unwrap();
    servo.write(register("cw_angle_limit"), 300).unwrap();
    servo.write(register("ccw_angle_limit"), 700).unwrap();
    let error = servo.write(register("goal_position"), 800).unwrap_err();
    assert!(error.to_string().contains("angle limit"), "{error}");
    assert!(error.is_servo_error());

    // Silent writes are read back all the same.
    servo.write(register("status_return_level"), 1).unwrap();
    servo.write(register("led"), 1).unwrap();
    for (closing, words) in [("torque_enable", "while torque is on"), ("lock", "locked")] {
        servo.write(register(closing), 1).unwrap();
        let error = servo.write(register("max_torque"), 500).unwrap_err();
        assert!(error.to_string().contains(words), "{error}");
        assert!(error.is_servo_error());
        servo.write(register("torque_enable"), 0).unwrap();
    }

    let mut servo = Servo::find(&mut client, 2).unwrap();
    servo.set_id(7).unwrap();
    servo.write(register("max_torque"), 500).unwrap();
    let mut servo = Servo::find(&mut client, 7).unwrap();
    let error = servo.factory_reset().unwrap_err();
    assert!(
        matches!(error, ChangeError::Occupied { id: 1, .. }),
        "{error}"
    );

    let mut client = connect(&serve(&[(Kind::Stock, 7)], true));
    let mut servo = Servo::find(&mut client, 7).unwrap();
    servo.write(register("max_torque"), 500).unwrap();
    servo.factory_reset().unwrap();
    assert_eq!(servo.id(), 1);
    let torque = servo.read(register("max_torque")).unwrap();
    assert_eq!(torque.value, Value::Known(1023));
}

#[test]
fn both_firmwares_on_one_bus_are_told_apart() {
    let at = serve(
        &[(Kind::Morpheus, 1), (Kind::Stock, 2), (Kind::Stock, 1)],
        false,
    );
    let mut client = connect(&at);
    let area = Area {
        ids: 1..=2,
        bauds: vec![],
    };
    let report = scan(&mut client, &area, |_| {}).unwrap();
    let found: Vec<_> = report.found.iter().map(|it| (it.id, it.firmware)).collect();
    let expected = [
        (1, Firmware::Morpheus),
        (1, Firmware::Stock),
        (2, Firmware::Stock),
    ];
    assert_eq!(found, expected);
    assert!(report.is_mixed());
    let error = Servo::find(&mut client, 1).unwrap_err();
    assert!(
        error.to_string().contains("two servos have id 1"),
        "{error}"
    );
}
