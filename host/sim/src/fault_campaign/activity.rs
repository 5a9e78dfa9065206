//! Activities: the board's work when a fault comes.

use std::str::FromStr;

use armbridge_control::controller::float;
use armbridge_control::experiment::Signal;
use armbridge_control::trajectory::WAYPOINTS_MAX;
use armbridge_link::experiment::{Experiment, Role};
use armbridge_link::message::Command;
use armbridge_link::motion::{Motion, Via};
use armbridge_servo::JOINTS;
use serde::{Deserialize, Serialize};

/// Torque in N m that dry friction holds, near upright.
const SMALL_NM: f32 = 0.01;
/// Torque in N m with which an arm presses against an obstacle; less than what is sure to
/// move a joint.
const PRESSING_NM: f32 = 0.2;

/// Work of the board.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Deserialize, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Activity {
    /// It holds the arm at an angle near upright, after a step there.
    Regulate,
    /// The arm follows a sine.
    Sine,
    /// The arm moves from point to point.
    MinimumJerk,
    /// The arm moves through several points.
    Waypoints,
    /// The arm follows points that the host sends all the time.
    Stream,
    /// A constant torque, which friction or an obstacle holds, and which the host repeats.
    Torque,
    /// An experiment: one joint by torque or PWM, the other one held.
    Experiment,
    /// Armed, with zero torque; dry friction holds the arm.
    Armed,
    /// Disarmed; dry friction holds the arm.
    Idle,
    /// The settings are saved again and again; disarmed.
    Save,
    /// A client of the transparent port drives the motors.
    Port,
    /// The servos are still searched; then the board regulates.
    BringUp,
    /// The arm is weightless. Never drawn: the seeds of all others stay as they are.
    Float,
}

impl Activity {
    /// Those that seeds draw.
    pub const DRAWN: [Self; 12] = [
        Self::Regulate,
        Self::Sine,
        Self::MinimumJerk,
        Self::Waypoints,
        Self::Stream,
        Self::Torque,
        Self::Experiment,
        Self::Armed,
        Self::Idle,
        Self::Save,
        Self::Port,
        Self::BringUp,
    ];

    /// All activities.
    pub fn all() -> impl Iterator<Item = Self> {
        Self::DRAWN.into_iter().chain([Self::Float])
    }

    /// Name in tables.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Regulate => "regulate",
            Self::Sine => "sine",
            Self::MinimumJerk => "minimum-jerk",
            Self::Waypoints => "waypoints",
            Self::Stream => "stream",
            Self::Torque => "torque",
            Self::Experiment => "experiment",
            Self::Armed => "armed",
            Self::Idle => "idle",
            Self::Save => "save",
            Self::Port => "port",
            Self::BringUp => "bring-up",
            Self::Float => "float",
        }
    }

    /// Whether the host arms the board.
    pub fn is_armed(self) -> bool {
        !matches!(self, Self::Idle | Self::Save | Self::Port)
    }

    /// Whether the board drives the motors.
    pub fn is_driven(self) -> bool {
        self.is_armed() && self != Self::Armed
    }

    /// Whether a controller closes the loop of both joints.
    pub fn is_closed(self) -> bool {
        self.is_driven() && !matches!(self, Self::Torque | Self::Experiment | Self::Float)
    }

    /// Whether the arm stays where it is without friction.
    pub(super) fn is_balanced(self) -> bool {
        self.is_closed() || self == Self::Float
    }

    /// Whether boards with ticks of this period do it.
    pub(super) fn permits(self, period_us: u32) -> bool {
        self != Self::Float || period_us <= float::PERIOD_MAX_US
    }

    /// Whether an obstacle may be in the arm's way without a fault.
    pub(super) fn can_press(self) -> bool {
        matches!(self, Self::Torque | Self::Port)
    }

    /// Command that starts it, if there is one. `to_rad` are target angles or amplitudes;
    /// `draw` chooses among experiments.
    pub(super) fn command(
        self,
        to_rad: [f32; JOINTS],
        is_obstructed: bool,
        draw: u64,
    ) -> Option<Command> {
        Some(match self {
            Self::Regulate | Self::BringUp => Command::Regulate(to_rad),
            Self::Sine => Command::Follow(Motion::Sinusoid {
                centre_rad: [0.0; JOINTS],
                amplitude_rad: to_rad,
                frequency_hz: [0.8, 0.6],
                phase_rad: [0.0; JOINTS],
                ramp_s: 1.0,
                duration_s: 20.0,
            }),
            Self::MinimumJerk => Command::Follow(Motion::MinimumJerk {
                to_rad,
                duration_s: Some(1.5),
            }),
            Self::Waypoints => {
                let mut vias = [None; WAYPOINTS_MAX];
                for (index, via) in vias.iter_mut().enumerate().take(5) {
                    let sign = if index % 2 == 0 { 1.0 } else { -1.0 };
                    *via = Some(Via {
                        at_s: 0.8 * (index + 1) as f32,
                        angle_rad: to_rad.map(|rad| sign * rad),
                    });
                }
                Command::Follow(Motion::Waypoints(vias))
            }
            Self::Torque if is_obstructed => Command::Torque([PRESSING_NM; JOINTS]),
            Self::Torque => Command::Torque([SMALL_NM; JOINTS]),
            Self::Experiment => Command::Experiment(experiment(draw)),
            Self::Float => Command::Float,
            Self::Armed | Self::Idle | Self::Save | Self::Port | Self::Stream => return None,
        })
    }
}

/// There is no activity of this name.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("there is no activity `{0}`; there are: {all}", all = names())]
pub struct UnknownActivity(String);

fn names() -> String {
    let names: Vec<&str> = Activity::all().map(Activity::name).collect();
    names.join(", ")
}

impl FromStr for Activity {
    type Err = UnknownActivity;

    fn from_str(text: &str) -> Result<Self, UnknownActivity> {
        let mut all = Self::all();
        all.find(|activity| activity.name() == text)
            .ok_or_else(|| UnknownActivity(text.to_owned()))
    }
}

/// An experiment of ten seconds that friction keeps inside its envelope.
fn experiment(draw: u64) -> Experiment {
    let role = match draw % 3 {
        0 => Role::Torque(Signal::Sinusoid {
            offset: 0.0,
            amplitude: SMALL_NM,
            frequency_hz: 1.0,
            ramp_s: 0.5,
        }),
        1 => Role::Pwm(Signal::Triangle {
            offset: 0.0,
            amplitude: 8.0,
            period_s: 1.0,
        }),
        _ => Role::Off,
    };
    let roles = if draw.is_multiple_of(2) {
        [role, Role::Hold]
    } else {
        [Role::Hold, role]
    };
    Experiment {
        roles,
        duration_s: 10.0,
        angle_rad: [[-0.6, 0.6]; JOINTS],
        speed_rad_s: [2.0; JOINTS],
    }
}
