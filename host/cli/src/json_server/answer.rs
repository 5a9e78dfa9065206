//! Answers as lines: `{"id": .., "ok": true, ..}`, or `"ok": false` with the kind of the error and
//! a sentence.

use armbridge_sim::link::ClientError;
use serde_json::{Map, Value, json};

/// Fields of an answer beside `ok`.
pub(super) type Fields = Map<String, Value>;

/// An error: its kind, and a sentence.
#[derive(Debug)]
pub(super) struct Failure {
    kind: &'static str,
    text: String,
}

impl Failure {
    /// The request itself is wrong.
    pub(super) fn request(text: impl Into<String>) -> Self {
        Self {
            kind: "request",
            text: text.into(),
        }
    }

    /// Too much is asked for at a time.
    pub(super) fn busy(text: impl Into<String>) -> Self {
        Self {
            kind: "busy",
            text: text.into(),
        }
    }
}

impl From<ClientError> for Failure {
    fn from(error: ClientError) -> Self {
        let kind = match &error {
            ClientError::Link(_) | ClientError::Ended | ClientError::Interrupted => "link",
            ClientError::Refused { .. } | ClientError::NotArmed(_) => "refused",
            ClientError::Fault(..) => "fault",
            ClientError::Dropped => "dropped",
            ClientError::Push => "request",
            ClientError::Timeout { .. } => "timeout",
            ClientError::Observes(_) => "observer",
        };
        Self {
            kind,
            text: error.to_string(),
        }
    }
}

/// The line of an answer, with its line feed.
pub(super) fn line(id: Option<Value>, result: Result<Fields, Failure>) -> Vec<u8> {
    let mut answer = Map::new();
    answer.extend(id.map(|id| ("id".to_owned(), id)));
    answer.insert("ok".into(), result.is_ok().into());
    match result {
        Ok(fields) => answer.extend(fields),
        Err(Failure { kind, text }) => {
            answer.insert("error".into(), json!(kind));
            answer.insert("text".into(), json!(text));
        }
    }
    let mut line = Value::Object(answer).to_string().into_bytes();
    line.push(b'\n');
    line
}
