//! `run.csv`: one row per tick, for spreadsheets and scripts.
//!
//! Columns are those of [`export::column`](mod@crate::export::column); names carry units.
//! `time_s` is the board's clock. A missing sample leaves `encoder_counts` empty and has its
//! reason in `missing`; `alarms` are a stock servo's, joined by `+`; `fault` is empty outside
//! mode `fault`; `guards` lists the limiters that changed the commanded torque. Rows end in a
//! line feed.

use std::path::{Path, PathBuf};

use serde::Serialize;

use super::LogError;
use crate::export::column::{Column, Values};
use crate::output_file::{Existing, OutputFile};
use crate::recording::Row;

/// A column with all words of a column of words.
#[derive(Debug)]
struct WordColumn {
    values: Values,
    joint: usize,
    words: Vec<String>,
}

/// A field of a row.
#[derive(Serialize)]
#[serde(untagged)]
enum Field<'a> {
    F64(f64),
    F32(Option<f32>),
    Integer(Option<u32>),
    Word(&'a str),
}

impl WordColumn {
    fn new(column: &Column) -> Self {
        Self {
            values: column.values,
            joint: column.joint,
            words: match column.values {
                Values::Word(words, _) => words.all(),
                _ => Vec::new(),
            },
        }
    }

    fn field(&self, Row { record, truth }: &Row) -> Field<'_> {
        let joint = self.joint;
        match self.values {
            Values::F64(get) => Field::F64(get(record)),
            Values::F32(get) => Field::F32(Some(get(record, joint))),
            Values::U32(get) => Field::Integer(Some(get(record))),
            Values::U16(get) => Field::Integer(Some(get(record, joint).into())),
            Values::Sample(get) => Field::Integer(get(record, joint).map(u32::from)),
            Values::Word(_, get) => Field::Word(&self.words[get(record, joint)]),
            Values::Truth(get) => Field::F32(truth.as_ref().map(|truth| get(truth, joint))),
        }
    }
}

/// Writes `run.csv`.
#[derive(Debug)]
pub struct CsvWriter {
    path: PathBuf,
    columns: Vec<WordColumn>,
    writer: csv::Writer<OutputFile>,
}

impl CsvWriter {
    /// Creates the file, which must not exist, and writes its header: with the true states of
    /// a simulated arm, or without them.
    ///
    /// # Errors
    /// When the file cannot be created.
    pub fn create(path: &Path, has_true_states: bool) -> Result<Self, LogError> {
        let file = OutputFile::create(path, Existing::Refuse);
        let file = file.map_err(|source| LogError::Io {
            path: path.to_path_buf(),
            source,
        })?;
        Self::to(file, has_true_states)
    }

    /// Writes the header of a file.
    ///
    /// # Errors
    /// When the file cannot be written.
    pub fn to(file: OutputFile, has_true_states: bool) -> Result<Self, LogError> {
        let path = file.path().to_path_buf();
        let failed = |source| LogError::Csv {
            path: path.clone(),
            source,
        };
        let columns = Column::all(has_true_states);
        let mut writer = csv::WriterBuilder::new()
            .has_headers(false)
            .buffer_capacity(1 << 16)
            .from_writer(file);
        writer
            .write_record(columns.iter().map(|column| column.name))
            .map_err(failed)?;
        Ok(Self {
            path,
            columns: columns.iter().map(WordColumn::new).collect(),
            writer,
        })
    }

    /// Appends a tick.
    ///
    /// # Errors
    /// When the file cannot be written.
    pub fn row(&mut self, row: &Row) -> Result<(), LogError> {
        let fields = self.columns.iter().map(|column| column.field(row));
        let row: Vec<Field<'_>> = fields.collect();
        self.writer.serialize(row).map_err(|source| LogError::Csv {
            path: self.path.clone(),
            source,
        })
    }

    /// Flushes the buffer and gives the file its name; returns its path, which may have a
    /// number.
    ///
    /// # Errors
    /// When the file cannot be written.
    pub fn finish(self) -> Result<PathBuf, LogError> {
        let Self { path, writer, .. } = self;
        let file = writer.into_inner().map_err(csv::IntoInnerError::into_error);
        file.and_then(OutputFile::finish)
            .map_err(|source| LogError::Io { path, source })
    }
}
