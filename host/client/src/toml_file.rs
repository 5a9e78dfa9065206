//! TOML files written by users, with the place of every key and value: an error names
//! file, line, column and the line itself.

pub mod keys;
mod text;

pub use text::{TEXT_MAX, read_file, read_text};

use std::collections::BTreeMap;
use std::fmt;
use std::ops::Range;
use std::path::{Path, PathBuf};

use toml::Value;
use toml::de::{DeTable, DeValue};

/// Place in a file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Place {
    /// The file.
    pub path: PathBuf,
    /// From 1.
    pub line: usize,
    /// From 1, in characters.
    pub column: usize,
    /// The line itself, trimmed.
    pub text: String,
}

impl Place {
    /// Place of a byte of a text.
    pub fn from_offset(path: &Path, text: &str, byte: usize) -> Self {
        let mut byte = byte.min(text.len());
        while !text.is_char_boundary(byte) {
            byte -= 1;
        }
        let above = &text[..byte];
        let start = above.rfind('\n').map_or(0, |at| at + 1);
        Self {
            path: path.into(),
            line: above.matches('\n').count() + 1,
            column: text[start..byte].chars().count() + 1,
            text: text[start..].lines().next().unwrap_or("").trim().into(),
        }
    }

    /// The line, as the end of a message; nothing of an empty one.
    fn quoted(&self) -> String {
        match self.text.as_str() {
            "" => String::new(),
            text => format!(", in `{text}`"),
        }
    }
}

impl fmt::Display for Place {
    /// As `armbridge.toml:3:5`.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (path, line, column) = (self.path.display(), self.line, self.column);
        write!(f, "{path}:{line}:{column}")
    }
}

/// Error in a file.
#[derive(Debug, thiserror::Error)]
pub enum DocumentError {
    /// It cannot be read.
    #[error("cannot read {path}: {source}", path = path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// Error of the system.
        source: std::io::Error,
    },
    /// It is longer than any that a user writes.
    #[error(
        "{path} is longer than {most_mib} MiB, the most that is read: write steps that repeat \
         once, with `every_s`, or divide the file into several runs",
        path = path.display()
    )]
    TooLong {
        /// The file.
        path: PathBuf,
        /// The bound.
        most_mib: u64,
    },
    /// It is not TOML, or has an unknown key or a wrong value.
    #[error("{place}: {message}{}", place.quoted())]
    Wrong {
        /// Place of the error.
        place: Place,
        /// Error, and permitted values.
        message: String,
    },
}

/// A value, and its place.
#[derive(Clone, Debug, PartialEq)]
pub struct Entry {
    /// The value.
    pub value: Value,
    /// Bytes of the key.
    pub key_at: Range<usize>,
    /// Bytes of the value.
    pub value_at: Range<usize>,
}

/// A file, as dotted keys with values: `q` of the table `controller` is `controller.q`.
/// Arrays are values.
#[derive(Clone, Debug, PartialEq)]
pub struct Document {
    path: PathBuf,
    text: String,
    entries: BTreeMap<String, Entry>,
}

impl Document {
    /// Reads a file.
    ///
    /// # Errors
    /// If it cannot be read, or is no TOML.
    pub fn read(path: &Path) -> Result<Self, DocumentError> {
        Self::parse(path, read_file(path, TEXT_MAX)?)
    }

    /// Parses a text as the contents of this file.
    ///
    /// # Errors
    /// If it is no TOML.
    pub fn parse(path: &Path, text: String) -> Result<Self, DocumentError> {
        let parsed = || {
            let table: toml::Table = toml::from_str(&text)?;
            let places = DeTable::parse(&text)?;
            let mut entries = BTreeMap::new();
            collect("", &table, places.get_ref(), &mut entries);
            Ok(entries)
        };
        match parsed() {
            Ok(entries) => Ok(Self {
                path: path.into(),
                text,
                entries,
            }),
            Err(error) => Err(not_toml(path, &text, &error)),
        }
    }

    /// The file.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// All keys with their values.
    pub fn entries(&self) -> impl Iterator<Item = (&str, &Entry)> {
        self.entries
            .iter()
            .map(|(key, entry)| (key.as_str(), entry))
    }

    /// Entry of a key.
    pub fn get(&self, key: &str) -> Option<&Entry> {
        self.entries.get(key)
    }

    /// Place of a byte.
    pub fn place(&self, byte: usize) -> Place {
        Place::from_offset(&self.path, &self.text, byte)
    }

    /// An error at the value of this key.
    pub fn wrong_value(&self, key: &str, message: impl Into<String>) -> DocumentError {
        self.wrong(
            self.get(key).map_or(0, |entry| entry.value_at.start),
            message,
        )
    }

    /// An error at this key itself.
    pub fn wrong_key(&self, key: &str, message: impl Into<String>) -> DocumentError {
        self.wrong(self.get(key).map_or(0, |entry| entry.key_at.start), message)
    }

    /// An error at this byte.
    pub fn wrong(&self, byte: usize, message: impl Into<String>) -> DocumentError {
        DocumentError::Wrong {
            place: self.place(byte),
            message: message.into(),
        }
    }
}

/// Error of the TOML parser, or of serde.
pub fn not_toml(path: &Path, text: &str, error: &toml::de::Error) -> DocumentError {
    DocumentError::Wrong {
        place: Place::from_offset(path, text, error.span().map_or(0, |span| span.start)),
        message: error
            .message()
            // What is missing at the top is in no table.
            .trim_end_matches("\nin ``")
            .replace('\n', ", ")
            .replace("f64", "a number"),
    }
}

fn collect(
    prefix: &str,
    table: &toml::Table,
    places: &DeTable<'_>,
    entries: &mut BTreeMap<String, Entry>,
) {
    for (name, at) in places {
        let Some(value) = table.get(name.get_ref().as_ref()) else {
            continue;
        };
        let key = format!("{prefix}{}", name.get_ref());
        if let (Value::Table(table), DeValue::Table(places)) = (value, at.get_ref()) {
            collect(&format!("{key}."), table, places, entries);
        } else {
            let entry = Entry {
                value: value.clone(),
                key_at: name.span(),
                value_at: at.span(),
            };
            entries.insert(key, entry);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keys_and_values_have_line_and_column() {
        let text = "link = \"sim:\"\n\n# µ\n[controller]\n  q = [15, 15,\n 1, 1]\n'µ'.b = 2\n";
        let path = Path::new("a.toml");
        let document = Document::parse(path, text.into()).unwrap();
        let at = |key: &str| {
            let entry = document.get(key).unwrap();
            let key = document.place(entry.key_at.start);
            let value = document.place(entry.value_at.start);
            (key.line, key.column, value.line, value.column)
        };
        assert_eq!(at("link"), (1, 1, 1, 8));
        assert_eq!(at("controller.q"), (5, 3, 5, 7));
        assert_eq!(at("controller.\u{b5}.b"), (7, 5, 7, 9));
        assert_eq!(document.entries().count(), 3);
        let error = document.wrong_value("controller.q", "not so");
        assert_eq!(error.to_string(), "a.toml:5:7: not so, in `q = [15, 15,`");
    }

    #[test]
    fn invalid_toml_is_an_error_of_one_line() {
        for text in [
            "a = 1\nb = = 2\n",
            "a = 1\na = 2\n",
            "[a\n",
            "é",
            "a.b = 1\na = 3",
        ] {
            let error = Document::parse(Path::new("a.toml"), text.into()).unwrap_err();
            let message = error.to_string();
            assert!(
                message.starts_with("a.toml:") && !message.contains('\n'),
                "{message}"
            );
        }
    }
}
