//! Control mode of the servos: what a command is.

#[cfg(feature = "postcard")]
use postcard::experimental::max_size::MaxSize;
#[cfg(feature = "postcard")]
use postcard_schema::Schema;
#[cfg(feature = "postcard")]
use serde::{Deserialize, Serialize};

/// What the counts of a command are, which every [`Pwm`](crate::Pwm) has whatever its name says.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "postcard", derive(Serialize, Deserialize, Schema, MaxSize))]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum ControlMode {
    /// Thousandths of full duty, the voltage on the motor: any servo.
    #[default]
    Pwm,
    /// Counts of the goal current, 1 mA each, of an XM430 2.69 mA: X servos that measure the
    /// current. The torque depends on neither speed nor supply, up to the duty that it takes.
    Current,
}
