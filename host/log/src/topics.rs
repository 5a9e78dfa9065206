//! Topics of a log: names and schemas of its messages.
//!
//! They are defined in `host/log/proto/armbridge.proto`.

use super::proto;
use super::proto::descriptors;

/// Topic of a message.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Topic {
    /// Records of ticks.
    Telemetry,
    /// Messages of the host.
    Commands,
    /// Other messages of the board, and events of the link.
    Events,
    /// Settings in force.
    Parameters,
    /// Counters, each second.
    Statistics,
    /// Events as text.
    Log,
    /// Angles, speeds and torques of the joints.
    JointStates,
    /// Frames of the links.
    Transforms,
    /// Shapes of the links.
    Scene,
    /// True states of a simulated arm.
    SimulationState,
    /// Pushes on a simulated arm.
    SimulationPush,
}

impl Topic {
    /// All topics.
    pub const ALL: [Self; 11] = [
        Self::Telemetry,
        Self::Commands,
        Self::Events,
        Self::Parameters,
        Self::Statistics,
        Self::Log,
        Self::JointStates,
        Self::Transforms,
        Self::Scene,
        Self::SimulationState,
        Self::SimulationPush,
    ];

    /// Whether only the log of a simulation has it.
    pub fn is_simulation(self) -> bool {
        matches!(self, Self::SimulationState | Self::SimulationPush)
    }

    /// Its name.
    pub fn name(self) -> &'static str {
        match self {
            Self::Telemetry => "/telemetry",
            Self::Commands => "/commands",
            Self::Events => "/events",
            Self::Parameters => "/parameters",
            Self::Statistics => "/statistics",
            Self::Log => "/log",
            Self::JointStates => "/joint_states",
            Self::Transforms => "/tf",
            Self::Scene => "/scene",
            Self::SimulationState => "/simulation/state",
            Self::SimulationPush => "/simulation/push",
        }
    }

    /// Name of its messages' type.
    pub fn schema_name(self) -> &'static str {
        match self {
            Self::Telemetry => "armbridge.Telemetry",
            Self::Commands => "armbridge.Command",
            Self::Events => "armbridge.Event",
            Self::Parameters => "armbridge.Parameters",
            Self::Statistics => "armbridge.Statistics",
            Self::Log => "foxglove.Log",
            Self::JointStates => "foxglove.JointStates",
            Self::Transforms => "foxglove.FrameTransforms",
            Self::Scene => "foxglove.SceneUpdate",
            Self::SimulationState => "armbridge.SimulationState",
            Self::SimulationPush => "armbridge.SimulationPush",
        }
    }

    /// `FileDescriptorSet` of that type. Messages and schema have the encoding
    /// `protobuf`.
    pub fn schema(self) -> &'static [u8] {
        match self {
            Self::Telemetry
            | Self::Commands
            | Self::Events
            | Self::Parameters
            | Self::Statistics
            | Self::SimulationState
            | Self::SimulationPush => proto::DESCRIPTORS,
            Self::Log => descriptors::LOG,
            Self::JointStates => descriptors::JOINT_STATES,
            Self::Transforms => descriptors::FRAME_TRANSFORMS,
            Self::Scene => descriptors::SCENE_UPDATE,
        }
    }
}
