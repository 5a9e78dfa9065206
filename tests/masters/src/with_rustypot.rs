//! `rustypot`: its controller of the XL430, with its own table of registers.
//!
//! Its limit of time is the port's, and long enough here for a busy computer.

use std::thread::sleep;
use std::time::Duration;

use rustypot::servo::dynamixel::xl430::Xl430Controller;

use crate::check::{self, IDS, Result, expect, part};

const TIMEOUT: Duration = Duration::from_secs(1);
const TIMEOUT_OF_ABSENT: Duration = Duration::from_millis(100);

/// Drives the servos at a port.
pub(crate) fn run(port: &str) -> Result {
    let port = serialport::new(port, check::BAUD).timeout(TIMEOUT).open()?;
    let servos = Xl430Controller::new().with_protocol_v2();
    let servos = &mut servos.with_serial_port(port);
    part("pings", || pings(servos))?;
    part("reads and writes", || writes(servos))?;
    part("sync reads and writes", || groups(servos))?;
    part("fast sync reads", || fast_groups(servos))?;
    part("drives", || drives(servos))?;
    part("restarts", || restarts(servos))
}

fn pings(servos: &mut Xl430Controller) -> Result {
    let found = servos.broadcast_scan_all()?;
    let expected = IDS.map(|id| (id, check::MODEL)).into();
    expect("servos found", &found, &expected)?;
    for id in IDS {
        expect("ping", &servos.ping(id)?, &true)?;
        expect("model", &servos.read_model_number(id)?, &vec![check::MODEL])?;
        check::expect_supply(servos.read_present_input_voltage(id)?[0])?;
    }
    servos.set_timeout(TIMEOUT_OF_ABSENT)?;
    let absent = servos.ping(check::ABSENT);
    servos.set_timeout(TIMEOUT)?;
    expect("ping of an absent servo", &absent?, &false)
}

fn writes(servos: &mut Xl430Controller) -> Result {
    for id in IDS {
        servos.write_torque_enable(id, 0)?;
        servos.write_led(id, 1)?;
        expect("LED", &servos.read_led(id)?, &vec![1])?;
        for offset in [check::STUFFED, 0] {
            servos.write_homing_offset(id, offset)?;
            sleep(check::STORE);
            let seen = servos.read_homing_offset(id)?;
            expect("homing offset", &seen, &vec![offset])?;
        }
        for (name, value, error) in [
            ("operating_mode", check::NO_MODE, check::DATA_RANGE),
            ("present_position", 0, check::ACCESS),
        ] {
            let table = rustypot::servo::dynamixel::xl430::register(name);
            let register = table.ok_or("no such register")?;
            let data = vec![value; register.size.into()];
            let seen = servos.write_raw_data_with_error(id, register.addr, data)?;
            expect("error of a write", &seen.v2_instruction_error(), &error)?;
        }
    }
    Ok(())
}

fn groups(servos: &mut Xl430Controller) -> Result {
    servos.sync_write_led(&IDS, &[1, 0])?;
    expect("LEDs", &servos.sync_read_led(&IDS)?, &vec![1, 0])?;
    servos.sync_write_homing_offset(&IDS, &[check::STUFFED, 0])?;
    sleep(check::STORE);
    let seen = servos.sync_read_homing_offset(&IDS)?;
    expect("homing offsets", &seen, &vec![check::STUFFED, 0])?;
    servos.write_homing_offset(IDS[0], 0)?;
    sleep(check::STORE);
    let together = servos.sync_read_register(&IDS, "present_position")?;
    check::expect_still("sync read", &together, &positions(servos)?)
}

fn fast_groups(servos: &mut Xl430Controller) -> Result {
    servos.write_homing_offset(IDS[0], check::STUFFED)?;
    sleep(check::STORE);
    servos.set_fast_sync_read(true);
    // Not stuffed in a joint answer.
    let offsets = servos.sync_read_homing_offset(&IDS)?;
    servos.set_fast_sync_read(false);
    expect("homing offsets", &offsets, &vec![check::STUFFED, 0])?;
    servos.write_homing_offset(IDS[0], 0)?;
    sleep(check::STORE);
    servos.set_fast_sync_read(true);
    let together = servos.sync_read_register(&IDS, "present_position")?;
    servos.set_fast_sync_read(false);
    check::expect_still("fast sync read", &together, &positions(servos)?)
}

fn positions(servos: &mut Xl430Controller) -> Result<Vec<i64>> {
    let position = |id| servos.read_register(id, "present_position");
    IDS.into_iter().map(position).collect()
}

/// A motor by PWM, forth and back.
fn drives(servos: &mut Xl430Controller) -> Result {
    let id = IDS[1];
    servos.write_torque_enable(id, 0)?;
    servos.write_operating_mode(id, check::PWM_MODE)?;
    sleep(check::STORE);
    servos.write_torque_enable(id, 1)?;
    for direction in [1, -1] {
        let pwm = direction * i64::from(check::PWM);
        servos.write_register(id, "goal_pwm", pwm)?;
        let seen = servos.read_register(id, "goal_pwm")?;
        expect("goal PWM", &seen, &pwm)?;
        check::wait_until_moved(direction, || servos.read_register(id, "present_position"))?;
        let seen = servos.read_register(id, "present_pwm")?;
        expect("present PWM", &seen, &pwm)?;
    }
    servos.write_torque_enable(id, 0)?;
    expect("torque", &servos.read_torque_enable(id)?, &vec![0])?;
    let seen = servos.read_register(id, "present_pwm")?;
    expect("present PWM with torque off", &seen, &0)
}

fn restarts(servos: &mut Xl430Controller) -> Result {
    let id = IDS[0];
    expect("reboot", &servos.reboot(id)?, &true)?;
    sleep(check::BOOT);
    expect("LED after it", &servos.read_led(id)?, &vec![0])
}
