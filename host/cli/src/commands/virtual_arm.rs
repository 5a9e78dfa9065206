//! The virtual arm of a command's options.

use armbridge_control::arm::State;
use armbridge_servo::JOINTS;
use armbridge_sim::plant::{Plant, PlantConfig, PlantFile};

use super::Error;
use crate::args::ArmArgs;

/// Default initial angles in rad.
const INITIAL_RAD: [f64; JOINTS] = [0.30, -0.25];

/// The virtual arm, held at its initial angles.
pub(super) fn plant(args: &ArmArgs) -> Result<Plant, Error> {
    Ok(Plant::new(config(args)?, args.seed))
}

/// Its configuration.
pub(super) fn config(args: &ArmArgs) -> Result<PlantConfig, Error> {
    let mut plant = match &args.plant {
        Some(name) => PlantFile::load(name)?.config(INITIAL_RAD),
        None => PlantConfig {
            initial: State::at_rest(INITIAL_RAD.into()),
            ..PlantConfig::default()
        },
    };
    if let Some(initial) = args.initial {
        plant.initial.q = initial.into();
    }
    if args.no_friction {
        plant.friction_on = false;
    }
    Ok(plant)
}
