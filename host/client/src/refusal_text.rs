//! Reasons for which a board refuses a command, as text with the remedy.

use armbridge_control::trajectory::Quantity;
use armbridge_control::trajectory::stream::POINTS_MAX;
use armbridge_link::message::Refusal;

use crate::experiment_text;
use crate::number_text::beside_limit;

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
        Refusal::MotorsUnchecked => {
            "the direction of the motors has not been checked, and cannot be at periods above \
             10 ms; arm once at a shorter period, or confirm that they need no check: \
             `--set limits.check_rad_s2=0` for a run, `armbridge params limits.check_rad_s2=0` \
             for the board"
                .into()
        }
        Refusal::Unprepared => {
            "the servos take no torque before they are set to wheel mode (X servos: PWM control mode); \
             prepare them first"
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
        Refusal::TooSlow { most_us } => {
            format!("an arm floats at periods of at most {most_us} us: set setup.period_us")
        }
        Refusal::OtherEncoder { joint } => format!(
            "the calibration of joint {} is that of another kind of servo than was found: an X \
             servo has 4096 counts a turn and its middle at 2048, an AX-12A 1023 counts in 300 \
             degrees and its middle at 512; set zero_count and rad_per_count of both joints",
            joint + 1
        ),
        Refusal::OutOfRange => "a number in it is not finite or out of range".into(),
        Refusal::NoGains => {
            "no gains exist for these weights: R must be positive, and Q see every angle".into()
        }
        Refusal::Unstable { re, im } => {
            format!("the closed loop would grow: {}", eigenvalue(re, im))
        }
        Refusal::UnstableObserver { re, im } => {
            format!("the observer's error would grow: {}", eigenvalue(re, im))
        }
        Refusal::Beyond {
            joint,
            quantity,
            value,
            limit,
        } => beyond(joint.into(), quantity, value, limit),
        Refusal::Experiment(objection) => experiment_text::objection(objection),
        Refusal::Late { by_us } => format!(
            "the point is {:.1} ms too early: it must be 1 ms after the board's next tick, and \
             after the point before; send it sooner, or give it a later time",
            f64::from(by_us) * 1e-3
        ),
        Refusal::Busy => format!(
            "a queue of the board is full (a stream holds {POINTS_MAX} points); send it again"
        ),
    }
}

/// An eigenvalue of a loop that is not stable.
fn eigenvalue(re: f32, im: f32) -> String {
    let radius = re.hypot(im);
    let imaginary = if im == 0.0 {
        String::new()
    } else {
        format!(" ± {im:.4}i")
    };
    format!("eigenvalue {re:.4}{imaginary}, magnitude {radius:.4}; it must be below 1")
}

/// Unit of a quantity of a motion.
pub fn unit(quantity: Quantity) -> &'static str {
    match quantity {
        Quantity::Angle => "rad",
        Quantity::Speed => "rad/s",
        Quantity::Acceleration => "rad/s²",
        Quantity::Jerk => "rad/s³",
    }
}

/// A motion beyond a bound; joints count from 0.
pub fn beyond(joint: usize, quantity: Quantity, value: f32, limit: f32) -> String {
    let ([value, limit], unit) = (beside_limit(value, limit, 3), unit(quantity));
    format!(
        "joint {} would reach {value} {unit}, beyond the bound of {limit} {unit}",
        joint + 1
    )
}
