//! Mistakes in a scenario file with their places.

use std::fmt;
use std::ops::Range;
use std::path::Path;

use armbridge_client::toml_file::DocumentError;
use armbridge_client::{params, toml_file};
use serde::Deserialize;
use toml::de::{DeTable, DeValue};

use super::keys::TABLES;

/// Path of a key from the top of the file: names, and indices in lists.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(super) struct KeyPath(Vec<Segment>);

#[derive(Clone, Debug, PartialEq, Eq)]
enum Segment {
    Name(String),
    Index(usize),
}

impl KeyPath {
    pub(super) fn top(name: &str) -> Self {
        Self::default().at(name)
    }

    /// Path of a named entry.
    pub(super) fn at(&self, name: &str) -> Self {
        self.with(Segment::Name(name.into()))
    }

    /// Path of a parameter, whose name is `group.name`.
    pub(super) fn key(&self, key: &str) -> Self {
        key.split('.')
            .fold(self.clone(), |place, name| place.at(name))
    }

    /// Path of a list's entry, from 0.
    pub(super) fn nth(&self, number: usize) -> Self {
        self.with(Segment::Index(number))
    }

    /// The first number of a list's entry in it.
    pub(super) fn first_index(&self) -> Option<usize> {
        self.0.iter().find_map(|segment| match segment {
            Segment::Index(number) => Some(*number),
            Segment::Name(_) => None,
        })
    }

    fn with(&self, part: Segment) -> Self {
        Self(self.0.iter().cloned().chain([part]).collect())
    }
}

/// A mistake and its place.
#[derive(Clone, Debug)]
pub(super) struct Mistake {
    pub(super) place: KeyPath,
    pub(super) message: String,
}

impl Mistake {
    pub(super) fn new(place: KeyPath, message: impl fmt::Display) -> Self {
        Self {
            place,
            message: message.to_string(),
        }
    }
}

/// Text of a scenario and the path of its file.
#[derive(Clone, Copy, Debug)]
pub(super) struct Text<'a> {
    pub(super) file: &'a Path,
    pub(super) text: &'a str,
}

impl Text<'_> {
    /// Checks the text against the table of keys, and parses it.
    pub(super) fn parse<T: for<'de> Deserialize<'de>>(&self) -> Result<T, DocumentError> {
        toml_file::keys::check(self.text, &TABLES)
            .map_err(|error| self.error(error.at.start, error.message))?;
        toml::from_str(self.text).map_err(|error| {
            let byte = error.span().unwrap_or_default().start;
            self.error(byte, reworded(error.message()))
        })
    }

    /// Error of a mistake with line and column.
    pub(super) fn locate(&self, Mistake { place, message }: Mistake) -> DocumentError {
        self.error(self.find(&place).unwrap_or_default().start, message)
    }

    /// Error at a byte of the text.
    pub(super) fn error(&self, byte: usize, message: String) -> DocumentError {
        DocumentError::Wrong {
            place: toml_file::Place::from_offset(self.file, self.text, byte),
            message,
        }
    }

    /// Byte range of a place, or of its nearest parent in the file.
    fn find(&self, place: &KeyPath) -> Option<Range<usize>> {
        let document = DeTable::parse(self.text).ok()?;
        let mut found = None;
        let mut value = DeValue::Table(document.into_inner());
        let mut parts = place.0.iter().peekable();
        while let Some(part) = parts.next() {
            let next = match part {
                Segment::Name(name) => {
                    let DeValue::Table(table) = value else {
                        return found;
                    };
                    let is_last = parts.peek().is_none();
                    let entry = table.into_iter().find(|(key, _)| **key.get_ref() == **name);
                    entry.map(|(key, inner)| {
                        // The place of a value is that of the value; that of a table is
                        // its key.
                        let is_plain = is_last && !matches!(inner.get_ref(), DeValue::Table(_));
                        let span = if is_plain { inner.span() } else { key.span() };
                        (span, inner.into_inner())
                    })
                }
                Segment::Index(number) => {
                    let DeValue::Array(list) = value else {
                        return found;
                    };
                    let entry = list.into_iter().nth(*number);
                    entry.map(|inner| (inner.span(), inner.into_inner()))
                }
            };
            let Some((span, inner)) = next else {
                return found;
            };
            found = Some(span);
            value = inner;
        }
        found
    }
}

/// The parser's message in plain words; an unknown key with the nearest known one.
fn reworded(message: &str) -> String {
    let message = message.replace('\n', ", ");
    let Some(unknown) = message.strip_prefix("unknown field ") else {
        return message
            .replace("f64", "a number")
            .replace("f32", "a number");
    };
    let mut names = unknown.split('`').skip(1).step_by(2);
    let name = names.next().unwrap_or_default();
    let known: Vec<&str> = names.collect();
    let meant = params::nearest(name, known.iter().copied())
        .map_or_else(String::new, |known| format!(" Is it `{known}`?"));
    format!(
        "there is no key `{name}` here.{meant} There are: {}",
        known.join(", ")
    )
}
