//! The firmware image of a URI: a named file, or that of the source tree in which the program
//! is called, if it is up to date with the sources.
//!
//! The tree is looked for from a folder upwards, so that the program runs the firmware
//! beside which it is called, wherever the program itself was built. Its image is
//! compared with its sources as cargo compares them: by the times of the files, which
//! cargo lists in a `.d` file beside the image. A source that is newer than the image,
//! or missing, makes the image stale.
//!
//! An image is known by the checksum of its bytes in flash, the same number that the
//! firmware computes at boot and reports as its `image`.

use std::fmt;
use std::io;
use std::path::{Path, PathBuf};
use std::time::SystemTime;

use armbridge_shared::crc32::checksum;

/// Path of the emulator's image in cargo's target folder.
const IN_TARGET: &str = "thumbv7em-none-eabihf/firmware/mps2-an386";

/// Largest extent of an image in flash, in bytes: that of the board.
const FLASH_LEN: usize = 1 << 20;

/// A firmware image for QEMU.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Image {
    /// The ELF file.
    pub path: PathBuf,
    /// CRC-32 of the image in flash, as the board reports it.
    pub crc32: u32,
}

/// Reason for which there is no image to run.
#[derive(Debug, thiserror::Error)]
pub enum ImageError {
    /// No source tree surrounds the folder.
    #[error(
        "emulate: runs the firmware image of a source tree of Armbridge, and {} is in none: call \
         it in the tree (where `cargo build-emulator` builds the image), or name an image, as in \
         emulate:IMAGE", .0.display()
    )]
    NoTree(PathBuf),
    /// There is no image where it should be.
    #[error("no firmware image at {}: build it with `cargo build-emulator`", .0.display())]
    NotBuilt(PathBuf),
    /// The file is not an image.
    #[error("{} is no ELF file for ARM: build the image with `cargo build-emulator`", .0.display())]
    NotAnImage(PathBuf),
    /// The list of the image's sources is missing.
    #[error(
        "no list of the sources of {} beside it: build it with `cargo build-emulator`",
        .0.display()
    )]
    NoSources(PathBuf),
    /// The image was built in another source tree.
    #[error(
        "{} was not built from {}: build it there with `cargo build-emulator`",
        image.display(), tree.display()
    )]
    OtherTree {
        /// The image.
        image: PathBuf,
        /// The tree that the program is called in.
        tree: PathBuf,
    },
    /// A source is newer than the image; its contents may be the same.
    #[error(
        "{} is newer than the firmware image, or gone: build the image again with `cargo \
         build-emulator`, or name it to run it as it is, emulate:{}",
        source_file.display(), image.display()
    )]
    Stale {
        /// The image.
        image: PathBuf,
        /// A source that is newer, or missing.
        source_file: PathBuf,
    },
    /// The file system failed.
    #[error("cannot read the firmware image: {0}")]
    Io(#[from] io::Error),
}

impl Image {
    /// This file.
    ///
    /// # Errors
    /// If it cannot be read, or is not an image.
    pub fn open(path: &Path) -> Result<Self, ImageError> {
        let elf = std::fs::read(path).map_err(|_| ImageError::NotBuilt(path.into()))?;
        let flash = flash(&elf).ok_or_else(|| ImageError::NotAnImage(path.into()))?;
        // The board cannot read the first word at its address, see the firmware.
        let crc32 = checksum(flash.get(4..).unwrap_or_default());
        let path = path.into();
        Ok(Self { path, crc32 })
    }

    /// The current image of the source tree that the current folder is in.
    ///
    /// # Errors
    /// If there is no tree, or its image is missing or older than its sources.
    pub fn current() -> Result<Self, ImageError> {
        let folder = std::env::current_dir()?;
        let tree = tree_around(&folder).ok_or_else(|| ImageError::NoTree(folder.clone()))?;
        let target = std::env::var_os("CARGO_TARGET_DIR").filter(|target| !target.is_empty());
        Self::of_tree(tree, &tree.join(target.unwrap_or_else(|| "target".into())))
    }

    /// The current image of this source tree, in this target folder of cargo.
    fn of_tree(tree: &Path, target: &Path) -> Result<Self, ImageError> {
        let path = target.join(IN_TARGET);
        let Ok(built) = modified(&path) else {
            return Err(ImageError::NotBuilt(path));
        };
        let Ok(list) = std::fs::read_to_string(path.with_extension("d")) else {
            return Err(ImageError::NoSources(path));
        };
        let sources = listed(&list);
        if !sources.iter().any(|source| source.starts_with(tree)) {
            let tree = tree.into();
            return Err(ImageError::OtherTree { image: path, tree });
        }
        let is_newer = |source: &PathBuf| modified(source).map_or(true, |time| time > built);
        match sources.into_iter().find(is_newer) {
            Some(source) => Err(ImageError::Stale {
                source_file: relative(&source, tree),
                image: path,
            }),
            None => Self::open(&path),
        }
    }
}

impl fmt::Display for Image {
    /// Path, from the current folder if the image is in it, and checksum.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let folder = std::env::current_dir().unwrap_or_default();
        let path = self.path.strip_prefix(folder).unwrap_or(&self.path);
        write!(f, "{}, CRC-32 {:08x}", path.display(), self.crc32)
    }
}

fn modified(path: &Path) -> io::Result<SystemTime> {
    std::fs::metadata(path)?.modified()
}

/// A path below a folder as it is named from there; cargo lists some through `..`.
fn relative(path: &Path, folder: &Path) -> PathBuf {
    let real = |path: &Path| path.canonicalize().unwrap_or_else(|_| path.into());
    let (path, folder) = (real(path), real(folder));
    path.strip_prefix(folder).unwrap_or(&path).into()
}

/// The source tree of this project that surrounds a folder.
pub fn tree_around(folder: &Path) -> Option<&Path> {
    folder.ancestors().find(|root| {
        let manifest = std::fs::read_to_string(root.join("firmware/Cargo.toml"));
        root.join("Cargo.toml").is_file()
            && manifest.is_ok_and(|text| text.contains("name = \"armbridge-firmware\""))
    })
}

/// The sources in a `.d` file: `IMAGE: SOURCE SOURCE ..`, with spaces inside paths behind
/// backslashes.
fn listed(list: &str) -> Vec<PathBuf> {
    let line = list.lines().next().unwrap_or_default();
    let (_, sources) = line.split_once(": ").unwrap_or_default();
    let sources = sources.replace("\\ ", "\0");
    let sources = sources.split(' ').filter(|source| !source.is_empty());
    sources
        .map(|source| source.replace('\0', " ").into())
        .collect()
}

/// Contents of flash, from the beginning of the image to its end: what the ELF file loads
/// there, variables' initial values included, zeros between. `None` if the file is no
/// 32-bit little-endian ELF file for ARM that loads anything.
fn flash(elf: &[u8]) -> Option<Vec<u8>> {
    /// Kind of the segments that are loaded.
    const PT_LOAD: usize = 1;
    /// The ARM architecture.
    const EM_ARM: usize = 40;

    let word = |at: usize| {
        let bytes = elf.get(at..at.checked_add(4)?)?;
        Some(u32::from_le_bytes(bytes.try_into().ok()?) as usize)
    };
    let half = |at: usize| {
        Some(usize::from(u16::from_le_bytes(
            *elf.get(at..)?.first_chunk()?,
        )))
    };
    // Class 32 bits, little endian, behind the magic bytes.
    if !elf.starts_with(b"\x7FELF\x01\x01") || half(18)? != EM_ARM {
        return None;
    }
    let (table, entry_len, entries) = (word(28)?, half(42)?, half(44)?);
    let mut loaded: Vec<(usize, &[u8])> = Vec::new();
    for entry in (0..entries).map(|entry| table + entry * entry_len) {
        let (kind, offset, address, len) = (
            word(entry)?,
            word(entry + 4)?,
            word(entry + 12)?,
            word(entry + 16)?,
        );
        if kind == PT_LOAD && len > 0 {
            loaded.push((address, elf.get(offset..offset.checked_add(len)?)?));
        }
    }
    let begin = loaded.iter().map(|(address, _)| *address).min()?;
    let mut flash = Vec::new();
    for (address, bytes) in loaded {
        let at = address - begin;
        let end = at.checked_add(bytes.len())?;
        if end > FLASH_LEN {
            return None;
        }
        flash.resize(flash.len().max(end), 0);
        flash[at..end].copy_from_slice(bytes);
    }
    Some(flash)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs::{self, File};
    use std::time::Duration;

    /// An ELF file that loads these bytes at these addresses.
    fn elf(segments: &[(u32, &[u8])]) -> Vec<u8> {
        const HEADER_LEN: usize = 52;
        const ENTRY_LEN: usize = 32;
        let mut file = vec![0; HEADER_LEN + ENTRY_LEN * segments.len()];
        file[..6].copy_from_slice(b"\x7FELF\x01\x01");
        file[18] = 40;
        file[28] = HEADER_LEN as u8;
        file[42] = ENTRY_LEN as u8;
        file[44] = segments.len() as u8;
        for (index, (address, bytes)) in segments.iter().enumerate() {
            let offset = file.len() as u32;
            let entry = HEADER_LEN + ENTRY_LEN * index;
            for (at, value) in [
                (0, 1),
                (4, offset),
                (12, *address),
                (16, bytes.len() as u32),
            ] {
                file[entry + at..entry + at + 4].copy_from_slice(&value.to_le_bytes());
            }
            file.extend_from_slice(bytes);
        }
        file
    }

    #[test]
    fn checksum_is_of_flash_from_the_second_word_on() {
        // The gap between the segments is zeros; they need not be in order.
        let file = elf(&[(16, b"data"), (0, b"\0\0\0\0text")]);
        assert_eq!(flash(&file).unwrap(), b"\0\0\0\0text\0\0\0\0\0\0\0\0data");
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("image");
        fs::write(&path, file).unwrap();
        let image = Image::open(&path).unwrap();
        assert_eq!(image.crc32, checksum(b"text\0\0\0\0\0\0\0\0data"));
    }

    #[test]
    fn damaged_files_are_no_images() {
        let good = elf(&[(0, b"\0\0\0\0text"), (8, b"data")]);
        for len in 0..good.len() {
            assert_eq!(flash(&good[..len]), None, "{len} bytes");
        }
        // For another machine: x86.
        let mut other = good.clone();
        other[18] = 3;
        assert_eq!(flash(&other), None);
        // As far apart as flash and memory are.
        assert_eq!(flash(&elf(&[(0, b"text"), (0x2000_0000, b"data")])), None);
    }

    /// A source tree with an image; returns tree and target folder.
    fn tree(folder: &Path) -> (PathBuf, PathBuf) {
        let (tree, target) = (folder.join("a tree"), folder.join("target"));
        let image = target.join(IN_TARGET);
        for path in ["firmware/src", "host/cli"] {
            fs::create_dir_all(tree.join(path)).unwrap();
        }
        fs::create_dir_all(image.parent().unwrap()).unwrap();
        fs::write(tree.join("Cargo.toml"), "[workspace]").unwrap();
        let manifest = "[package]\nname = \"armbridge-firmware\"\n";
        fs::write(tree.join("firmware/Cargo.toml"), manifest).unwrap();
        let source = tree.join("firmware/src/main.rs");
        fs::write(&source, "").unwrap();
        fs::write(&image, elf(&[(0, b"\0\0\0\0text")])).unwrap();
        let source = source.to_str().unwrap().replace(' ', "\\ ");
        let list = format!("{}: {source}\n", image.display());
        fs::write(image.with_extension("d"), list).unwrap();
        (tree, target)
    }

    #[test]
    fn tree_is_found_from_its_folders() {
        let folder = tempfile::tempdir().unwrap();
        let (tree, _) = tree(folder.path());
        for below in ["", "host/cli", "firmware"] {
            assert_eq!(tree_around(&tree.join(below)), Some(&*tree), "{below}");
        }
        assert_eq!(tree_around(folder.path()), None);
    }

    #[test]
    fn image_is_refused_once_a_source_is_newer_or_gone() {
        let folder = tempfile::tempdir().unwrap();
        let (tree, target) = tree(folder.path());
        let image = Image::of_tree(&tree, &target).unwrap();
        assert_eq!(image.crc32, checksum(b"text"));

        let source = tree.join("firmware/src/main.rs");
        let later = modified(&image.path).unwrap() + Duration::from_secs(1);
        let file = File::options().write(true).open(&source).unwrap();
        file.set_modified(later).unwrap();
        let error = Image::of_tree(&tree, &target).unwrap_err();
        let ImageError::Stale { source_file, .. } = &error else {
            panic!("{error}");
        };
        assert_eq!(source_file, Path::new("firmware/src/main.rs"));
        assert!(error.to_string().contains("cargo build-emulator"));

        fs::remove_file(&source).unwrap();
        let error = Image::of_tree(&tree, &target).unwrap_err();
        assert!(matches!(error, ImageError::Stale { .. }), "{error}");
    }

    #[test]
    fn image_of_another_tree_is_refused() {
        let folder = tempfile::tempdir().unwrap();
        let (_, target) = tree(folder.path());
        let other = folder.path().join("another tree");
        let error = Image::of_tree(&other, &target).unwrap_err();
        assert!(matches!(error, ImageError::OtherTree { .. }), "{error}");
        let nowhere = folder.path().join("nothing");
        let error = Image::of_tree(&other, &nowhere).unwrap_err();
        assert!(matches!(error, ImageError::NotBuilt(_)), "{error}");
    }
}
