//! Arguments that several commands take.

mod bus;
mod expose;
mod force;
mod link;
pub(crate) mod listen;
mod output;
mod scenario;
mod simulation;
pub(crate) mod suggestions;
mod task;
pub(crate) mod values;

pub(crate) use bus::{BusArgs, baud, patience};
pub(crate) use expose::ExposeArgs;
pub(crate) use force::ForceArgs;
pub(crate) use link::{LinkArgs, PaceName, SessionArgs};
pub(crate) use output::OutputArgs;
pub(crate) use scenario::{ScenarioArgs, ScenarioArmArgs};
pub(crate) use simulation::{ArmArgs, VirtualServoArgs};
pub(crate) use task::TaskArgs;
