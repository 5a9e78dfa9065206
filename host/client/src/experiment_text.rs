//! Experiments as text: reasons for rejection, and results.

use armbridge_control::experiment::{
    DURATION_MAX_S, FREQUENCY_MAX_HZ, Flaw, LINES_MAX, TIME_MIN_S,
};
use armbridge_link::experiment::{Conclusion, ExperimentEnd, Measure, Objection};
use armbridge_link::limits::hard;

/// Reason for a rejection, and the remedy. One line without a full stop.
pub fn objection(objection: Objection) -> String {
    match objection {
        Objection::Duration { value_s } => {
            format!("an experiment takes from {TIME_MIN_S} to {DURATION_MAX_S} s, not {value_s}")
        }
        Objection::Envelope { joint } => format!(
            "joint {}'s envelope is none: its least angle must be below its most, both within \
             {} rad, and its speed from 0 to {} rad/s",
            number(joint),
            hard::ANGLE_RAD,
            hard::SPEED_RAD_S
        ),
        Objection::Signal { joint, flaw: why } => {
            format!("joint {}'s signal is none: {}", number(joint), flaw(why))
        }
        Objection::Rough { joint } => format!(
            "joint {} cannot follow this as an angle: only a sinusoid, a chirp or a multisine \
             with a ramp, or the constant 0",
            number(joint)
        ),
        Objection::Beyond {
            joint,
            measure,
            value,
            limit,
        } => beyond(joint, measure, value, limit),
        Objection::Edge {
            joint,
            edge_rad,
            speed_rad_s,
            farthest_rad,
        } => format!(
            "joint {} would be braked before its angle limit: at {speed_rad_s:.2} rad/s the \
             envelope may reach to {farthest_rad:.2} rad, not to {edge_rad:.2}; make it narrower \
             or slower",
            number(joint)
        ),
        Objection::Outside {
            joint,
            angle_rad,
            within_rad: [low, high],
        } => format!(
            "joint {} is at {angle_rad:.2} rad, outside the experiment's {low:.2}..{high:.2} rad: \
             move it there first",
            number(joint)
        ),
        Objection::Moving {
            joint,
            speed_rad_s,
            limit_rad_s,
        } => format!(
            "joint {} moves at {speed_rad_s:.2} rad/s, faster than the experiment's \
             {limit_rad_s:.2} rad/s: let it come to rest first",
            number(joint)
        ),
    }
}

/// Result of an experiment. One line without a full stop.
pub fn conclusion(conclusion: &Conclusion) -> String {
    match conclusion.end {
        ExperimentEnd::Finished => "the experiment is over: its time is up".into(),
        ExperimentEnd::Angle { joint, value_rad } => format!(
            "the experiment was broken off: joint {} left its envelope at {value_rad:.3} rad",
            number(joint)
        ),
        ExperimentEnd::Speed { joint, value_rad_s } => format!(
            "the experiment was broken off: joint {} moved at {value_rad_s:.2} rad/s, faster than \
             its envelope allows",
            number(joint)
        ),
        ExperimentEnd::HostQuiet => {
            "the experiment was broken off: the host was silent for too long".into()
        }
        ExperimentEnd::Replaced => {
            "the experiment was broken off: the host wanted something else".into()
        }
    }
}

/// Whether the experiment ran for its full duration.
pub fn is_whole(conclusion: &Conclusion) -> bool {
    match conclusion.end {
        ExperimentEnd::Finished => true,
        ExperimentEnd::Angle { .. }
        | ExperimentEnd::Speed { .. }
        | ExperimentEnd::HostQuiet
        | ExperimentEnd::Replaced => false,
    }
}

/// Joints count from 1 for users.
fn number(joint: u8) -> u32 {
    u32::from(joint) + 1
}

fn flaw(flaw: Flaw) -> String {
    match flaw {
        Flaw::NotFinite => "a number in it is not finite".into(),
        Flaw::Time => {
            format!("a period, or a time between two edges, is shorter than {TIME_MIN_S} s")
        }
        Flaw::Ramp => format!(
            "its ramp is neither 0 nor from {TIME_MIN_S} s to half of the experiment's duration"
        ),
        Flaw::Frequency => format!("a frequency is not from 0 to {FREQUENCY_MAX_HZ} Hz"),
        Flaw::Count => format!("it has no steps, or not from 1 to {LINES_MAX} lines"),
    }
}

fn beyond(joint: u8, measure: Measure, value: f32, limit: f32) -> String {
    let joint = number(joint);
    match measure {
        Measure::Angle => format!(
            "joint {joint} would be asked to go to {value:.2} rad, beyond the {limit:.2} rad that \
             it may"
        ),
        Measure::Speed => format!(
            "joint {joint} would be let move at {value:.2} rad/s, more than the {limit:.2} rad/s \
             that it may"
        ),
        Measure::Acceleration => format!(
            "joint {joint} would be asked for {value:.1} rad/s², more than the {limit:.1} rad/s² \
             that it may: a smaller amplitude, a lower frequency or a longer ramp"
        ),
        Measure::Torque => format!(
            "joint {joint} would be given {value:.2} N m, more than the {limit:.2} N m that it may"
        ),
        Measure::Pwm => format!(
            "joint {joint} would be given PWM {value:.0} from off, more than the {limit:.0} that \
             it may"
        ),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn texts_have_a_remedy() {
        let outside = Objection::Outside {
            joint: 0,
            angle_rad: 0.82,
            within_rad: [-0.5, 0.5],
        };
        assert_eq!(
            objection(outside),
            "joint 1 is at 0.82 rad, outside the experiment's -0.50..0.50 rad: move it there first"
        );
        let edge = Objection::Edge {
            joint: 1,
            edge_rad: -1.2,
            speed_rad_s: 4.0,
            farthest_rad: 0.7,
        };
        assert!(objection(edge).contains("may reach to 0.70 rad, not to -1.20"));
    }
}
