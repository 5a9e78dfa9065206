//! What is around the board on the bench: its servos, and its second port.

use armbridge_client::endpoint::Endpoint;
use armbridge_shared::bridge::SERVO_IDS;
use armbridge_shared::servo::Firmware;
use armbridge_sim::kind;
use armbridge_sim::kind::{KindError, ServoKind};
use clap::Args;

/// The virtual servos that move the arm.
#[derive(Args, Clone, Debug)]
pub(crate) struct VirtualServoArgs {
    /// What runs on the two servos: morpheus or stock, or one each, as
    /// stock,morpheus.
    #[arg(
        long,
        value_name = "NAME[,NAME]",
        value_delimiter = ',',
        value_parser = kind::firmware,
        default_value = "morpheus"
    )]
    firmware: Vec<Firmware>,
    /// Baud rate that is stored in the servos.
    #[arg(long, value_name = "BAUD", default_value_t = 1_000_000)]
    servo_baud: u32,
}

impl VirtualServoArgs {
    /// The servos that are asked for, with the ids that the board looks for.
    pub(crate) fn kinds(&self) -> Result<Vec<ServoKind>, KindError> {
        let firmwares = self.firmware.iter().cycle();
        SERVO_IDS
            .iter()
            .zip(firmwares)
            .map(|(id, firmware)| ServoKind::new(*firmware, id.get(), self.servo_baud))
            .collect()
    }
}

/// The board's transparent port.
#[derive(Args, Clone, Debug)]
pub(crate) struct TransparentArgs {
    /// Offer the board's transparent port, which behaves as the vendor's USB adapter,
    /// to other programs. Time is then held back to the wall clock.
    #[arg(
        long,
        value_name = "tcp://HOST:PORT",
        conflicts_with = "transparent_pty"
    )]
    pub(crate) transparent_listen: Option<Endpoint>,
    /// The same on a new pseudo-terminal, whose name is printed.
    #[arg(long)]
    pub(crate) transparent_pty: bool,
    /// Leave the arm alone: nobody but the transparent port's program uses the
    /// bus. Ends with ctrl-c.
    #[arg(long)]
    pub(crate) disarmed: bool,
}
