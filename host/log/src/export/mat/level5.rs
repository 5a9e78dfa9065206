//! MAT-files of level 5, as far as needed for logs, by `MathWorks`' *MAT-File Format*.
//!
//! | bytes    | contents                                                       |
//! |----------|----------------------------------------------------------------|
//! | 116      | a text that describes the file                                 |
//! | 8        | offset of subsystem data; zero                                 |
//! | 4        | version 0x0100, then `IM`: little endian                       |
//! | then     | one element for each variable, each an array with its name     |
//!
//! An element is a tag (type and number of bytes, 4 each) and its data, filled up
//! to a multiple of 8 bytes. An array is an element of elements: flags with the
//! class, dimensions, name, then the contents of the class: numbers, characters, fields or
//! cells. Nothing is compressed, so that places of numbers are known in advance:
//! [`Array::Reserved`] reserves room that is filled later, column by column.

use std::io::{self, Write};

/// Bytes before the first element.
pub const HEADER: usize = 128;

/// Length of the description.
const TEXT: usize = 116;

/// Bytes of a field's name, its final zero included.
const FIELD_NAME: usize = 64;

/// Largest array: MATLAB limits its length to 31 bits.
pub(crate) const MOST_BYTES: u64 = i32::MAX as u64;

/// Types of data.
mod data {
    pub(super) const INT8: u32 = 1;
    pub(super) const UINT16: u32 = 4;
    pub(super) const INT32: u32 = 5;
    pub(super) const UINT32: u32 = 6;
    pub(super) const DOUBLE: u32 = 9;
    pub(super) const MATRIX: u32 = 14;
}

/// Classes of arrays.
mod class {
    pub(super) const CELL: u32 = 1;
    pub(super) const STRUCT: u32 = 2;
    pub(super) const CHAR: u32 = 4;
    pub(super) const DOUBLE: u32 = 6;
}

/// Kinds of numbers in reserved room.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Number {
    /// 8-byte reals.
    Double,
    /// 4-byte reals.
    Single,
    /// Bytes.
    Uint8,
    /// 2-byte integers.
    Uint16,
    /// 4-byte integers.
    Uint32,
}

impl Number {
    /// Bytes of one.
    pub fn size(self) -> usize {
        match self {
            Self::Double => 8,
            Self::Single | Self::Uint32 => 4,
            Self::Uint16 => 2,
            Self::Uint8 => 1,
        }
    }

    fn class(self) -> u32 {
        match self {
            Self::Double => class::DOUBLE,
            Self::Single => 7,
            Self::Uint8 => 9,
            Self::Uint16 => 11,
            Self::Uint32 => 13,
        }
    }

    fn data(self) -> u32 {
        match self {
            Self::Double => data::DOUBLE,
            Self::Single => 7,
            Self::Uint8 => 2,
            Self::Uint16 => data::UINT16,
            Self::Uint32 => data::UINT32,
        }
    }
}

/// An array.
#[derive(Clone, Debug, PartialEq)]
pub enum Array {
    /// One struct, its fields in order.
    Struct(Vec<(String, Array)>),
    /// A column of cells.
    Cells(Vec<Array>),
    /// A row of characters.
    Text(String),
    /// Rows of numbers, all of one length.
    Numbers(Vec<Vec<f64>>),
    /// Reserved room for a matrix, column after column.
    Reserved {
        /// Type of the numbers.
        number: Number,
        /// Rows.
        rows: usize,
        /// Columns.
        columns: usize,
    },
}

impl Array {
    /// A single number.
    pub fn number(value: f64) -> Self {
        Self::Numbers(vec![vec![value]])
    }

    /// Bytes of its element, without the tag, under this name.
    pub fn bytes(&self, name: &str) -> u64 {
        let head = 16 + 16 + 8 + filled(name.len());
        head + match self {
            Self::Struct(fields) => {
                let names = 8 + 8 + filled(fields.len() * FIELD_NAME);
                let arrays = fields.iter().map(|(_, array)| 8 + array.bytes(""));
                names + arrays.sum::<u64>()
            }
            Self::Cells(cells) => cells.iter().map(|cell| 8 + cell.bytes("")).sum(),
            Self::Text(text) => 8 + filled(2 * text.encode_utf16().count()),
            Self::Numbers(rows) => 8 + filled(8 * rows.iter().map(Vec::len).sum::<usize>()),
            Self::Reserved {
                number,
                rows,
                columns,
            } => 8 + filled(number.size() * rows * columns),
        }
    }

    /// Writes it as a variable of this name. The file positions of all reserved rooms, in
    /// order, are appended to `rooms`; they are filled with zeros.
    ///
    /// # Errors
    /// If it cannot be written.
    pub fn write(&self, name: &str, out: &mut Output<'_>, rooms: &mut Vec<u64>) -> io::Result<()> {
        out.tag(data::MATRIX, self.bytes(name))?;
        let (class, rows, columns) = self.shape();
        out.tag(data::UINT32, 8)?;
        out.put(&class.to_le_bytes())?;
        out.put(&[0; 4])?;
        out.tag(data::INT32, 8)?;
        out.put(&(rows as u32).to_le_bytes())?;
        out.put(&(columns as u32).to_le_bytes())?;
        out.element(data::INT8, name.as_bytes())?;
        match self {
            Self::Struct(fields) => {
                // A small element: its length shares the tag with its type.
                out.put(&(4 << 16 | data::INT32).to_le_bytes())?;
                out.put(&(FIELD_NAME as u32).to_le_bytes())?;
                let mut names = Vec::with_capacity(fields.len() * FIELD_NAME);
                for (name, _) in fields {
                    // One byte is left for the final zero.
                    let name = &name.as_bytes()[..name.len().min(FIELD_NAME - 1)];
                    names.extend_from_slice(name);
                    names.resize(names.len() + FIELD_NAME - name.len(), 0);
                }
                out.tag(data::INT8, names.len() as u64)?;
                out.put(&names)?;
                let mut fields = fields.iter();
                fields.try_for_each(|(_, array)| array.write("", out, rooms))
            }
            Self::Cells(cells) => cells.iter().try_for_each(|cell| cell.write("", out, rooms)),
            Self::Text(text) => {
                let units = text.encode_utf16().flat_map(u16::to_le_bytes);
                out.element(data::UINT16, &units.collect::<Vec<u8>>())
            }
            Self::Numbers(rows) => {
                let columns = (0..columns).flat_map(|c| rows.iter().map(move |row| row[c]));
                let bytes: Vec<u8> = columns.flat_map(f64::to_le_bytes).collect();
                out.element(data::DOUBLE, &bytes)
            }
            Self::Reserved { number, .. } => {
                let bytes = number.size() * rows * columns;
                out.tag(number.data(), bytes as u64)?;
                rooms.push(out.at);
                out.zeros(filled(bytes))
            }
        }
    }

    /// Class, rows and columns.
    fn shape(&self) -> (u32, usize, usize) {
        match self {
            Self::Struct(_) => (class::STRUCT, 1, 1),
            Self::Cells(cells) => (class::CELL, cells.len(), 1),
            Self::Text(text) => {
                let units = text.encode_utf16().count();
                // MATLAB's own '' has no rows either.
                (class::CHAR, usize::from(units > 0), units)
            }
            Self::Numbers(rows) => (class::DOUBLE, rows.len(), rows.first().map_or(0, Vec::len)),
            Self::Reserved {
                number,
                rows,
                columns,
            } => (number.class(), *rows, *columns),
        }
    }
}

/// A file being written, and the position in it.
pub struct Output<'a> {
    file: &'a mut dyn Write,
    at: u64,
}

impl<'a> Output<'a> {
    /// Writes the header.
    ///
    /// # Errors
    /// If it cannot be written.
    pub fn begin(file: &'a mut dyn Write, about: &str) -> io::Result<Self> {
        let mut header = [b' '; HEADER];
        // Readers detect the format by these words.
        let text = format!("MATLAB 5.0 MAT-file, {about}");
        let ascii = text.bytes().filter(u8::is_ascii).take(TEXT);
        header
            .iter_mut()
            .zip(ascii)
            .for_each(|(to, from)| *to = from);
        header[TEXT..TEXT + 8].fill(0);
        header[TEXT + 8..].copy_from_slice(&[0x00, 0x01, b'I', b'M']);
        let mut output = Self { file, at: 0 };
        output.put(&header)?;
        Ok(output)
    }

    fn put(&mut self, bytes: &[u8]) -> io::Result<()> {
        self.at += bytes.len() as u64;
        self.file.write_all(bytes)
    }

    fn zeros(&mut self, count: u64) -> io::Result<()> {
        self.at += count;
        io::copy(&mut io::Read::take(io::repeat(0), count), &mut self.file).map(|_| ())
    }

    fn tag(&mut self, data: u32, bytes: u64) -> io::Result<()> {
        let bytes = u32::try_from(bytes).map_err(|_| io::ErrorKind::FileTooLarge)?;
        self.put(&data.to_le_bytes())?;
        self.put(&bytes.to_le_bytes())
    }

    fn element(&mut self, data: u32, bytes: &[u8]) -> io::Result<()> {
        self.tag(data, bytes.len() as u64)?;
        self.put(bytes)?;
        self.zeros(filled(bytes.len()) - bytes.len() as u64)
    }
}

/// Bytes up to the next multiple of 8.
fn filled(bytes: usize) -> u64 {
    bytes.next_multiple_of(8) as u64
}
