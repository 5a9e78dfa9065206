//! Requests, parsed from a line: `{"do": NAME, ...}`, with any `id`, which its answer repeats.

use armbridge_link::experiment::Experiment;
use armbridge_servo::JOINTS;
use serde::Deserialize;
use serde_json::{Map, Value};

/// A request. Angles are in rad from upright, speeds in rad/s, torques in N m, times in s.
#[derive(Debug, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub(super) enum Request {
    /// Only watch, as the first request of a connection.
    Observe {},
    /// Arm; answered when the motors have been checked.
    Arm {},
    /// Torque off at once.
    Disarm {},
    /// Park the arm, or disarm without a pose.
    Park {},
    /// Emergency stop; carried out at once.
    Stop {},
    /// Clear a fault.
    Clear {},
    /// Make the arm weightless.
    Float {},
    /// Hold the arm at these angles: a step, if it is elsewhere.
    Regulate {
        /// Angles.
        angle_rad: [f32; JOINTS],
    },
    /// Move the arm there with least jerk; answered when it has arrived, or when the motion has
    /// begun if `wait` is false.
    Move {
        /// Angles.
        angle_rad: [f32; JOINTS],
        /// Duration; as fast as the bounds permit without.
        duration_s: Option<f32>,
        /// Whether to wait.
        #[serde(default = "yes")]
        wait: bool,
    },
    /// A setpoint of a stream, which the board interpolates.
    Stream {
        /// Time of the setpoint since the stream began; that of its arrival without.
        t_s: Option<f64>,
        /// Angles.
        angle_rad: [f32; JOINTS],
        /// Speeds; the board computes them without.
        speed_rad_s: Option<[f32; JOINTS]>,
    },
    /// Torques, until the next ones or until they are too old.
    Torque {
        /// Torques.
        torque_nm: [f32; JOINTS],
    },
    /// An experiment, as a step of a scenario has it; answered when it has ended.
    Experiment {
        /// The experiment.
        experiment: Experiment,
    },
    /// Replace parameters of the board, all or none.
    Set {
        /// Parameters by name.
        parameters: Map<String, Value>,
        /// Whether to keep them across power-off.
        #[serde(default)]
        save: bool,
    },
    /// Parameters in force, by name.
    Get {},
    /// Status of the board.
    Status {},
    /// A block of ticks.
    Take {
        /// Number of ticks; those that wait without.
        ticks: Option<usize>,
        /// Names of columns or of quantities; all without.
        columns: Option<Vec<String>>,
        /// Longest wait.
        timeout_s: Option<f32>,
    },
    /// Push a joint of a simulated arm, 1 or 2.
    Push {
        /// The joint.
        joint: u8,
        /// Torque.
        torque_nm: f32,
        /// Duration.
        duration_s: f32,
    },
    /// Bring a simulated arm back to where it began.
    Lift {},
}

const fn yes() -> bool {
    true
}

/// A line that was read: its identity, and the request or what is wrong with it.
#[derive(Debug)]
pub(super) struct Line {
    pub(super) id: Option<Value>,
    pub(super) request: Result<Request, String>,
}

impl Line {
    pub(super) fn parse(text: &[u8]) -> Self {
        match serde_json::from_slice::<Map<String, Value>>(text) {
            Ok(mut object) => Self {
                id: object.remove("id"),
                request: request(object),
            },
            Err(error) => Self {
                id: None,
                request: Err(format!("this line is no JSON object: {error}")),
            },
        }
    }
}

fn request(mut object: Map<String, Value>) -> Result<Request, String> {
    let Some(Value::String(name)) = object.remove("do") else {
        return Err("a request has a name: {\"do\":\"status\"}".into());
    };
    let tagged = Map::from_iter([(name.clone(), Value::Object(object))]);
    let request = serde_json::from_value(Value::Object(tagged));
    request.map_err(|error| format!("`{name}`: {error}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parsed(text: &str) -> Result<Request, String> {
        Line::parse(text.as_bytes()).request
    }

    #[test]
    fn a_line_is_a_request_or_says_what_is_wrong() {
        assert!(matches!(parsed(r#"{"do":"arm"}"#), Ok(Request::Arm {})));
        let request = parsed(r#"{"do":"move","angle_rad":[0.1,-2e-1]}"#);
        let Ok(Request::Move {
            angle_rad, wait, ..
        }) = request
        else {
            panic!("{request:?}")
        };
        assert_eq!((angle_rad, wait), ([0.1, -0.2], true));
        for (text, expected) in [
            ("", "no JSON object"),
            ("[1,2]", "no JSON object"),
            (r#"{"do":"arm""#, "no JSON object"),
            ("{}", "a request has a name"),
            (r#"{"do":3}"#, "a request has a name"),
            (
                r#"{"do":"jump"}"#,
                "`jump`: unknown variant `jump`, expected one of `observe`",
            ),
            (r#"{"do":"regulate"}"#, "missing field `angle_rad`"),
            (r#"{"do":"regulate","angle_rad":[1]}"#, "invalid length 1"),
            (r#"{"do":"regulate","angle_rad":[1,2,3]}"#, "length"),
            (
                r#"{"do":"regulate","angle_rad":[1,null]}"#,
                "invalid type: null",
            ),
            (r#"{"do":"regulate","angle_rad":[NaN,0]}"#, "no JSON object"),
            (r#"{"do":"arm","angle":1}"#, "unknown field `angle`"),
        ] {
            let error = parsed(text).unwrap_err();
            assert!(error.contains(expected), "{text}: {error}");
        }
    }

    #[test]
    fn an_answer_has_the_identity_of_its_request() {
        let line = Line::parse(br#"{"id":[1,"a"],"do":"nothing"}"#);
        assert_eq!(line.id.unwrap().to_string(), r#"[1,"a"]"#);
    }
}
