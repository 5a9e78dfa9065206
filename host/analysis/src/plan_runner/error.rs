//! Errors of a run, with remedies.

use armbridge_client::error::{SessionError, end_in_words};
use armbridge_client::params::ParameterError;
use armbridge_client::refusal_text;
use armbridge_client::status::Obstacle;
use armbridge_link::message::{Fault, LastEnd, Refusal};

/// Failure of a run.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum PlanError {
    /// There is no session with a board.
    #[error(transparent)]
    Session(#[from] SessionError),
    /// The board has not found its servos, or cannot use them.
    #[error("{}", servos_in_words(.0.as_ref()))]
    Servos(Option<Obstacle>),
    /// The board refused a command.
    #[error("the board refused `{command}`: {}", refusal_text::in_words(*.refusal))]
    Refused {
        /// Name of the command.
        command: &'static str,
        /// Reason.
        refusal: Refusal,
    },
    /// The board has been reset, with its motors off.
    #[error("the board has been reset: {}", end_in_words(.0))]
    Reset(LastEnd),
    /// A latched fault prevents torque.
    #[error(
        "a fault is latched on the board, `{}`: see to its cause, then clear it (`run --clear`)",
        .0.name()
    )]
    Latched(Fault),
    /// The link broke while the motors were on.
    #[error(
        "the link to the board broke in mid-run; the arm was braked by the board and let go of \
         within half a second, and is not armed again: look at the cable, then run again"
    )]
    Disconnected,
    /// Torque went off without a fault, and not by this host.
    #[error("another program disarmed the board, by `armbridge disarm` or on the same link")]
    Disarmed,
    /// The board has parked the arm, not for this host.
    #[error(
        "the board parked the arm: a command expired, a servo is nearly too hot, or another program \
         had it parked"
    )]
    Parked,
    /// The plan has the arm parked, but the board has no pose for it.
    #[error(
        "the board has no pose to park the arm in: set `park.kind` to \"pose\", and \
         `park.angle_rad`, in `[set]` or by `armbridge params`"
    )]
    NoPose,
    /// A setting of the scenario is incompatible with the board's.
    #[error("{0}")]
    Setting(#[from] ParameterError),
    /// The combination of both settings is refused.
    #[error("the scenario's settings do not work with the board's own: {}", refusal_text::in_words(*.0))]
    Settings(Refusal),
}

fn servos_in_words(obstacle: Option<&Obstacle>) -> String {
    obstacle.map_or_else(
        || "the board does not find its servos: check their power and wiring".into(),
        Obstacle::to_string,
    )
}
