//! `.mat` for MATLAB and Octave.
//!
//! | variable   | contents                                                          |
//! |------------|-------------------------------------------------------------------|
//! | `log`      | struct: `time_s`, `tick`, `angle_rad_1` ...; a row for each tick     |
//! | `units`    | struct: the unit of each of these fields                           |
//! | `columns`  | struct: meaning of each of these fields                           |
//! | `words`    | struct of cells: `words.board_mode{log.board_mode(k)}` is the mode of row `k` |
//! | `settings` | struct: the board's, nested at the dots of their names             |
//! | `about`    | text: description of the run, and of this file                    |
//!
//! Fields are the columns of `run.csv`. A missing count or true state is NaN; nothing is
//! interpolated, and `log.tick` jumps where records are missing. The ticks are read twice, to
//! count them and to write them, so that memory does not grow with the run.

pub mod level5;

use std::io::{BufWriter, Seek, SeekFrom, Write};
use std::path::PathBuf;

use toml::Value;

use super::column::{Column, Values, Words};
use super::{About, ExportError};
use crate::inspect::settings::Setting;
use crate::output_file::OutputFile;
use crate::recording::Row;
use level5::{Array, MOST_BYTES, Number, Output};

/// Rows that are buffered.
const ROWS: usize = 1 << 16;

/// Writes the file; each call of `rows` iterates over the ticks. Returns its path and its
/// number of ticks.
///
/// # Errors
/// If it cannot be written, or has more ticks than the format can hold.
pub fn write<I: Iterator<Item = Row>>(
    file: OutputFile,
    about: &About<'_>,
    rows: impl Fn() -> Result<I, ExportError>,
) -> Result<(PathBuf, u64), ExportError> {
    let path = file.path().to_path_buf();
    let columns = Column::all(about.has_true_states);
    let ticks = rows()?.count();
    let log = log(&columns, ticks);
    if log.bytes("log") > MOST_BYTES {
        return Err(ExportError::TooLong {
            path,
            ticks: ticks as u64,
        });
    }
    let failed = |source| ExportError::Write {
        path: path.clone(),
        source,
    };
    let mut file = BufWriter::new(file);
    let rooms = frame(&mut file, about, &columns, &log).map_err(failed)?;
    fill(&mut file, &columns, &rooms, ticks, rows()?).map_err(failed)?;
    let file = file
        .into_inner()
        .map_err(|error| failed(error.into_error()))?;
    Ok((ExportError::finish(file)?, ticks as u64))
}

/// Writes everything but the numbers of the ticks; returns their places.
fn frame(
    file: &mut impl Write,
    about: &About<'_>,
    columns: &[Column],
    log: &Array,
) -> std::io::Result<Vec<u64>> {
    let mut rooms = Vec::new();
    let mut out = Output::begin(file, &about.title())?;
    log.write("log", &mut out, &mut rooms)?;
    let of_each = |text: fn(&Column) -> &'static str| {
        let fields = columns.iter();
        let field = |column: &Column| (column.name.to_owned(), Array::Text(text(column).into()));
        Array::Struct(fields.map(field).collect())
    };
    of_each(|q| q.unit).write("units", &mut out, &mut rooms)?;
    of_each(|q| q.about).write("columns", &mut out, &mut rooms)?;
    words(columns).write("words", &mut out, &mut rooms)?;
    settings(&about.settings).write("settings", &mut out, &mut rooms)?;
    let text = format!(
        "{}\nRows are ticks; units and columns describe each field of log. \
         words.board_mode{{log.board_mode(k)}} is the mode of row k, and so for fault, guards, \
         missing and alarms. Nothing is interpolated: a missing count is NaN, and tick jumps \
         where records are missing.{}",
        about.title(),
        about.damage_in_words()
    );
    Array::Text(text).write("about", &mut out, &mut rooms)?;
    Ok(rooms)
}

/// The struct with room for this many ticks.
fn log(columns: &[Column], ticks: usize) -> Array {
    let fields = columns.iter().map(|column| {
        let room = Array::Reserved {
            number: number(column.values),
            rows: ticks,
            columns: 1,
        };
        (column.name.to_owned(), room)
    });
    Array::Struct(fields.collect())
}

fn number(values: Values) -> Number {
    match values {
        Values::F64(_) => Number::Double,
        // Counts to 1023 are exact, and what is missing can be NaN.
        Values::F32(_) | Values::Sample(_) | Values::Truth(_) => Number::Single,
        Values::U32(_) => Number::Uint32,
        Values::U16(_) => Number::Uint16,
        Values::Word(..) => Number::Uint8,
    }
}

fn words(columns: &[Column]) -> Array {
    let lists = columns.iter().filter_map(|column| match column.values {
        Values::Word(words, _) => Some((column.name.to_owned(), cells(words))),
        _ => None,
    });
    Array::Struct(lists.collect())
}

fn cells(words: Words) -> Array {
    Array::Cells(words.all().into_iter().map(Array::Text).collect())
}

/// A struct for each part of a dotted name.
fn settings(settings: &[Setting]) -> Array {
    let mut root = Vec::new();
    for setting in settings {
        insert(&mut root, setting.key, value(&setting.value));
    }
    Array::Struct(root)
}

fn insert(fields: &mut Vec<(String, Array)>, key: &str, array: Array) {
    let Some((group, rest)) = key.split_once('.') else {
        fields.push((key.to_owned(), array));
        return;
    };
    let at = fields.iter().position(|(name, _)| name == group);
    let at = at.unwrap_or_else(|| {
        fields.push((group.to_owned(), Array::Struct(Vec::new())));
        fields.len() - 1
    });
    if let (_, Array::Struct(inner)) = &mut fields[at] {
        insert(inner, rest, array);
    }
}

fn value(value: &Value) -> Array {
    match value {
        Value::Array(items) if items.iter().any(Value::is_array) => {
            Array::Numbers(items.iter().map(row).collect())
        }
        Value::Array(_) | Value::Integer(_) | Value::Float(_) => Array::Numbers(vec![row(value)]),
        Value::Boolean(flag) => Array::number(f64::from(*flag)),
        Value::String(text) => Array::Text(text.clone()),
        // Settings have neither.
        Value::Datetime(_) | Value::Table(_) => Array::Text(value.to_string()),
    }
}

/// A number, or a list of them.
fn row(value: &Value) -> Vec<f64> {
    match value {
        Value::Integer(number) => vec![*number as f64],
        Value::Float(number) => vec![*number],
        Value::Array(items) => items.iter().flat_map(row).collect(),
        Value::String(_) | Value::Boolean(_) | Value::Datetime(_) | Value::Table(_) => vec![],
    }
}

/// Writes every tick to its place.
fn fill(
    file: &mut (impl Write + Seek),
    columns: &[Column],
    rooms: &[u64],
    ticks: usize,
    rows: impl Iterator<Item = Row>,
) -> std::io::Result<()> {
    // Ticks beyond the counted ones have no room.
    let mut rows = rows.take(ticks);
    let mut done = 0;
    let mut bytes = Vec::new();
    loop {
        let rows: Vec<Row> = rows.by_ref().take(ROWS).collect();
        if rows.is_empty() {
            return file.flush();
        }
        for (column, room) in columns.iter().zip(rooms) {
            bytes.clear();
            column_bytes(&mut bytes, &rows, column.values, column.joint);
            let at = room + (number(column.values).size() * done) as u64;
            file.seek(SeekFrom::Start(at))?;
            file.write_all(&bytes)?;
        }
        done += rows.len();
    }
}

fn column_bytes(bytes: &mut Vec<u8>, rows: &[Row], values: Values, joint: usize) {
    let truths = rows.iter().map(|row| row.truth);
    let rows = rows.iter().map(|row| &row.record);
    match values {
        Values::F64(get) => bytes.extend(rows.flat_map(|row| get(row).to_le_bytes())),
        Values::F32(get) => bytes.extend(rows.flat_map(|row| get(row, joint).to_le_bytes())),
        Values::U32(get) => bytes.extend(rows.flat_map(|row| get(row).to_le_bytes())),
        Values::U16(get) => bytes.extend(rows.flat_map(|row| get(row, joint).to_le_bytes())),
        Values::Sample(get) => {
            let count = |row| get(row, joint).map_or(f32::NAN, f32::from);
            bytes.extend(rows.flat_map(|row| count(row).to_le_bytes()));
        }
        Values::Truth(get) => {
            let value = |truth: Option<_>| truth.map_or(f32::NAN, |truth| get(&truth, joint));
            bytes.extend(truths.flat_map(|truth| value(truth).to_le_bytes()));
        }
        // MATLAB counts from 1.
        Values::Word(_, get) => bytes.extend(rows.map(|row| get(row, joint) as u8 + 1)),
    }
}
