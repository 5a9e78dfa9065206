//! Tables of a file's keys: one list checks a file and explains it.
//!
//! A [`Key`] has a dotted path from the top of the file; lists of tables, as `[[step]]`,
//! count as tables, and the number of an entry is not part of the path. A file is
//! checked against its tables before it is parsed: an unknown key, a list of another
//! length and a number out of range are errors at their place. What depends on several
//! keys is left to the parser.

use std::fmt::{Result as Written, Write};
use std::ops::Range as Bytes;

use toml::Spanned;
use toml::de::{DeTable, DeValue};

use crate::params::{self, Range, Shape, Takes};

/// Width of explanations, in characters.
const WIDTH: usize = 80;

/// A key of a file.
#[derive(Clone, Copy, Debug)]
pub struct Key {
    /// Path from the top of the table, dotted.
    pub path: &'static str,
    /// Permitted values.
    pub takes: Kind,
    /// As `rad`; empty for a value without one.
    pub unit: &'static str,
    /// Default as written in a file, or in words; empty for none.
    pub default: &'static str,
    /// Meaning, in one sentence or two.
    pub about: &'static str,
}

/// Permitted values of a key.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Kind {
    /// Numbers, or one of several words.
    Value(Takes),
    /// A list of this many of these words.
    Words(usize, &'static [&'static str]),
    /// A list of this length, whose entries the parser checks.
    List(usize),
    /// Text.
    Text,
    /// A list of texts.
    Texts,
    /// True or false.
    Switch,
    /// A table with keys of its own.
    Table,
    /// A list of tables with keys of their own.
    Tables,
    /// The board's parameters, see [`params`].
    Parameters,
}

/// Keys below a prefix, which is empty or ends with a dot.
#[derive(Clone, Copy, Debug)]
pub struct KeyTable {
    /// Prefix of all paths.
    pub prefix: &'static str,
    /// The keys, in the order in which they are explained.
    pub keys: &'static [Key],
}

/// An error in a file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct KeyError {
    /// Its bytes in the text.
    pub at: Bytes<usize>,
    /// Error and permitted values.
    pub message: String,
}

impl Key {
    /// A key without unit and default.
    pub const fn new(path: &'static str, takes: Kind, about: &'static str) -> Self {
        Self {
            path,
            takes,
            unit: "",
            default: "",
            about,
        }
    }

    /// A number in a range.
    pub const fn number(path: &'static str, range: Range, about: &'static str) -> Self {
        let shape = Shape::One;
        Self::new(path, Kind::Value(Takes::Numbers { shape, range }), about)
    }

    /// A list of numbers in a range.
    pub const fn numbers(
        path: &'static str,
        count: usize,
        range: Range,
        about: &'static str,
    ) -> Self {
        let shape = Shape::List(count);
        Self::new(path, Kind::Value(Takes::Numbers { shape, range }), about)
    }

    /// The same with a unit.
    #[must_use]
    pub const fn unit(self, unit: &'static str) -> Self {
        Self { unit, ..self }
    }

    /// The same with a default.
    #[must_use]
    pub const fn or(self, default: &'static str) -> Self {
        Self { default, ..self }
    }

    /// Its last part.
    fn name(&self) -> &'static str {
        self.path.rsplit('.').next().unwrap_or(self.path)
    }

    /// Permitted values with the unit, as `2 numbers from -1.2 to 1.2 rad`.
    fn permitted(&self) -> String {
        let text = self.takes.to_string();
        // Every number in a file is finite.
        let text = text.strip_suffix(" finite").unwrap_or(&text);
        if self.unit.is_empty() {
            return text.to_owned();
        }
        // `a number from 0 up, in s`, but `a number from 0 to 5 s`.
        let is_closed = text.ends_with(|c: char| c.is_ascii_digit());
        let between = if is_closed { " " } else { ", in " };
        format!("{text}{between}{}", self.unit)
    }
}

impl std::fmt::Display for Kind {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Value(takes) => takes.fmt(f),
            Self::Words(count, words) => {
                write!(f, "a list of {count}, each {}", Takes::OneOf(words))
            }
            Self::List(count) => write!(f, "a list of {count}"),
            Self::Text => f.write_str("text"),
            Self::Texts => f.write_str("a list of texts"),
            Self::Switch => f.write_str("true or false"),
            Self::Table => f.write_str("a table"),
            Self::Tables => f.write_str("a list of tables"),
            Self::Parameters => f.write_str("parameters, as `armbridge params` lists them"),
        }
    }
}

/// Checks the keys and values of a text against tables. Text that is no TOML passes: the
/// parser has the better message.
///
/// # Errors
/// The first error in the order of the keys' names.
pub fn check(text: &str, tables: &[KeyTable]) -> Result<(), KeyError> {
    let Ok(document) = DeTable::parse(text) else {
        return Ok(());
    };
    check_table("", document.get_ref(), tables)
}

fn check_table(prefix: &str, table: &DeTable<'_>, tables: &[KeyTable]) -> Result<(), KeyError> {
    for (name, value) in table {
        let path = format!("{prefix}{}", name.get_ref());
        let key = find(&path, tables).ok_or_else(|| KeyError {
            at: name.span(),
            message: unknown(prefix, name.get_ref(), tables),
        })?;
        check_value(&path, key, value, tables)?;
    }
    Ok(())
}

fn check_value(
    path: &str,
    key: &Key,
    value: &Spanned<DeValue<'_>>,
    tables: &[KeyTable],
) -> Result<(), KeyError> {
    let wrong = |at: Bytes<usize>| KeyError {
        at,
        message: format!("`{}` takes {}", key.name(), key.permitted()),
    };
    let is_ok = match (key.takes, value.get_ref()) {
        (Kind::Table, DeValue::Table(table)) => {
            return check_table(&format!("{path}."), table, tables);
        }
        (Kind::Tables, DeValue::Array(list)) => {
            for entry in list {
                let DeValue::Table(table) = entry.get_ref() else {
                    return Err(wrong(entry.span()));
                };
                check_table(&format!("{path}."), table, tables)?;
            }
            true
        }
        (Kind::Parameters, DeValue::Table(_))
        | (Kind::Text, DeValue::String(_))
        | (Kind::Switch, DeValue::Boolean(_)) => true,
        (Kind::Texts, DeValue::Array(list)) => list
            .iter()
            .all(|entry| matches!(entry.get_ref(), DeValue::String(_))),
        (Kind::List(count), DeValue::Array(list)) => list.len() == count,
        (Kind::Words(count, words), DeValue::Array(list)) => {
            if let Some(other) = list.iter().find(|entry| !is_word(entry.get_ref(), words)) {
                return Err(wrong(other.span()));
            }
            list.len() == count
        }
        (Kind::Value(Takes::OneOf(words)), value) => is_word(value, words),
        (Kind::Value(Takes::Numbers { shape, range }), _) => {
            return check_numbers(value, shape, &range).map_err(wrong);
        }
        _ => false,
    };
    if is_ok {
        Ok(())
    } else {
        Err(wrong(value.span()))
    }
}

fn is_word(value: &DeValue<'_>, words: &[&str]) -> bool {
    matches!(value, DeValue::String(word) if words.contains(&&**word))
}

/// Checks count and range; returns the bytes of the first number, or of the list, that is
/// wrong.
fn check_numbers(
    value: &Spanned<DeValue<'_>>,
    shape: Shape,
    range: &Range,
) -> Result<(), Bytes<usize>> {
    let (rows, columns) = match shape {
        Shape::One => {
            let number = number(value.get_ref()).ok_or_else(|| value.span())?;
            let is_within = range.contains(number, f64::from);
            return if is_within { Ok(()) } else { Err(value.span()) };
        }
        Shape::List(count) => (None, count),
        Shape::Rows(rows, columns) => (Some(rows), columns),
    };
    let DeValue::Array(list) = value.get_ref() else {
        return Err(value.span());
    };
    if list.len() != rows.unwrap_or(columns) {
        return Err(value.span());
    }
    let inner = rows.map_or(Shape::One, |_| Shape::List(columns));
    list.iter()
        .try_for_each(|entry| check_numbers(entry, inner, range))
}

fn number(value: &DeValue<'_>) -> Option<f64> {
    match value {
        DeValue::Integer(integer) => {
            let whole = i64::from_str_radix(integer.as_str(), integer.radix()).ok()?;
            Some(whole as f64)
        }
        DeValue::Float(float) => float.as_str().parse().ok(),
        _ => None,
    }
}

/// The key with a path, its prefix included.
fn find<'a>(path: &str, tables: &'a [KeyTable]) -> Option<&'a Key> {
    let mut keys = tables.iter().filter_map(|table| {
        let path = path.strip_prefix(table.prefix)?;
        table.keys.iter().find(|key| key.path == path)
    });
    keys.next()
}

/// Names of the keys directly below a prefix.
fn below<'a>(prefix: &str, tables: &'a [KeyTable]) -> Vec<&'a str> {
    let keys = tables.iter().flat_map(|table| {
        table.keys.iter().filter_map(|key| {
            let path = format!("{}{}", table.prefix, key.path);
            let name = path.strip_prefix(prefix)?;
            (name == key.name()).then_some(key.name())
        })
    });
    keys.collect()
}

fn unknown(prefix: &str, name: &str, tables: &[KeyTable]) -> String {
    let known = below(prefix, tables);
    let meant = params::nearest(name, known.iter().copied())
        .map_or_else(String::new, |known| format!(" Is it `{known}`?"));
    format!(
        "there is no key `{name}` here.{meant} There are: {}",
        known.join(", ")
    )
}

/// Explanation of these tables' keys: each with permitted values, default and meaning.
pub fn explain(tables: &[KeyTable]) -> String {
    let mut text = String::new();
    // Writing to a string cannot fail.
    let _ = write_all(&mut text, tables);
    text
}

fn write_all(out: &mut String, tables: &[KeyTable]) -> Written {
    for key in tables.iter().flat_map(|table| table.keys) {
        match key.takes {
            Kind::Table => writeln!(out, "\n[{}]", key.path)?,
            Kind::Tables => writeln!(out, "\n[[{}]]", key.path)?,
            _ => {
                let default = if key.default.is_empty() {
                    String::new()
                } else {
                    format!("; default {}", key.default)
                };
                let line = format!("{}: {}{default}", key.path, key.permitted());
                wrapped(out, &line, "", "    ")?;
            }
        }
        wrapped(out, key.about, "    ", "    ")?;
    }
    Ok(())
}

/// Words in lines of at most [`WIDTH`].
fn wrapped(out: &mut String, text: &str, first: &str, next: &str) -> Written {
    let mut line = first.to_owned();
    for word in text.split(' ') {
        let is_empty = line.trim().is_empty();
        if !is_empty && line.chars().count() + 1 + word.chars().count() > WIDTH {
            writeln!(out, "{line}")?;
            next.clone_into(&mut line);
        } else if !is_empty {
            line.push(' ');
        }
        line.push_str(word);
    }
    writeln!(out, "{line}")
}

#[cfg(test)]
mod tests {
    use super::*;

    const TABLE: KeyTable = KeyTable {
        prefix: "",
        keys: &[
            Key::numbers("pair", 2, Range::reals(-1.0, 1.0), "Two numbers.").unit("rad"),
            Key::new("step", Kind::Tables, "Steps."),
            Key::number("step.at_s", Range::FROM_0, "Time.").unit("s"),
        ],
    };

    #[test]
    fn counts_ranges_and_names_are_checked_at_their_place() {
        for (text, at, words) in [
            ("pair = [1, 0.5]", None, ""),
            ("pair = [1, 2]", Some(11), "2 numbers from -1 to 1 rad"),
            ("pair = [1, 0, 0]", Some(7), "2 numbers"),
            ("pair = [1]", Some(7), "2 numbers"),
            ("pair = 1", Some(7), "2 numbers"),
            ("[[step]]\nat_s = nan", Some(16), "a number from 0 up, in s"),
            ("[[step]]\nat = 1", Some(9), "is it `at_s`"),
            ("step.at_s = 1", Some(0), "a list of tables"),
        ] {
            let found = check(text, &[TABLE]);
            let start = found.as_ref().err().map(|error| error.at.start);
            assert_eq!(start, at, "{text}: {found:?}");
            let message = found.map_or_else(|error| error.message, |()| String::new());
            assert!(message.to_lowercase().contains(words), "{text}: {message}");
        }
    }

    #[test]
    fn explanations_have_every_key_and_fit_the_terminal() {
        let text = explain(&[TABLE]);
        assert!(
            text.contains("step.at_s: a number from 0 up, in s"),
            "{text}"
        );
        assert!(text.lines().all(|line| line.chars().count() <= WIDTH));
    }
}
