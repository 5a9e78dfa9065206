//! The files to download: built twice, from two folders, and compared bit for bit.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use crate::output::{Output, cargo};
use crate::{paths, setup, tree_copy};

/// Builds the files from the working tree, and returns their folder.
pub(crate) fn build(out: &Output) -> Result<PathBuf, String> {
    setup::mingw(out)?;
    let folder = paths::target().join("downloads");
    out.run(release().arg(&folder))?;
    Ok(folder)
}

/// Builds the files from the working tree and from a copy of it in another folder, with
/// nothing built before there, and compares their checksums. The DFU files must be such to
/// the program that flashes them.
pub(crate) fn reproducible(out: &Output) -> Result<(), String> {
    setup::dfu_util(out)?;
    let first = build(out)?;
    // Not in the first folder, the configuration of which cargo would add to the copy's.
    let copy = std::env::temp_dir().join("armbridge-second-release");
    let _ = fs::remove_dir_all(&copy);
    let tree = copy.join("another/folder");
    tree_copy::make(&tree)?;
    let second = copy.join("downloads");
    // The copy is no repository.
    let list = read(&first.join("images.json"))?;
    let commit = list.split("\"commit\": \"").nth(1);
    let commit = commit.and_then(|rest| rest.split('"').next());
    let mut build = release();
    build.arg(&second).arg("--sources").arg(&tree);
    out.run(build.env("ARMBRIDGE_COMMIT", commit.unwrap_or_default()))?;

    let [first_sums, second_sums] =
        [&first, &second].map(|folder| read(&folder.join("SHA256SUMS")));
    let (first_sums, second_sums) = (first_sums?, second_sums?);
    let mut differ = first_sums
        .lines()
        .filter(|line| !second_sums.contains(line));
    if let Some(line) = differ.next() {
        let name = line.split_whitespace().last().unwrap_or_default();
        return Err(format!(
            "{name} differs between {} and {}",
            first.display(),
            second.display()
        ));
    }
    let names = first_sums
        .lines()
        .filter_map(|line| line.split("  ").nth(1));
    for name in names.filter(|name| name.contains(".dfu")) {
        let file = first.join(name);
        out.command(&format!("dfu-suffix --check {}", file.display()))?;
    }
    fs::remove_dir_all(&copy).map_err(|e| format!("cannot remove {}: {e}", copy.display()))
}

/// `cargo release` up to the name of the folder to write to.
fn release() -> Command {
    cargo("run --quiet --package armbridge-release -- --out")
}

fn read(path: &Path) -> Result<String, String> {
    fs::read_to_string(path).map_err(|e| format!("cannot read {}: {e}", path.display()))
}
