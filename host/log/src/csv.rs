//! `run.csv`: one row per tick, for spreadsheets and scripts.
//!
//! Columns are those of [`export::column`](mod@crate::export::column), joint 1's before
//! joint 2's; names carry units. `time_s` is the board's clock. A missing sample leaves
//! `count` empty and has its reason in `missing`; `alarms` are a stock servo's, with `+`
//! between them; `fault` is empty but in mode `fault`; `guards` lists the limiters that
//! changed the commanded torque. Rows end in a line feed.

use std::fs::File;
use std::path::{Path, PathBuf};

use armbridge_shared::link::message::Record;
use serde::Serialize;

use super::LogError;
use crate::export::column::{QUANTITIES, Values};

/// A column of the table.
#[derive(Debug)]
struct Column {
    name: &'static str,
    values: Values,
    joint: usize,
    /// All words of a column of words.
    words: Vec<String>,
}

/// A field of a row.
#[derive(Serialize)]
#[serde(untagged)]
enum Field<'a> {
    F64(f64),
    F32(f32),
    Integer(Option<u32>),
    Word(&'a str),
}

impl Column {
    /// All columns in order: neighbours that exist once per joint form a block, which
    /// is repeated for each joint.
    fn all() -> Vec<Self> {
        let blocks = QUANTITIES.chunk_by(|a, b| a.columns.len() == b.columns.len());
        let columns = blocks.flat_map(|block| {
            let joints = 0..block[0].columns.len();
            joints.flat_map(move |joint| {
                block.iter().map(move |quantity| Self {
                    name: quantity.columns[joint],
                    values: quantity.values,
                    joint,
                    words: match quantity.values {
                        Values::Word(words, _) => words.all(),
                        _ => Vec::new(),
                    },
                })
            })
        });
        columns.collect()
    }

    fn field(&self, record: &Record) -> Field<'_> {
        match self.values {
            Values::F64(get) => Field::F64(get(record)),
            Values::F32(get) => Field::F32(get(record, self.joint)),
            Values::U32(get) => Field::Integer(Some(get(record))),
            Values::U16(get) => Field::Integer(Some(get(record, self.joint).into())),
            Values::Sample(get) => Field::Integer(get(record, self.joint).map(u32::from)),
            Values::Word(_, get) => Field::Word(&self.words[get(record, self.joint)]),
        }
    }
}

/// Writes `run.csv`.
#[derive(Debug)]
pub struct CsvWriter {
    path: PathBuf,
    columns: Vec<Column>,
    writer: csv::Writer<File>,
}

impl CsvWriter {
    /// Creates the file, and writes its header.
    ///
    /// # Errors
    /// When the file cannot be created.
    pub fn create(path: &Path) -> Result<Self, LogError> {
        let failed = |source| LogError::Csv {
            path: path.to_path_buf(),
            source,
        };
        let columns = Column::all();
        let mut writer = csv::WriterBuilder::new()
            .has_headers(false)
            .buffer_capacity(1 << 16)
            .from_path(path)
            .map_err(failed)?;
        writer
            .write_record(columns.iter().map(|column| column.name))
            .map_err(failed)?;
        Ok(Self {
            path: path.to_path_buf(),
            columns,
            writer,
        })
    }

    /// Appends a tick.
    ///
    /// # Errors
    /// When the file cannot be written.
    pub fn record(&mut self, record: &Record) -> Result<(), LogError> {
        let fields = self.columns.iter().map(|column| column.field(record));
        let row: Vec<Field<'_>> = fields.collect();
        self.writer.serialize(row).map_err(|source| LogError::Csv {
            path: self.path.clone(),
            source,
        })
    }

    /// Flushes the buffer and closes the file.
    ///
    /// # Errors
    /// When the file cannot be written.
    pub fn finish(mut self) -> Result<(), LogError> {
        self.writer.flush().map_err(|source| LogError::Io {
            path: self.path,
            source,
        })
    }
}
