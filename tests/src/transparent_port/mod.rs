//! A servo bus that the control loop and a client of the transparent port share.

pub mod client;
pub mod loops;

use crate::with_encoders;
use armbridge_servo::Firmware;
use armbridge_sim::Bench;
use armbridge_sim::plant::{Plant, PlantConfig};
use armbridge_sim::servo_kind::ServoKind;

/// An arm with these servos, ids 1 and 2.
pub fn bench(config: &PlantConfig, firmware: [Firmware; 2], baud: u32) -> Bench {
    let kinds = [0, 1].map(|joint| ServoKind::new(firmware[joint], joint as u8 + 1, baud).unwrap());
    Bench::with_servos(Plant::new(with_encoders(*config, firmware[0]), 1), &kinds)
}
