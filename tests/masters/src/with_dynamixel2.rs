//! `dynamixel2`: the instructions, without a table of registers.
//!
//! Its limit of time is 34 ms beyond the bytes, which a busy computer exceeds sometimes, and it takes
//! an answer that comes late for the next one: such a call is repeated after a pause.

use std::thread::sleep;

use dynamixel2::instructions::{BulkReadData, BulkWriteData, SyncWriteData};
use dynamixel2::{ReadError, Response, TransferError};

use crate::check::{self, ATTEMPTS, IDS, PAUSE, Result, expect, part};

type Bus = dynamixel2::Bus<Vec<u8>, Vec<u8>>;

/// Addresses (ROBOTIS e-Manual, "XL430-W250").
const MODEL_NUMBER: u16 = 0;
const RETURN_DELAY: u16 = 9;
const OPERATING_MODE: u16 = 11;
const HOMING_OFFSET: u16 = 20;
const TORQUE_ENABLE: u16 = 64;
const LED: u16 = 65;
const GOAL_PWM: u16 = 100;
const PRESENT_PWM: u16 = 124;
const PRESENT_POSITION: u16 = 132;
const PRESENT_VOLTAGE: u16 = 144;

/// Drives the servos at a port.
pub(crate) fn run(port: &str) -> Result {
    let bus = &mut Bus::open(port, check::BAUD)?;
    part("pings", || pings(bus))?;
    part("reads and writes", || writes(bus))?;
    part("sync reads and writes", || sync(bus))?;
    part("bulk reads and writes", || bulk(bus))?;
    part("registered writes", || registered(bus))?;
    part("drives", || drives(bus))?;
    part("restarts", || restarts(bus))
}

fn is_silence(error: &TransferError) -> bool {
    matches!(error, TransferError::ReadError(ReadError::Io(_)))
}

/// Whether an answer is late, or the late one to another instruction.
fn is_late(error: &TransferError) -> bool {
    let is_other = matches!(
        error,
        TransferError::ReadError(ReadError::InvalidMessage(_))
    );
    is_other || is_silence(error)
}

/// The call's first result in time.
fn again<T>(mut call: impl FnMut() -> Result<T, TransferError>) -> Result<T, TransferError> {
    for _ in 1..ATTEMPTS {
        match call() {
            Err(error) if is_late(&error) => sleep(PAUSE),
            result => return result,
        }
    }
    call()
}

fn byte(bus: &mut Bus, id: u8, address: u16) -> Result<u8> {
    Ok(again(|| bus.read_u8(id, address))?.data)
}

fn word(bus: &mut Bus, id: u8, address: u16) -> Result<u16> {
    Ok(again(|| bus.read_u16(id, address))?.data)
}

fn long(bus: &mut Bus, id: u8, address: u16) -> Result<i32> {
    Ok(again(|| bus.read_u32(id, address))?.data.cast_signed())
}

fn write(bus: &mut Bus, id: u8, address: u16, data: &[u8]) -> Result {
    again(|| bus.write(id, address, data))?;
    if address < TORQUE_ENABLE {
        sleep(check::STORE);
    }
    Ok(())
}

fn pings(bus: &mut Bus) -> Result {
    let answers = bus.scan()?.into_iter();
    let answers = answers.map(|answer| answer.map(|it| (it.motor_id, it.data.model)));
    let found = answers.collect::<Result<Vec<_>, _>>()?;
    let expected = IDS.map(|id| (id, check::MODEL)).to_vec();
    expect("servos found", &found, &expected)?;
    for id in IDS {
        let answer = again(|| bus.ping(id))?;
        let seen = (answer.motor_id, answer.alert, answer.data.model);
        expect("ping", &seen, &(id, false, check::MODEL))?;
        expect("model", &word(bus, id, MODEL_NUMBER)?, &check::MODEL)?;
        check::expect_supply(word(bus, id, PRESENT_VOLTAGE)?)?;
    }
    let absent = bus.ping(check::ABSENT);
    let is_silent = absent.as_ref().is_err_and(is_silence);
    expect("silence of an absent servo", &is_silent, &true)
}

fn writes(bus: &mut Bus) -> Result {
    for id in IDS {
        write(bus, id, TORQUE_ENABLE, &[0])?;
        write(bus, id, LED, &[1])?;
        expect("LED", &byte(bus, id, LED)?, &1)?;
        for offset in [check::STUFFED, 0] {
            write(bus, id, HOMING_OFFSET, &offset.to_le_bytes())?;
            let seen = long(bus, id, HOMING_OFFSET)?;
            expect("homing offset", &seen, &offset)?;
        }
        for (address, data, error) in [
            (OPERATING_MODE, &[check::NO_MODE][..], check::DATA_RANGE),
            (PRESENT_POSITION, &[0; 4], check::ACCESS),
        ] {
            match again(|| bus.write(id, address, data)) {
                Err(TransferError::ReadError(ReadError::MotorError(seen))) => {
                    expect("error of a write", &seen.error_number(), &error)?;
                }
                other => return Err(format!("no error of a write: {other:?}").into()),
            }
        }
    }
    Ok(())
}

/// The servos' answers to an instruction to several, of which those that are missing are errors.
fn all<T>(
    mut call: impl FnMut() -> Result<Vec<Response<T>>, TransferError>,
) -> Result<Vec<Response<T>>, TransferError> {
    // The library has an error for a missing answer, and drops it.
    again(|| match call()? {
        answers if answers.len() < IDS.len() => {
            Err(ReadError::from(std::io::ErrorKind::TimedOut).into())
        }
        answers => Ok(answers),
    })
}

fn sync(bus: &mut Bus) -> Result {
    let leds = [(1, 1), (2, 0)].map(|(motor_id, data)| SyncWriteData { motor_id, data });
    bus.sync_write_u8(LED, &leds)?;
    let seen = all(|| bus.sync_read_u8(&IDS, LED))?;
    let seen: Vec<_> = seen.iter().map(|it| (it.motor_id, it.data)).collect();
    expect("LEDs", &seen, &vec![(1, 1), (2, 0)])?;
    let offsets = [(1, check::STUFFED), (2, 0)];
    let blocks = offsets.map(|(motor_id, offset)| SyncWriteData {
        motor_id,
        data: offset.cast_unsigned(),
    });
    bus.sync_write_u32(HOMING_OFFSET, &blocks)?;
    sleep(check::STORE);
    let seen = all(|| bus.sync_read_u32(&IDS, HOMING_OFFSET))?;
    let seen: Vec<_> = seen.iter().map(|it| it.data.cast_signed()).collect();
    expect("homing offsets", &seen, &vec![check::STUFFED, 0])?;
    write(bus, IDS[0], HOMING_OFFSET, &[0; 4])?;
    let together = all(|| bus.sync_read_u32(&IDS, PRESENT_POSITION))?;
    let together = together.iter().map(|it| it.data.cast_signed().into());
    let together: Vec<i64> = together.collect();
    check::expect_still("sync read", &together, &positions(bus)?)
}

fn positions(bus: &mut Bus) -> Result<Vec<i64>> {
    let position = |id| Ok(long(bus, id, PRESENT_POSITION)?.into());
    IDS.into_iter().map(position).collect()
}

fn bulk(bus: &mut Bus) -> Result {
    let items = [(1, LED, vec![0]), (2, RETURN_DELAY, vec![100])];
    let items = items.map(|(motor_id, address, data)| BulkWriteData {
        motor_id,
        address,
        data,
    });
    bus.bulk_write(&items)?;
    sleep(check::STORE);
    // A servo each: 0.9.1 puts the blocks of several one byte apart, where they take five.
    for (motor_id, address, expected) in [(1, LED, 0), (2, RETURN_DELAY, 100)] {
        let read = BulkReadData {
            motor_id,
            address,
            count: 1,
        };
        let seen = again(|| bus.bulk_read(&[&read]))?;
        let seen: Vec<_> = seen.into_iter().map(|it| (it.motor_id, it.data)).collect();
        expect("bulk read", &seen, &vec![(motor_id, vec![expected])])?;
    }
    Ok(())
}

fn registered(bus: &mut Bus) -> Result {
    for id in IDS {
        write(bus, id, LED, &[0])?;
        again(|| bus.reg_write(id, LED, &[1]))?;
        expect("LED before the action", &byte(bus, id, LED)?, &0)?;
    }
    // Both, if they are repeated: an action leaves nothing registered.
    again(|| {
        bus.reg_write(IDS[0], LED, &[1])?;
        bus.action(IDS[0])
    })?;
    bus.broadcast_action()?;
    for id in IDS {
        expect("LED after the action", &byte(bus, id, LED)?, &1)?;
    }
    Ok(())
}

/// A motor by PWM, forth and back.
fn drives(bus: &mut Bus) -> Result {
    let id = IDS[1];
    write(bus, id, TORQUE_ENABLE, &[0])?;
    write(bus, id, OPERATING_MODE, &[check::PWM_MODE])?;
    write(bus, id, TORQUE_ENABLE, &[1])?;
    for direction in [1, -1] {
        let pwm = direction * check::PWM;
        write(bus, id, GOAL_PWM, &pwm.to_le_bytes())?;
        let seen = word(bus, id, GOAL_PWM)?.cast_signed();
        expect("goal PWM", &seen, &pwm)?;
        let position = || Ok(long(bus, id, PRESENT_POSITION)?.into());
        check::wait_until_moved(direction.into(), position)?;
        let seen = word(bus, id, PRESENT_PWM)?.cast_signed();
        expect("present PWM", &seen, &pwm)?;
    }
    write(bus, id, TORQUE_ENABLE, &[0])?;
    expect("torque", &byte(bus, id, TORQUE_ENABLE)?, &0)?;
    let seen = word(bus, id, PRESENT_PWM)?;
    expect("present PWM with torque off", &seen, &0)
}

fn restarts(bus: &mut Bus) -> Result {
    let id = IDS[0];
    again(|| bus.reboot(id))?;
    sleep(check::BOOT);
    expect("LED after it", &byte(bus, id, LED)?, &0)
}
