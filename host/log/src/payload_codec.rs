//! Complete payloads of messages: as JSON for any reader, and as postcard, to the bit, for
//! programs with the same schema.

use serde::Serialize;
use serde::de::DeserializeOwned;

use super::proto::Exact;

/// Both forms of a value.
pub(super) fn exact(value: &impl Serialize) -> Exact {
    Exact {
        // Values of the link are plain data: neither encoding can fail, and one suffices.
        json: serde_json::to_string(value).unwrap_or_default(),
        postcard: postcard::to_stdvec(value).unwrap_or_default(),
    }
}

/// The value. With another schema, from JSON, if its shape has not
/// changed.
pub(super) fn value<T: DeserializeOwned>(exact: &Exact, is_same_schema: bool) -> Option<T> {
    if is_same_schema {
        postcard::from_bytes(&exact.postcard).ok()
    } else {
        serde_json::from_str(&exact.json).ok()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use armbridge_link::message::{Command, Settings, ToBoard};

    #[test]
    fn another_version_reads_the_text() {
        let settings = Settings::default();
        assert_eq!(value(&exact(&settings), false), Some(settings));
        let message = ToBoard::Command(Command::Regulate([0.1, -1.0e-7]));
        assert_eq!(value(&exact(&message), false), Some(message));
        // Bytes of another schema are ignored.
        let other = Exact {
            postcard: vec![255; 3],
            ..exact(&message)
        };
        assert_eq!(value(&other, false), Some(message));
        assert_eq!(value::<ToBoard>(&other, true), None);
    }
}
