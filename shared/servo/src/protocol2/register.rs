//! Registers of the X series by their addresses (e-Manual, control tables of XL330, XC330,
//! XL430 and XM430, which agree in these).
//!
//! Those below 64 are EEPROM, and can be written while torque is off only. Numbers are little
//! endian, and signed where they can be negative. Units differ by model, see
//! [`model`](super::model).

/// Model number, two bytes.
pub const MODEL_NUMBER: u16 = 0;
/// Model information, four bytes, which the e-Manual does not explain.
pub const MODEL_INFORMATION: u16 = 2;
/// Version of the firmware.
pub const FIRMWARE_VERSION: u16 = 6;
/// The servo's id, 0 to 252.
pub const ID: u16 = 7;
/// Code of the baud rate, see [`baud_rate`](super::model::baud_rate).
pub const BAUD_RATE: u16 = 8;
/// Return delay, in units of 2 µs; 250 from the factory.
pub const RETURN_DELAY: u16 = 9;
/// Bit 0: direction of rotation; bit 2: what the profile means.
pub const DRIVE_MODE: u16 = 10;
/// Its bit by which a goal enables torque.
pub const TORQUE_BY_GOAL: u8 = 1 << 3;
/// See [`OperatingMode`](super::model::OperatingMode).
pub const OPERATING_MODE: u16 = 11;
/// Second id to which the servo listens without an answer; above 252 for none.
pub const SHADOW_ID: u16 = 12;
/// Protocol that the servo speaks; 2 for Protocol 2.0.
pub const PROTOCOL_TYPE: u16 = 13;
/// Offset that is added to the position, in counts, four bytes.
pub const HOMING_OFFSET: u16 = 20;
/// Speed above which [`MOVING`] is set, four bytes.
pub const MOVING_THRESHOLD: u16 = 24;
/// Highest temperature, in °C.
pub const TEMPERATURE_LIMIT: u16 = 31;
/// Highest supply, in 0.1 V, two bytes.
pub const MAX_VOLTAGE_LIMIT: u16 = 32;
/// Lowest supply, in 0.1 V, two bytes.
pub const MIN_VOLTAGE_LIMIT: u16 = 34;
/// Largest duty, two bytes.
pub const PWM_LIMIT: u16 = 36;
/// Largest current, two bytes, of models that measure it.
pub const CURRENT_LIMIT: u16 = 38;
/// Largest speed, four bytes.
pub const VELOCITY_LIMIT: u16 = 44;
/// Largest goal of position control mode, four bytes.
pub const MAX_POSITION_LIMIT: u16 = 48;
/// Smallest goal of position control mode, four bytes.
pub const MIN_POSITION_LIMIT: u16 = 52;
/// Bit 0: torque on at power-up; bit 1: RAM restored at power-up.
pub const STARTUP_CONFIGURATION: u16 = 60;
/// Slope of the duty, of XL330 and XC330.
pub const PWM_SLOPE: u16 = 62;
/// Hardware errors that switch torque off, as bits of [`HARDWARE_ERROR`].
pub const SHUTDOWN: u16 = 63;
/// Torque on or off.
pub const TORQUE_ENABLE: u16 = 64;
/// Lamp on or off.
pub const LED: u16 = 65;
/// Condition for a status packet: 0 after PING, 1 after reads too, 2 always.
pub const STATUS_RETURN_LEVEL: u16 = 68;
/// Whether an instruction waits for ACTION.
pub const REGISTERED_INSTRUCTION: u16 = 69;
/// Errors of the hardware: bit 0 supply, 2 heat, 3 encoder, 4 electrical shock, 5 overload.
pub const HARDWARE_ERROR: u16 = 70;
/// Integral gain of velocity control, two bytes.
pub const VELOCITY_I_GAIN: u16 = 76;
/// Proportional gain of velocity control, two bytes.
pub const VELOCITY_P_GAIN: u16 = 78;
/// Differential gain of position control, two bytes.
pub const POSITION_D_GAIN: u16 = 80;
/// Integral gain of position control, two bytes.
pub const POSITION_I_GAIN: u16 = 82;
/// Proportional gain of position control, two bytes.
pub const POSITION_P_GAIN: u16 = 84;
/// Feedforward of the acceleration, two bytes.
pub const FEEDFORWARD_2ND_GAIN: u16 = 88;
/// Feedforward of the speed, two bytes.
pub const FEEDFORWARD_1ST_GAIN: u16 = 90;
/// Silence of the bus in units of 20 ms after which the servo stops, 1 to 127; 0 for never, 255
/// after it has.
pub const BUS_WATCHDOG: u16 = 98;
/// Duty in PWM control mode, two bytes.
pub const GOAL_PWM: u16 = 100;
/// Current in current control mode, two bytes.
pub const GOAL_CURRENT: u16 = 102;
/// Speed in velocity control mode, four bytes.
pub const GOAL_VELOCITY: u16 = 104;
/// Acceleration of the profile, four bytes; 0 for none.
pub const PROFILE_ACCELERATION: u16 = 108;
/// Speed of the profile, four bytes; 0 for none.
pub const PROFILE_VELOCITY: u16 = 112;
/// Position in the position control modes, four bytes.
pub const GOAL_POSITION: u16 = 116;
/// Milliseconds, modulo 32 768, two bytes.
pub const REALTIME_TICK: u16 = 120;
/// Whether it moves.
pub const MOVING: u16 = 122;
/// Details of the motion, as bits.
pub const MOVING_STATUS: u16 = 123;
/// Duty on the motor, two bytes.
pub const PRESENT_PWM: u16 = 124;
/// Current, of models that measure it, else an estimated load; two bytes.
pub const PRESENT_CURRENT: u16 = 126;
/// Speed, four bytes.
pub const PRESENT_VELOCITY: u16 = 128;
/// Position in counts, of several turns, four bytes.
pub const PRESENT_POSITION: u16 = 132;
/// Speed that the profile wants, four bytes.
pub const VELOCITY_TRAJECTORY: u16 = 136;
/// Position that the profile wants, four bytes.
pub const POSITION_TRAJECTORY: u16 = 140;
/// Supply in 0.1 V, two bytes.
pub const PRESENT_VOLTAGE: u16 = 144;
/// Temperature in °C.
pub const PRESENT_TEMPERATURE: u16 = 146;
/// Whether there is a backup of the control table.
pub const BACKUP_READY: u16 = 147;
/// First of the indirect addresses, two bytes each; behind them are the indirect data.
pub const INDIRECT_ADDRESS: u16 = 168;
/// End of the registers that the bridge reads, exclusive.
pub const END: u16 = PRESENT_TEMPERATURE + 1;

/// Registers of several bytes: address of the first, their number, and the bytes of each.
const WIDE: [(u16, u16, u16); 14] = [
    (MODEL_NUMBER, 1, 2),
    (2, 1, 4),
    (HOMING_OFFSET, 2, 4),
    (MAX_VOLTAGE_LIMIT, 4, 2),
    (44, 3, 4),
    (VELOCITY_I_GAIN, 2, 2),
    (POSITION_D_GAIN, 3, 2),
    (FEEDFORWARD_2ND_GAIN, 2, 2),
    (GOAL_PWM, 2, 2),
    (GOAL_VELOCITY, 4, 4),
    (REALTIME_TICK, 1, 2),
    (PRESENT_PWM, 2, 2),
    (PRESENT_VELOCITY, 4, 4),
    (PRESENT_VOLTAGE, 1, 2),
];

/// Address of the first byte of the register that has a byte at `address`.
pub(super) fn start(address: u16) -> u16 {
    let wide = WIDE
        .iter()
        .find(|(first, number, bytes)| (*first..*first + number * bytes).contains(&address));
    wide.map_or(address, |(first, _, bytes)| {
        address - (address - first) % (*bytes).max(1)
    })
}
