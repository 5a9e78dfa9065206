//! The virtual arm of a command's options.

use armbridge_sim::plant::{PlantConfig, PlantFile};

use super::Error;
use crate::args::ArmArgs;

/// The virtual arm, held at its initial angles.
pub(super) fn config(args: &ArmArgs) -> Result<PlantConfig, Error> {
    let mut plant = PlantFile::arm(args.plant.as_deref(), args.initial)?;
    if args.no_friction {
        plant.friction_on = false;
    }
    Ok(plant)
}
