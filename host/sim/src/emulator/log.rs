//! Log of the firmware as lines.
//!
//! defmt keeps format strings out of the image's memory and sends their index:
//! the table is in the ELF file, and decoding needs the file that runs. Lines are
//! decoded with the feature `defmt`.

use std::io::Read;
use std::thread::JoinHandle;

use super::Image;
#[cfg(feature = "defmt")]
use defmt_decoder::{DecodeError, Table};

/// Decodes `stream` on a thread of its own until it ends, and passes each line
/// to `line`. An image without defmt has no log.
///
/// # Errors
/// If the image cannot be read.
#[cfg(feature = "defmt")]
pub fn spawn(
    image: &Image,
    mut stream: impl Read + Send + 'static,
    mut line: impl FnMut(String) + Send + 'static,
) -> std::io::Result<JoinHandle<()>> {
    let table = Table::parse(&std::fs::read(&image.path)?).ok().flatten();
    Ok(std::thread::spawn(move || {
        let mut bytes = [0; 1024];
        let mut decoder = table.as_ref().map(Table::new_stream_decoder);
        while let Ok(count @ 1..) = stream.read(&mut bytes) {
            let Some(decoder) = &mut decoder else {
                continue;
            };
            decoder.received(&bytes[..count]);
            loop {
                match decoder.decode() {
                    Ok(frame) => line(frame.display(false).to_string()),
                    Err(DecodeError::UnexpectedEof) => break,
                    Err(DecodeError::Malformed) => line("(malformed log frame)".into()),
                }
            }
        }
    }))
}

/// Reads `stream` to its end on a thread of its own, because a full socket would block
/// the board; the only line states that nothing is decoded.
///
/// # Errors
/// None.
#[cfg(not(feature = "defmt"))]
pub fn spawn(
    _: &Image,
    mut stream: impl Read + Send + 'static,
    mut line: impl FnMut(String) + Send + 'static,
) -> std::io::Result<JoinHandle<()>> {
    Ok(std::thread::spawn(move || {
        line("(this build does not decode the log; `cargo build --release --features defmt` makes one that does)".into());
        // It ends when the board does.
        let _ = std::io::copy(&mut stream, &mut std::io::sink());
    }))
}
