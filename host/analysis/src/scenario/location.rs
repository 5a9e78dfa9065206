//! Mistakes, and where in the file they are.

use std::fmt;
use std::ops::Range;
use std::path::Path;

use armbridge_client::params;
use armbridge_client::toml_file;
use armbridge_client::toml_file::DocumentError;
use serde::Deserialize;
use toml::de::{DeTable, DeValue};

/// A key's way down from the top: names, and numbers of what is in a list.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(super) struct Place(Vec<Part>);

#[derive(Clone, Debug, PartialEq, Eq)]
enum Part {
    Name(String),
    Number(usize),
}

impl Place {
    pub(super) fn top(name: &str) -> Self {
        Self::default().at(name)
    }

    /// What has this name in it.
    pub(super) fn at(&self, name: &str) -> Self {
        self.with(Part::Name(name.into()))
    }

    /// A parameter, which is written `group.name`: a key in a table.
    pub(super) fn key(&self, key: &str) -> Self {
        key.split('.')
            .fold(self.clone(), |place, name| place.at(name))
    }

    /// What has this number in it, from 0.
    pub(super) fn nth(&self, number: usize) -> Self {
        self.with(Part::Number(number))
    }

    fn with(&self, part: Part) -> Self {
        Self(self.0.iter().cloned().chain([part]).collect())
    }
}

/// Something wrong at a place.
#[derive(Clone, Debug)]
pub(super) struct Wrong {
    pub(super) place: Place,
    pub(super) message: String,
}

impl Wrong {
    pub(super) fn new(place: Place, message: impl fmt::Display) -> Self {
        Self {
            place,
            message: message.to_string(),
        }
    }
}

/// A scenario's text, and what it is called.
#[derive(Clone, Copy, Debug)]
pub(super) struct Text<'a> {
    pub(super) file: &'a Path,
    pub(super) text: &'a str,
}

impl Text<'_> {
    /// Reads it as what is wanted.
    pub(super) fn parse<T: for<'de> Deserialize<'de>>(&self) -> Result<T, DocumentError> {
        toml::from_str(self.text).map_err(|error| {
            let at = error.span().unwrap_or_default().start;
            self.mistake(at, in_words(error.message()))
        })
    }

    /// The same mistake, with line and column.
    pub(super) fn wrong(&self, Wrong { place, message }: Wrong) -> DocumentError {
        self.mistake(self.find(&place).unwrap_or_default().start, message)
    }

    fn mistake(&self, byte: usize, message: String) -> DocumentError {
        DocumentError::Wrong {
            place: toml_file::Place::of(self.file, self.text, byte),
            what: message,
        }
    }

    /// Where a place is, or the nearest above it that is in the file.
    fn find(&self, place: &Place) -> Option<Range<usize>> {
        let document = DeTable::parse(self.text).ok()?;
        let mut found = None;
        let mut value = DeValue::Table(document.into_inner());
        let mut parts = place.0.iter().peekable();
        while let Some(part) = parts.next() {
            let next = match part {
                Part::Name(name) => {
                    let DeValue::Table(table) = value else {
                        return found;
                    };
                    let is_last = parts.peek().is_none();
                    let entry = table.into_iter().find(|(key, _)| **key.get_ref() == **name);
                    entry.map(|(key, inner)| {
                        // A wrong value is where the value is, but that of a table
                        // begins with its key.
                        let is_plain = is_last && !matches!(inner.get_ref(), DeValue::Table(_));
                        let span = if is_plain { inner.span() } else { key.span() };
                        (span, inner.into_inner())
                    })
                }
                Part::Number(number) => {
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

/// The parser's message, reworded: an unknown key with the one that may have
/// been meant.
fn in_words(message: &str) -> String {
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
