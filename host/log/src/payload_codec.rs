//! What was said, completely: in JSON for everybody, and in postcard, bit by bit, for
//! programs that speak the same schema.

use serde::Serialize;
use serde::de::DeserializeOwned;

use super::proto::Exact;

/// Both forms of a value.
pub(super) fn exact(value: &impl Serialize) -> Exact {
    Exact {
        // Values of the link are plain data: neither can fail, and if one did, the
        // other would be there.
        json: serde_json::to_string(value).unwrap_or_default(),
        postcard: postcard::to_stdvec(value).unwrap_or_default(),
    }
}

/// The value again. Without the same schema, what JSON gives, if its shape has not
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
    use armbridge_shared::link::message::{Command, Settings, ToBoard};

    #[test]
    fn another_version_reads_the_text() {
        let settings = Settings::default();
        assert_eq!(value(&exact(&settings), false), Some(settings));
        let said = ToBoard::Command(Command::Regulate([0.1, -1.0e-7]));
        assert_eq!(value(&exact(&said), false), Some(said));
        // Bytes of another schema are not looked at.
        let other = Exact {
            postcard: vec![255; 3],
            ..exact(&said)
        };
        assert_eq!(value(&other, false), Some(said));
        assert_eq!(value::<ToBoard>(&other, true), None);
    }
}
