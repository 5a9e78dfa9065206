//! Registers that the bridge itself needs, by their addresses (e-Manual, "AX-12A",
//! control table).

/// The servo's id.
pub const ID: u16 = 3;
/// Return delay, in units of 2 µs.
pub const RETURN_DELAY: u16 = 5;
/// Angle limits, clockwise then counter-clockwise, two bytes each: all 0
/// for wheel mode, in which the moving speed is the motor's duty.
pub const ANGLE_LIMITS: u16 = 6;
/// Torque limit at power-up, two bytes.
pub const MAX_TORQUE: u16 = 14;
/// Condition for a status packet: 0 after PING, 1 after READ too, 2 always.
pub const STATUS_RETURN_LEVEL: u16 = 16;
/// Torque on or off.
pub const TORQUE_ENABLE: u16 = 24;
/// Lamp on or off.
pub const LED: u16 = 25;
/// Wheel mode: duty 0..=1023, bit 10 for clockwise. The torque limit follows.
pub const MOVING_SPEED: u16 = 32;
/// Position 0..=1023, two bytes.
pub const PRESENT_POSITION: u16 = 36;
/// Temperature, one byte, in °C.
pub const PRESENT_TEMPERATURE: u16 = 43;

/// The registers of two bytes, bit n for the one at address n: model number,
/// angle limits, maximum torque; goal, moving speed, torque limit, position,
/// speed, load; punch.
pub(super) const WORDS: u64 = 1 | 1 << 6 | 1 << 8 | 1 << 14 | 0b101_0101_0101 << 30 | 1 << 48;
