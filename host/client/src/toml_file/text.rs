//! Text of a file that a user names, of bounded length.
//!
//! A table and its places take more than fifty times the memory of their text, so that a file
//! without end would take all there is.

use std::fs::File;
use std::io::{self, Read};
use std::path::Path;

use super::DocumentError;

/// Longest TOML text in bytes: 20 000 steps of 200 bytes.
pub const TEXT_MAX: u64 = 4 << 20;

/// Reads a file of at most this many bytes.
///
/// # Errors
/// If it cannot be read, or is longer.
pub fn read_file(path: &Path, bytes_max: u64) -> Result<String, DocumentError> {
    read_text(path, File::open(path), bytes_max)
}

/// Reads at most this many bytes, called by this path in errors.
///
/// # Errors
/// If they cannot be read, or there are more.
pub fn read_text(
    path: &Path,
    source: io::Result<impl Read>,
    bytes_max: u64,
) -> Result<String, DocumentError> {
    let (mut text, mut bytes) = (String::new(), Vec::new());
    // Bytes first: a bound inside of a character is no error of its own.
    let read = source.and_then(|source| source.take(bytes_max + 1).read_to_end(&mut bytes));
    let unreadable = |source| DocumentError::Read {
        path: path.into(),
        source,
    };
    read.map_err(unreadable)?;
    if bytes.len() as u64 > bytes_max {
        return Err(DocumentError::TooLong {
            path: path.into(),
            most_mib: bytes_max >> 20,
        });
    }
    bytes
        .as_slice()
        .read_to_string(&mut text)
        .map_err(unreadable)?;
    Ok(text)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_text_without_end_is_an_error_that_names_the_bound() {
        let path = Path::new("long.toml");
        let read = |len| read_text(path, Ok(io::repeat(b'\n').take(len)), TEXT_MAX);
        assert_eq!(read(TEXT_MAX).unwrap().len() as u64, TEXT_MAX);
        for len in [TEXT_MAX + 1, u64::MAX] {
            let error = read(len).unwrap_err().to_string();
            assert!(
                error.starts_with("long.toml is longer than 4 MiB"),
                "{error}"
            );
        }
        let no_text = read_text(path, Ok([0xff].as_slice()), TEXT_MAX);
        assert!(matches!(no_text, Err(DocumentError::Read { .. })));
    }
}
