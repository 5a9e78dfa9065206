//! List of a release's firmware images, `images.json`: which of them does a board run?
//!
//! `cargo release` writes it beside the images; `armbridge status` compares it with the
//! checksum that the board reports.
//!
//! ```json
//! {
//!   "version": "0.1.0",
//!   "commit": "8a6aad6e...",
//!   "images": [{ "board": "feather-f405", "image_crc32": "1fb5a9c4", "sha256": "9c1e..." }]
//! }
//! ```

use std::path::{Path, PathBuf};
use std::{fs, io};

use serde::{Deserialize, Serialize};

/// Name of the file.
pub const FILE_NAME: &str = "images.json";

/// The images of a release.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct ImageList {
    /// Version of the release.
    pub version: String,
    /// Commit that it was built from, with `-dirty` behind it if sources differed.
    pub commit: String,
    /// One image for each board.
    pub images: Vec<ListedImage>,
}

/// An image.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct ListedImage {
    /// The board that it is for.
    pub board: String,
    /// CRC-32 that this board reports when it runs the image, in eight hexadecimal digits.
    pub image_crc32: String,
    /// SHA-256 of its `.bin` file, in hexadecimal digits.
    pub sha256: String,
}

/// Reason for which there is no list.
#[derive(Debug, thiserror::Error)]
pub enum ImageListError {
    /// The file cannot be read.
    #[error("cannot read the list of images {}: {error}", path.display())]
    Read {
        /// Its path.
        path: PathBuf,
        /// Error of the system.
        error: io::Error,
    },
    /// The file is no list.
    #[error(
        "{} is no list of images: {error}; download {FILE_NAME} again, or make it with \
         `cargo release`", path.display()
    )]
    Parse {
        /// Its path.
        path: PathBuf,
        /// Defect, and its place.
        error: serde_json::Error,
    },
}

impl ImageList {
    /// Reads a list.
    ///
    /// # Errors
    /// If the file cannot be read or is no list.
    pub fn open(path: &Path) -> Result<Self, ImageListError> {
        let path = path.to_path_buf();
        match fs::read(&path) {
            Ok(text) => {
                serde_json::from_slice(&text).map_err(|error| ImageListError::Parse { path, error })
            }
            Err(error) => Err(ImageListError::Read { path, error }),
        }
    }

    /// Reads the list beside the program that runs, if there is one.
    ///
    /// # Errors
    /// If there is one that cannot be read.
    pub fn beside_program() -> Result<Option<Self>, ImageListError> {
        let program = std::env::current_exe().ok();
        let path = program.map(|program| program.with_file_name(FILE_NAME));
        match path.filter(|path| path.is_file()) {
            Some(path) => Self::open(&path).map(Some),
            None => Ok(None),
        }
    }

    /// The image with this checksum.
    pub fn find(&self, crc32: u32) -> Option<&ListedImage> {
        let text = format!("{crc32:08x}");
        let mut images = self.images.iter();
        images.find(|image| image.image_crc32.eq_ignore_ascii_case(&text))
    }

    /// Which image of the release a board with this checksum runs, in a sentence's part.
    pub fn in_words(&self, crc32: u32) -> String {
        let version = &self.version;
        if let Some(image) = self.find(crc32) {
            return format!("the image for {} of release {version}", image.board);
        }
        let listed = self.images.iter();
        let listed = listed.map(|image| format!("{} {}", image.board, image.image_crc32));
        format!(
            "none of release {version} ({}): flash the board's image to have it",
            listed.collect::<Vec<_>>().join(", ")
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn list() -> ImageList {
        let image = |board: &str, image_crc32: &str| ListedImage {
            board: board.into(),
            image_crc32: image_crc32.into(),
            sha256: "00".repeat(32),
        };
        ImageList {
            version: "1.2.3".into(),
            commit: "abc".into(),
            images: vec![image("one", "0000beef"), image("two", "89ABCDEF")],
        }
    }

    #[test]
    fn an_image_is_found_by_its_checksum() {
        let list = list();
        let board = |crc32| list.find(crc32).map(|image| &*image.board);
        assert_eq!(board(0xBEEF), Some("one"));
        assert_eq!(board(0x89AB_CDEF), Some("two"));
        assert_eq!(board(0), None);
        assert_eq!(list.in_words(0xBEEF), "the image for one of release 1.2.3");
        let other = list.in_words(7);
        let words = "none of release 1.2.3 (one 0000beef, two 89ABCDEF)";
        assert!(other.starts_with(words), "{other}");
    }

    #[test]
    fn a_list_is_written_and_read_and_damage_is_named_with_its_place() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join(FILE_NAME);
        let text = serde_json::to_string_pretty(&list()).unwrap();
        fs::write(&path, &text).unwrap();
        assert_eq!(ImageList::open(&path).unwrap(), list());

        fs::write(&path, text.replace("\"commit\"", "\"comet\"")).unwrap();
        let error = ImageList::open(&path).unwrap_err().to_string();
        for words in [FILE_NAME, "`commit`", "line ", "cargo release"] {
            assert!(error.contains(words), "{words}: {error}");
        }
        let missing = folder.path().join("missing.json");
        let error = ImageList::open(&missing).unwrap_err().to_string();
        assert!(error.contains("missing.json"), "{error}");
    }
}
