//! Diagnosis of a failed exchange: error and likely cause.

use armbridge_servo::Alarms;

use crate::servo_table::alarms;

/// Reason for which there is no valid reply.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Diagnosis {
    /// Not a byte was received, not even our own.
    #[error(
        "nothing was received; check the servo's power, its id, the baud rate and the data wire"
    )]
    Silence,
    /// Only our own bytes were received, as on a single wire whose receiver stays on.
    #[error(
        "only our own bytes were received; the adapter works: check the servo's power, its id \
         and the baud rate"
    )]
    EchoOnly,
    /// Our own bytes came back damaged.
    #[error(
        "our own bytes came back changed; another sender drives the wire: is there a second \
         master, or a servo that was not asked?"
    )]
    EchoDamaged,
    /// A packet with a wrong checksum.
    #[error(
        "an answer with a wrong checksum was received, as if from id {id}; are there two servos \
         with one id, or is the ground poor?"
    )]
    BadChecksum {
        /// The id in it, which may be wrong.
        id: u8,
    },
    /// An intact packet of another servo.
    #[error("servo {answered} answered; is an answer late, or does another program use the bus?")]
    WrongId {
        /// Its id.
        answered: u8,
    },
    /// The beginning of a packet.
    #[error("an answer broke off after {bytes} bytes; check the supply voltage under load")]
    Short {
        /// Bytes received.
        bytes: usize,
    },
    /// Bytes without a packet.
    #[error(
        "{bytes} bytes were received that are no packet; the baud rate is likely wrong, or two \
         servos answer at once"
    )]
    Garbage {
        /// Bytes received.
        bytes: usize,
    },
    /// More than one packet for one request.
    #[error("more than one answer was received; are there two servos with one id?")]
    Several,
    /// An intact packet that refuses the request.
    #[error("the servo refused: {0}")]
    Refused(#[from] Refusal),
    /// An intact packet of the right servo, with another content.
    #[error("servo {id} answered something else; did it answer an earlier question?")]
    UnexpectedContent {
        /// Id of the servo.
        id: u8,
    },
}

impl Diagnosis {
    /// No reply, on a line with or without echo.
    pub fn silence(echoes: bool) -> Self {
        if echoes {
            Self::EchoOnly
        } else {
            Self::Silence
        }
    }
}

/// Refusal of a servo.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Refusal {
    /// Morpheus has one code for it.
    #[error("NOK; it knows no such command or register, or the board guards it in a loop")]
    Nok,
    /// A stock servo sets alarms for the instruction.
    #[error("{}", reasons(*.0))]
    Alarms(Alarms),
}

/// Alarms of an instruction that was not executed. The others report the state of
/// the servo, whatever the instruction.
pub(crate) const REFUSING: Alarms = Alarms::RANGE
    .or(Alarms::CHECKSUM)
    .or(Alarms::INSTRUCTION)
    .or(Alarms::ANGLE_LIMIT);

fn reasons(alarms: Alarms) -> String {
    let causes = [
        (Alarms::RANGE, "the value or the register is out of range"),
        (Alarms::CHECKSUM, "the request came damaged"),
        (
            Alarms::INSTRUCTION,
            "it does not know the instruction, or the board guards it in a loop",
        ),
        (Alarms::ANGLE_LIMIT, "the goal is outside its angle limits"),
    ];
    let causes: Vec<&str> = causes
        .iter()
        .filter(|(alarm, _)| alarms.contains(*alarm))
        .map(|(_, cause)| *cause)
        .collect();
    format!("{} error; {}", alarms::text(alarms), causes.join(", "))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_refusal_names_its_alarms_and_their_meaning() {
        let refusal = Refusal::Alarms(Alarms::RANGE.or(Alarms::OVERLOAD));
        assert_eq!(
            Diagnosis::from(refusal).to_string(),
            "the servo refused: range, overload error; the value or the register is out of range"
        );
        let state = Alarms::INPUT_VOLTAGE
            .or(Alarms::OVERHEATING)
            .or(Alarms::OVERLOAD);
        assert!(state.and(REFUSING).is_empty());
        assert_eq!(state.or(REFUSING).bits(), 0x7F);
    }
}
