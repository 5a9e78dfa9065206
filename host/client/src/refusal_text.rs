//! Reasons for which a board refuses a command, as text with the remedy.

use armbridge_shared::control::trajectory::Quantity;
use armbridge_shared::link::message::Refusal;

use crate::experiment_text;

/// Reason and remedy. One line without a full stop.
pub fn in_words(refusal: Refusal) -> String {
    match refusal {
        Refusal::Faulted => "a fault is latched; clear it first".into(),
        Refusal::NotOff => "its motors are not yet seen to be off; try again in a moment".into(),
        Refusal::NotReady => "its servos are not ready; check their power and ids".into(),
        Refusal::Disarmed => "it is not armed; arm it first".into(),
        Refusal::OtherSession => {
            "it has been reset since, or another host commands it; say hello and arm it again"
                .into()
        }
        Refusal::Stale => "it is older than one that was obeyed; send it again".into(),
        Refusal::NotSaved => {
            "the settings could not be kept; reset the board, which makes room, and save again"
                .into()
        }
        Refusal::NotIdle => {
            "period and calibration can only change, and servos be released, with torque off, and \
             the set-up not while an experiment runs; switch off first"
                .into()
        }
        Refusal::SettingsLost => {
            "saved settings are lost, and others are in force (`armbridge status` shows which); \
             look at them with `armbridge params`, and confirm them with `armbridge params --save`"
                .into()
        }
        Refusal::Hot { joint } => format!(
            "the servo of joint {} is too hot, or has not cooled since its fault; wait",
            joint + 1
        ),
        Refusal::EncoderUnknown { joint } => format!(
            "the encoder of joint {} has given too few samples at rest; hold the arm still, and \
             try again in a moment",
            joint + 1
        ),
        Refusal::BeyondLimit { joint } => format!(
            "joint {} stands beyond its angle limit; move it inside by hand, or check its \
             calibration",
            joint + 1
        ),
        Refusal::Unprepared => {
            "stock servos take no torque before they are set to wheel mode; prepare them first"
                .into()
        }
        Refusal::Passthrough => {
            "a program on the transparent port has the servo bus; switch to idle to take it back"
                .into()
        }
        Refusal::TooFast { least_us } => format!(
            "these servos cannot be asked so often on this bus: the shortest period is \
             {least_us} us"
        ),
        Refusal::OutOfRange => "a number in it is not finite or out of range".into(),
        Refusal::NoGains => {
            "no gains exist for these weights: R must be positive, and Q see every angle".into()
        }
        Refusal::Unstable { re, im } => {
            let radius = re.hypot(im);
            let eigenvalue = if im == 0.0 {
                format!("{re:.4}")
            } else {
                format!("{re:.4} ± {im:.4}i")
            };
            format!(
                "the closed loop would grow: eigenvalue {eigenvalue}, magnitude {radius:.4}; \
                 it must be below 1"
            )
        }
        Refusal::Beyond {
            joint,
            quantity,
            value,
        } => {
            let unit = match quantity {
                Quantity::Angle => "rad",
                Quantity::Speed => "rad/s",
                Quantity::Acceleration => "rad/s²",
            };
            let joint = u32::from(joint) + 1;
            format!("joint {joint} would go to {value:.3} {unit}, more than the arm is allowed")
        }
        Refusal::Experiment(objection) => experiment_text::objection(objection),
        Refusal::Late => "the point's time has passed, or is not in order; send earlier".into(),
        Refusal::Busy => "the board is busy; send it again".into(),
    }
}
