//! The folder of a release: its files, their checksums, and the list of its images.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

use armbridge_client::flash_image::{ERASED, FlashImage};
use armbridge_client::image_list::{FILE_NAME, ImageList, ListedImage};
use sha2::{Digest, Sha256};

use crate::dfu;

/// Name of the file with all checksums, as `sha256sum --check` reads it.
const SUMS: &str = "SHA256SUMS";

/// A folder that is being filled.
pub(crate) struct Folder {
    path: PathBuf,
    list: ImageList,
    /// SHA-256 of each file.
    sums: BTreeMap<String, String>,
}

impl Folder {
    /// Makes the folder, or takes one; other files in it stay.
    pub(crate) fn new(path: &Path, commit: &str) -> Result<Self, String> {
        let failed = |error| format!("cannot make the folder {}: {error}", path.display());
        fs::create_dir_all(path).map_err(failed)?;
        Ok(Self {
            path: path.into(),
            list: ImageList {
                version: env!("CARGO_PKG_VERSION").into(),
                commit: commit.into(),
                images: Vec::new(),
            },
            sums: BTreeMap::new(),
        })
    }

    /// Adds the image in an ELF file, in all its forms.
    pub(crate) fn add_image(&mut self, board: &str, elf: &Path) -> Result<(), String> {
        let elf_bytes = read(elf)?;
        // As a debug probe leaves it that programs the ELF file: one checksum for all forms.
        let image = FlashImage::of_elf(&elf_bytes, ERASED)
            .ok_or_else(|| format!("{} is no ELF file for ARM", elf.display()))?;
        let name = format!("armbridge-{board}");
        self.write(&format!("{name}.elf"), &elf_bytes)?;
        self.write(&format!("{name}.dfu"), &dfu::file(&image, board))?;
        let sha256 = self.write(&format!("{name}.bin"), &image.bytes)?;
        self.list.images.push(ListedImage {
            board: board.into(),
            image_crc32: format!("{:08x}", image.crc32()),
            sha256,
        });
        Ok(())
    }

    /// Adds a program.
    pub(crate) fn add_program(&mut self, name: &str, program: &Path) -> Result<(), String> {
        self.write(name, &read(program)?)?;
        let file = self.path.join(name);
        // With the permission to execute it, which Windows does not know.
        let permissions = fs::metadata(program).map(|metadata| metadata.permissions());
        permissions
            .and_then(|permissions| fs::set_permissions(&file, permissions))
            .map_err(|error| format!("cannot make {} executable: {error}", file.display()))
    }

    /// Writes the list of images and the checksums of all files.
    pub(crate) fn finish(mut self) -> Result<(), String> {
        let list = serde_json::to_string_pretty(&self.list).map_err(|error| error.to_string())?;
        self.write(FILE_NAME, (list + "\n").as_bytes())?;
        let lines = self.sums.iter();
        let lines: Vec<String> = lines
            .map(|(name, sum)| format!("{sum}  {name}\n"))
            .collect();
        let lines = lines.concat();
        self.write(SUMS, lines.as_bytes())?;
        print!("{lines}");
        Ok(())
    }

    /// Writes a file; returns its SHA-256.
    fn write(&mut self, name: &str, bytes: &[u8]) -> Result<String, String> {
        let path = self.path.join(name);
        fs::write(&path, bytes)
            .map_err(|error| format!("cannot write {}: {error}", path.display()))?;
        let digest = Sha256::digest(bytes);
        let digits: Vec<String> = digest.iter().map(|byte| format!("{byte:02x}")).collect();
        let sum = digits.concat();
        self.sums.insert(name.into(), sum.clone());
        Ok(sum)
    }
}

fn read(path: &Path) -> Result<Vec<u8>, String> {
    fs::read(path).map_err(|error| format!("cannot read {}: {error}", path.display()))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// An ELF file for ARM that loads its own first bytes.
    fn elf() -> Vec<u8> {
        let mut file = vec![0_u8; 84];
        file[..6].copy_from_slice(b"\x7FELF\x01\x01");
        (file[18], file[28], file[42], file[44]) = (40, 52, 32, 1);
        (file[52], file[68]) = (1, 8);
        file
    }

    #[test]
    fn files_have_their_checksums_and_the_list_names_the_image() {
        let temporary = tempfile::tempdir().unwrap();
        let built = temporary.path().join("built");
        let out = temporary.path().join("new/folder");
        let mut folder = Folder::new(&out, "abc").unwrap();
        fs::write(&built, elf()).unwrap();
        folder.add_image("board", &built).unwrap();
        fs::write(&built, "abc").unwrap();
        folder.add_program("armbridge-system", &built).unwrap();
        folder.finish().unwrap();

        let image = FlashImage::of_elf(&elf(), ERASED).unwrap();
        assert_eq!(
            fs::read(out.join("armbridge-board.bin")).unwrap(),
            image.bytes
        );
        let list = ImageList::open(&out.join(FILE_NAME)).unwrap();
        let listed = list.find(image.crc32()).unwrap();
        assert_eq!((&*listed.board, &*list.commit), ("board", "abc"));

        let sums = fs::read_to_string(out.join(SUMS)).unwrap();
        let bin = format!("{}  armbridge-board.bin\n", listed.sha256);
        assert!(sums.contains(&bin), "{sums}");
        // FIPS 180-4's example.
        let abc = "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad";
        assert!(
            sums.contains(&format!("{abc}  armbridge-system\n")),
            "{sums}"
        );
        assert_eq!(sums.lines().count(), 5, "{sums}");
    }

    #[test]
    fn a_file_that_is_no_image_is_named() {
        let temporary = tempfile::tempdir().unwrap();
        let mut folder = Folder::new(temporary.path(), "abc").unwrap();
        let path = temporary.path().join("text");
        fs::write(&path, "text").unwrap();
        let error = folder.add_image("board", &path).unwrap_err();
        assert!(error.contains("text is no ELF file for ARM"), "{error}");
    }
}
