//! `.parquet` for pandas, polars, `DuckDB` and the like.
//!
//! Columns are those of `run.csv`. Words are stored once each; empty words and missing samples
//! are null. Units are in the columns' names, and in the file's metadata: `units` and `about`
//! are JSON objects by column, `run` describes the run, `settings` has the board's.
//!
//! Rows are written in groups, so that memory does not grow with the run.

use std::path::PathBuf;
use std::sync::Arc;

use parquet::basic::{Compression, Encoding, LogicalType, Repetition, Type as Physical};
use parquet::data_type::{ByteArray, ByteArrayType, DoubleType, FloatType, Int32Type};
use parquet::errors::ParquetError;
use parquet::file::metadata::KeyValue;
use parquet::file::properties::WriterProperties;
use parquet::file::writer::{SerializedColumnWriter, SerializedFileWriter};
use parquet::schema::types::{ColumnPath, Type};

use super::column::{Column, Values};
use super::{About, ExportError};
use crate::output_file::OutputFile;
use crate::recording::Row;

/// Rows of a group: two minutes at 1 kHz.
const ROWS: usize = 1 << 17;

/// Writes the file; returns its path, and its number of ticks.
///
/// # Errors
/// If it cannot be written.
pub fn write(
    mut file: OutputFile,
    about: &About<'_>,
    mut rows: impl Iterator<Item = Row>,
) -> Result<(PathBuf, u64), ExportError> {
    let path = file.path().to_path_buf();
    let failed = |source| ExportError::Parquet {
        path: path.clone(),
        source,
    };
    let columns = Column::all(about.has_true_states);
    let mut writer = schema(&columns)
        .and_then(|schema| {
            SerializedFileWriter::new(
                &mut file,
                Arc::new(schema),
                Arc::new(properties(about, &columns)),
            )
        })
        .map_err(failed)?;
    let mut ticks = 0;
    loop {
        let group: Vec<Row> = rows.by_ref().take(ROWS).collect();
        if group.is_empty() {
            break;
        }
        ticks += group.len() as u64;
        write_group(&mut writer, &columns, &group).map_err(failed)?;
    }
    writer.close().map_err(failed)?;
    Ok((ExportError::finish(file)?, ticks))
}

/// The columns in order.
fn schema(columns: &[Column]) -> Result<Type, ParquetError> {
    let fields = columns
        .iter()
        .map(|column| field(column.name, column.values).map(Arc::new));
    Type::group_type_builder("tick")
        .with_fields(fields.collect::<Result<_, _>>()?)
        .build()
}

fn field(name: &str, values: Values) -> Result<Type, ParquetError> {
    let unsigned = |bits| Some(LogicalType::integer(bits, false));
    let (physical, logical, optional) = match values {
        Values::F64(_) => (Physical::DOUBLE, None, false),
        Values::F32(_) => (Physical::FLOAT, None, false),
        Values::Truth(_) => (Physical::FLOAT, None, true),
        Values::U32(_) => (Physical::INT32, unsigned(32), false),
        Values::U16(_) => (Physical::INT32, unsigned(16), false),
        Values::Sample(_) => (Physical::INT32, unsigned(16), true),
        Values::Word(words, _) => (
            Physical::BYTE_ARRAY,
            Some(LogicalType::String),
            words.may_be_empty(),
        ),
    };
    Type::primitive_type_builder(name, physical)
        .with_logical_type(logical)
        .with_repetition(if optional {
            Repetition::OPTIONAL
        } else {
            Repetition::REQUIRED
        })
        .build()
}

fn properties(about: &About<'_>, columns: &[Column]) -> WriterProperties {
    let by_column = |text: fn(&Column) -> &'static str| {
        let texts = columns
            .iter()
            .map(|column| (column.name.to_owned(), text(column).into()));
        serde_json::Value::Object(texts.collect())
    };
    let pairs = [
        ("run", about.title()),
        ("units", by_column(|q| q.unit).to_string()),
        ("about", by_column(|q| q.about).to_string()),
        ("settings", about.settings_json()),
        ("damage", about.damage.join(" ")),
    ];
    let metadata = pairs.map(|(key, value)| KeyValue::new(key.to_owned(), value));
    let mut properties = WriterProperties::builder()
        .set_created_by(format!("armbridge {}", env!("CARGO_PKG_VERSION")))
        .set_compression(Compression::SNAPPY)
        .set_key_value_metadata(Some(metadata.into()));
    for column in columns {
        let encoding = match column.values {
            // The bytes of reals compress well when bytes of equal place are adjacent.
            Values::F64(_) | Values::F32(_) | Values::Truth(_) => Encoding::BYTE_STREAM_SPLIT,
            // Counters go up by little.
            Values::U32(_) => Encoding::DELTA_BINARY_PACKED,
            // Few different values: a dictionary.
            Values::U16(_) | Values::Sample(_) | Values::Word(..) => continue,
        };
        let path = ColumnPath::from(column.name);
        properties = properties
            .set_column_dictionary_enabled(path.clone(), false)
            .set_column_encoding(path, encoding);
    }
    properties.build()
}

fn write_group(
    writer: &mut SerializedFileWriter<&mut OutputFile>,
    columns: &[Column],
    rows: &[Row],
) -> Result<(), ParquetError> {
    let mut group = writer.next_row_group()?;
    for column in columns {
        // The schema has a column for each of these, in this order.
        if let Some(mut written) = group.next_column()? {
            write_column(&mut written, rows, column.values, column.joint)?;
            written.close()?;
        }
    }
    group.close()?;
    Ok(())
}

fn write_column(
    column: &mut SerializedColumnWriter<'_>,
    rows: &[Row],
    values: Values,
    joint: usize,
) -> Result<usize, ParquetError> {
    let truths = rows.iter().map(|row| row.truth);
    let rows = rows.iter().map(|row| &row.record);
    match values {
        Values::F64(get) => {
            let values: Vec<f64> = rows.map(get).collect();
            column
                .typed::<DoubleType>()
                .write_batch(&values, None, None)
        }
        Values::F32(get) => {
            let values: Vec<f32> = rows.map(|row| get(row, joint)).collect();
            column.typed::<FloatType>().write_batch(&values, None, None)
        }
        Values::U32(get) => {
            let values: Vec<i32> = rows.map(|row| get(row).cast_signed()).collect();
            column.typed::<Int32Type>().write_batch(&values, None, None)
        }
        Values::U16(get) => {
            let values: Vec<i32> = rows.map(|row| get(row, joint).into()).collect();
            column.typed::<Int32Type>().write_batch(&values, None, None)
        }
        Values::Sample(get) => {
            let all = rows.map(|row| get(row, joint));
            let levels: Vec<i16> = all.clone().map(|value| value.is_some().into()).collect();
            let values: Vec<i32> = all.flatten().map(i32::from).collect();
            column
                .typed::<Int32Type>()
                .write_batch(&values, Some(&levels), None)
        }
        Values::Truth(get) => {
            let levels: Vec<i16> = truths.clone().map(|truth| truth.is_some().into()).collect();
            let values: Vec<f32> = truths.flatten().map(|truth| get(&truth, joint)).collect();
            let column = column.typed::<FloatType>();
            column.write_batch(&values, Some(&levels), None)
        }
        Values::Word(words, get) => {
            let optional = words.may_be_empty();
            let words: Vec<ByteArray> = words.all().iter().map(|w| w.as_str().into()).collect();
            let all = rows.map(|row| get(row, joint));
            let levels: Vec<i16> = all.clone().map(|word| (word > 0).into()).collect();
            let values: Vec<ByteArray> = all
                .filter(|word| !optional || *word > 0)
                .map(|word| words[word].clone())
                .collect();
            column.typed::<ByteArrayType>().write_batch(
                &values,
                optional.then_some(levels.as_slice()),
                None,
            )
        }
    }
}
