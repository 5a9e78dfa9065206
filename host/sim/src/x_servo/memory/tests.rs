//! Checks of writes, indirect addresses, and what is kept over a power cycle.

use super::super::specification;
use super::*;
use armbridge_servo::protocol2::model;

fn memory(number: u16) -> Memory {
    let model = model::find(number).unwrap();
    Memory::new(model, specification::find(model))
}

fn error(memory: &Memory, address: u16, data: &[u8]) -> Option<StatusError> {
    memory.check(address, data, false).err()
}

fn write(memory: &mut Memory, address: u16, data: &[u8]) {
    let writes = memory.check(address, data, false).unwrap();
    memory.write(&writes);
}

#[test]
fn each_error_has_its_condition() {
    let mut xl430 = memory(1060);
    let access = Some(StatusError::Access);
    // Only read, undefined, beyond the end, and across a gap.
    for address in [at::PRESENT_POSITION, 14, 660, 0xFFFF] {
        assert_eq!(error(&xl430, address, &[0; 4]), access, "{address}");
    }
    assert_eq!(error(&xl430, at::LED, &[0, 0]), access);
    // It has no current register.
    assert_eq!(error(&xl430, at::GOAL_CURRENT, &[0, 0]), access);
    let length = Some(StatusError::DataLength);
    assert_eq!(error(&xl430, at::GOAL_POSITION, &[0, 0]), length);
    assert_eq!(error(&xl430, at::GOAL_POSITION + 1, &[0, 0, 0]), length);
    assert_eq!(xl430.read(at::GOAL_PWM, 0), Err(StatusError::DataLength));
    let range = Some(StatusError::DataRange);
    assert_eq!(error(&xl430, at::ID, &[253]), range);
    assert_eq!(error(&xl430, at::OPERATING_MODE, &[0]), range);
    assert_eq!(error(&memory(1200), at::OPERATING_MODE, &[0]), None);
    assert_eq!(error(&xl430, at::GOAL_PWM, &886_i16.to_le_bytes()), range);
    assert_eq!(error(&xl430, at::BUS_WATCHDOG, &[0xFF]), range);
    write(&mut xl430, at::PWM_LIMIT, &[100, 0]);
    let limit = Some(StatusError::DataLimit);
    assert_eq!(
        error(&xl430, at::GOAL_PWM, &(-101_i16).to_le_bytes()),
        limit
    );
    assert_eq!(error(&xl430, at::GOAL_PWM, &(-100_i16).to_le_bytes()), None);
    assert_eq!(
        error(&xl430, at::GOAL_POSITION, &4_096_i32.to_le_bytes()),
        limit
    );
    write(&mut xl430, at::OPERATING_MODE, &[4]);
    assert_eq!(
        error(&xl430, at::GOAL_POSITION, &4_096_i32.to_le_bytes()),
        None
    );
}

#[test]
fn torque_and_the_secondary_id_close_the_eeprom() {
    let mut memory = memory(1020);
    assert!(memory.check(at::ID, &[2], true).is_err());
    assert!(memory.check(at::LED, &[1], true).is_ok());
    write(&mut memory, at::TORQUE_ENABLE, &[1]);
    assert_eq!(error(&memory, at::ID, &[2]), Some(StatusError::Access));
    write(&mut memory, at::TORQUE_ENABLE, &[0]);
    assert_eq!(error(&memory, at::ID, &[2]), None);
}

#[test]
fn indirect_data_are_those_of_their_address() {
    for (number, data) in [(1060, 224), (1200, 208)] {
        let mut memory = memory(number);
        // The examples of the e-Manual: LED, and the four bytes of the goal position.
        write(&mut memory, at::INDIRECT_ADDRESS, &at::LED.to_le_bytes());
        write(&mut memory, data, &[1]);
        assert_eq!(memory.byte(at::LED), 1);
        assert_eq!(error(&memory, data, &[2]), Some(StatusError::DataRange));
        for index in 0..4 {
            let address = at::INDIRECT_ADDRESS + 2 * (1 + index);
            write(
                &mut memory,
                address,
                &(at::GOAL_POSITION + index).to_le_bytes(),
            );
        }
        write(&mut memory, data + 1, &1_024_i32.to_le_bytes());
        assert_eq!(memory.long(at::GOAL_POSITION), 1_024);
        assert_eq!(memory.read(data, 5), Ok(vec![1, 0, 4, 0, 0]));
        let half = error(&memory, data + 1, &[0, 0]);
        assert_eq!(half, Some(StatusError::DataLength));
        // The others have bytes of their own.
        write(&mut memory, data + 5, &[9]);
        assert_eq!(memory.read(data + 5, 2), Ok(vec![9, 0]));
    }
}

#[test]
fn power_off_forgets_the_ram_alone() {
    let mut memory = memory(1060);
    write(&mut memory, at::PWM_LIMIT, &[44, 1]);
    write(&mut memory, at::POSITION_P_GAIN, &[1, 0]);
    memory.power_up();
    assert_eq!(memory.value(at::GOAL_PWM), Some(300));
    assert_eq!(memory.value(at::POSITION_P_GAIN), Some(640));
    memory.reset_eeprom();
    assert_eq!(memory.value(at::PWM_LIMIT), Some(885));
}
