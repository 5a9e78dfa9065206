//! The firmware image of a URI: a named file, or that of the source tree in which the program
//! is called, if it is up to date with the sources.
//!
//! The tree is looked for from a folder upwards, so that the program runs the firmware
//! beside which it is called, wherever the program itself was built. Its image is
//! compared with its sources as cargo compares them: by the times of the files, which
//! cargo lists in a `.d` file beside the image. A source that is newer than the image,
//! or missing, makes the image stale.
//!
//! An image is known by the checksum of its bytes in flash, see [`FlashImage`].

use std::path::{Path, PathBuf};
use std::time::SystemTime;
use std::{fmt, io};

use armbridge_client::flash_image::FlashImage;

/// Path of the emulator's image in cargo's target folder.
const IN_TARGET: &str = "thumbv7em-none-eabihf/firmware/mps2-an386";

/// Bytes that QEMU has where an ELF file loads none.
const QEMU_FILL: u8 = 0;

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
        let flash = FlashImage::of_elf(&elf, QEMU_FILL);
        let flash = flash.ok_or_else(|| ImageError::NotAnImage(path.into()))?;
        Ok(Self {
            path: path.into(),
            crc32: flash.crc32(),
        })
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

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs::{self, File};
    use std::time::Duration;

    /// An ELF file for ARM that loads its own first eight bytes.
    fn elf() -> Vec<u8> {
        let mut file = vec![0; 84];
        file[..6].copy_from_slice(b"\x7FELF\x01\x01");
        (file[18], file[28], file[42], file[44]) = (40, 52, 32, 1);
        (file[52], file[68]) = (1, 8);
        file
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
        fs::write(&image, elf()).unwrap();
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
        let flash = FlashImage::of_elf(&elf(), QEMU_FILL).unwrap();
        assert_eq!(image.crc32, flash.crc32());

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
