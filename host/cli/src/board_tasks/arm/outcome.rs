//! End of an arming, and its description.

use armbridge_client::error::end_in_words;
use armbridge_client::fault_text;
use armbridge_link::message::{Fault, LastEnd, Trip};

/// End of an arming.
#[derive(Clone, Debug, PartialEq)]
pub enum Outcome {
    /// By ctrl-c, or after its time.
    Disarmed,
    /// The board switched torque off.
    Tripped(Trip),
    /// The same, and its account of the cause was lost.
    Fault(Fault),
    /// By another program.
    Released,
    /// The board reports nothing.
    Silent,
    /// The board was reset.
    Reset(LastEnd),
    /// The link broke, and is back; the board is disarmed.
    Parted,
    /// A joint left the place where it was to be held: by this angle in rad, the largest
    /// allowed or more.
    Strayed(f32),
}

impl Outcome {
    /// Its name in JSON.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Disarmed => "disarmed",
            Self::Tripped(_) | Self::Fault(_) => "fault",
            Self::Released => "released",
            Self::Silent => "silent",
            Self::Reset(_) => "reset",
            Self::Parted => "parted",
            Self::Strayed(_) => "strayed",
        }
    }

    /// Its description, in one line.
    pub fn in_words(&self) -> String {
        match self {
            Self::Disarmed => "disarmed".into(),
            Self::Tripped(tripped) => {
                let description = fault_text::in_words(tripped);
                let measured = description
                    .measured
                    .map_or_else(String::new, |measured| format!(" ({measured})"));
                format!(
                    "torque off: {}{measured}; {}",
                    description.cause, description.remedy
                )
            }
            Self::Fault(fault) => {
                format!("torque off: the board reports {}", fault.name())
            }
            Self::Released => "another program disarmed the board".into(),
            Self::Silent => "the board has reported nothing for a second: MOTORS MAY BE ON; it \
                             switches them off if it does not hear this program either; if the \
                             arm moves, use the switch of the servos' supply"
                .into(),
            Self::Reset(end) => format!(
                "the board was reset, its motors are off: {}",
                end_in_words(end)
            ),
            Self::Parted => {
                "the link broke and is back; the board has switched its motors off and is not \
                 armed again by itself"
                    .into()
            }
            Self::Strayed(rad) => format!(
                "the arm was to be held, and a joint moved by {rad:.2} rad: motors off; check \
                 calibration, load and supply"
            ),
        }
    }
}
