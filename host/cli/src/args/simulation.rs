//! The simulated arm and its servos.

use armbridge_board::bridge::SERVO_IDS;
use armbridge_servo::{Firmware, JOINTS};
use armbridge_sim::servo_kind;
use armbridge_sim::servo_kind::{KindError, ServoKind};
use clap::Args;

use super::suggestions::plants;
use super::values::{angles, seed};

/// The virtual arm.
#[derive(Args, Clone, Debug)]
pub(crate) struct ArmArgs {
    /// Seed of the encoder noise.
    #[arg(long, default_value_t = 1, value_parser = seed)]
    pub(crate) seed: u64,
    /// Joint angles in rad at which the arm is held until torque comes on
    /// [default: 0.3,-0.25, or as the plant file sets them].
    #[arg(long, value_name = "RAD,RAD", value_parser = angles, allow_hyphen_values = true)]
    pub(crate) initial: Option<[f64; 2]>,
    /// Virtual arm: the name of one that ships (`armbridge plants`), or a file.
    #[arg(long, value_name = "NAME|FILE", value_parser = plants(), hide_possible_values = true)]
    pub(crate) plant: Option<String>,
    /// Simulate the arm without dry friction.
    #[arg(long)]
    pub(crate) no_friction: bool,
}

/// The virtual servos that move the arm.
#[derive(Args, Clone, Debug)]
pub(crate) struct VirtualServoArgs {
    /// Firmware of the two servos: morpheus, stock, x for the X series, or one for
    /// each, as in stock,morpheus [default: morpheus, or x if the arm has its encoders].
    #[arg(
        long,
        value_name = "NAME[,NAME]",
        value_delimiter = ',',
        value_parser = servo_kind::firmware,
    )]
    firmware: Vec<Firmware>,
    /// Baud rate stored in the servos [default: 1000000].
    #[arg(long, value_name = "BAUD")]
    servo_baud: Option<u32>,
}

/// Why the two servos cannot be made.
#[derive(Debug, thiserror::Error)]
pub(crate) enum VirtualServoError {
    /// More firmwares than servos.
    #[error(
        "{0} values after --firmware: the arm has two servos, expected one value, or one for each"
    )]
    Count(usize),
    /// No such servo.
    #[error(transparent)]
    Kind(#[from] KindError),
}

impl VirtualServoArgs {
    /// The servos, with the ids that the board looks for; `own` is the firmware of those whose
    /// encoders the arm has.
    pub(crate) fn kinds(&self, own: Firmware) -> Result<Vec<ServoKind>, VirtualServoError> {
        let firmware = self.firmware()?.unwrap_or([own; JOINTS]);
        let baud = self.baud().unwrap_or(1_000_000);
        let servos = SERVO_IDS.iter().zip(firmware);
        servos
            .map(|(id, firmware)| Ok(ServoKind::new(firmware, id.get(), baud)?))
            .collect()
    }

    /// Firmware of the servos, if the option is given.
    pub(crate) fn firmware(&self) -> Result<Option<[Firmware; JOINTS]>, VirtualServoError> {
        match self.firmware.as_slice() {
            [] => Ok(None),
            each if each.len() > JOINTS => Err(VirtualServoError::Count(each.len())),
            each => Ok(Some(core::array::from_fn(|joint| each[joint % each.len()]))),
        }
    }

    /// Baud rate of the servos, if the option is given.
    pub(crate) fn baud(&self) -> Option<u32> {
        self.servo_baud
    }
}
