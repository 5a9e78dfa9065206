//! Why a task ended without its result: one sentence, with a remedy.

use armbridge_client::error::SessionError;
use armbridge_client::status::Obstacle;
use armbridge_client::{fault_text, refusal_text};
use armbridge_link::message::{Refusal, Trip};

use super::calibrate::{MotorError, Unusable};

/// Why a task ended without its result.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum TaskError {
    /// The session with the board ended.
    #[error(transparent)]
    Session(#[from] SessionError),
    /// A fault is latched.
    #[error(
        "a fault is latched: {}; remove its cause, then `armbridge clear`",
        fault_text::in_words(.0).cause
    )]
    Latched(Trip),
    /// The board refused a request.
    #[error("{result}: {}", refusal_text::in_words(*.refusal))]
    Refused {
        /// The consequence.
        result: &'static str,
        /// The board's reason.
        refusal: Refusal,
    },
    /// The board does not acknowledge a request.
    #[error("the board does not answer: was it reset or unplugged?")]
    NoAnswer,
    /// No servos were found, for this reason.
    #[error("{}", reason(.0.as_ref(), "the servos are not found: check their power and wiring"))]
    NoServos(Option<Obstacle>),
    /// Stock or X servos are not set up for torque, and may not be.
    #[error(
        "the servos take no torque before they are set to wheel mode (X servos: PWM control mode), \
         which is kept in their \
         EEPROM: add --prepare to do it"
    )]
    NotPrepared,
    /// Stock servos do not take wheel mode, for this reason.
    #[error("{}", reason(.0.as_ref(), "the servos cannot be set to the mode that takes torque"))]
    NoWheelMode(Option<Obstacle>),
    /// Another program disarmed the board.
    #[error("another program disarmed the board, by `armbridge disarm`")]
    Released,
    /// The board does not acknowledge that it has disarmed.
    #[error("the board does not report that it has disarmed; switch its supply off")]
    NotDisarmed,
    /// The board reports no fault after an emergency stop.
    #[error(
        "stop was sent, but the board does not report that it has stopped: press the switch at \
         the board, or switch its supply off"
    )]
    NotStopped,
    /// A fault that was cleared is latched again.
    #[error("the fault came again: {}", cause_and_advice(.0))]
    FaultAgain(Trip),
    /// The fault is cleared, but no servos are found, for this reason.
    #[error(
        "the fault is cleared, but {}",
        reason(.0.as_ref(), "the servos are not found: check their power")
    )]
    ClearedOnly(Option<Obstacle>),
    /// Ctrl-C during a calibration.
    #[error("ctrl-c was pressed: nothing was saved")]
    Interrupted,
    /// The input that answers a calibration's questions has ended.
    #[error("the input ended before the last answer: nothing was saved")]
    InputEnded,
    /// A calibration that was not to be saved.
    #[error("not confirmed: nothing was changed")]
    NotConfirmed,
    /// Measurements of a calibration that failed several times.
    #[error("{0}; nothing was changed")]
    Unusable(Unusable),
    /// The check of a motor.
    #[error("{0}; nothing was saved, and a reset of the board brings back what was before")]
    Motor(#[from] MotorError),
}

fn cause_and_advice(trip: &Trip) -> String {
    let account = fault_text::in_words(trip);
    format!("{}; {}", account.cause, account.remedy)
}

fn reason(obstacle: Option<&Obstacle>, otherwise: &str) -> String {
    obstacle.map_or_else(|| otherwise.to_owned(), ToString::to_string)
}
