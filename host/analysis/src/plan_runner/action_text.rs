//! Descriptions of steps.

use armbridge_control::experiment::Signal;
use armbridge_link::experiment::{Experiment, Role};
use armbridge_link::message::Command;
use armbridge_link::motion::Motion;

use super::plan::Action;

impl Action {
    /// Description in one line, without a full stop.
    pub fn in_words(&self) -> String {
        match self {
            Self::Command(command) => command_text(command),
            Self::Arm => "arm again".into(),
            Self::Change(_) => "change settings".into(),
            Self::Stream(points) => format!("follow {} points", points.len()),
        }
    }
}

/// A command in one line, without a full stop.
pub(crate) fn command_text(command: &Command) -> String {
    match command {
        Command::Idle => "motors off".into(),
        Command::Torque([first, second]) => {
            format!("torques of {first:+.3} and {second:+.3} N m")
        }
        Command::Regulate([first, second]) => {
            format!("hold at {first:+.2} and {second:+.2} rad")
        }
        Command::Follow(motion) => match motion {
            Motion::MinimumJerk {
                to_rad: [first, second],
                ..
            } => format!("move to {first:+.2} and {second:+.2} rad"),
            Motion::Waypoints(_) => "move through waypoints".into(),
            Motion::Sinusoid { .. } => "follow a sinusoid".into(),
            Motion::Chirp { .. } => "follow a chirp".into(),
        },
        Command::Stream { .. } => "follow a point".into(),
        Command::Experiment(plan) => experiment_text(plan),
        Command::Float => "float, led by hand".into(),
        Command::Park => "park".into(),
        Command::Arm { .. } => "arm again".into(),
        Command::Prepare => "prepare the servos".into(),
        Command::Release => "release the servos".into(),
        Command::ClearFault => "clear a fault".into(),
        Command::Configure(_) | Command::Limit(_) => "change settings".into(),
        Command::Save => "save the settings".into(),
    }
}

fn experiment_text(plan: &Experiment) -> String {
    let [first, second] = plan.roles.map(|role| role_text(&role));
    if first == second {
        format!("both joints: {first}")
    } else {
        format!("joint 1 {first}, joint 2 {second}")
    }
}

fn role_text(role: &Role) -> String {
    let (quantity, signal) = match role {
        Role::Off => return "off".into(),
        Role::Hold => return "held".into(),
        Role::Pwm(signal) => ("PWM", signal),
        Role::Bias(signal) => ("held PWM and", signal),
        Role::Torque(signal) => ("torque", signal),
        Role::Angle(signal) => ("angle", signal),
    };
    let shape = match signal {
        Signal::Constant(_) => "constant",
        Signal::Triangle { .. } => "triangle",
        Signal::Staircase { .. } => "staircase",
        Signal::Steps { .. } => "pulses",
        Signal::Sinusoid { .. } => "sinusoid",
        Signal::Chirp { .. } => "chirp",
        Signal::Multisine { .. } => "multisine",
        Signal::Prbs { .. } => "PRBS",
    };
    format!("{quantity} {shape}")
}
