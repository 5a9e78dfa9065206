//! Words of a command line, as a shell reads them.

/// A word that a shell reads as this text: in quotes if it has letters with a meaning of
/// their own.
pub fn word(text: &str) -> String {
    let is_plain = |letter: char| letter.is_alphanumeric() || "-_./:=,+@%".contains(letter);
    if !text.is_empty() && text.chars().all(is_plain) {
        text.to_owned()
    } else {
        format!("'{}'", text.replace('\'', r"'\''"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn letters_with_a_meaning_are_quoted() {
        for (text, expected) in [
            ("run-1/run.mcap", "run-1/run.mcap"),
            ("controller.r=10,10", "controller.r=10,10"),
            ("", "''"),
            ("a b", "'a b'"),
            ("[1]", "'[1]'"),
            ("it's", r"'it'\''s'"),
        ] {
            assert_eq!(word(text), expected);
        }
    }
}
