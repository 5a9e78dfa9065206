//! Copies of the tracked files, as they are in the working tree.

use std::fs;
use std::path::Path;

use crate::output::printed;
use crate::paths;

/// Makes a copy in this folder, in place of another that may be there.
pub(crate) fn make(tree: &Path) -> Result<(), String> {
    let files = printed("git ls-files").ok_or("git cannot list the tracked files")?;
    let _ = fs::remove_dir_all(tree);
    for file in files.lines() {
        let (from, to) = (paths::root().join(file), tree.join(file));
        // A file that was deleted and not yet committed is not there.
        if from.is_file() {
            fs::create_dir_all(to.parent().unwrap_or(tree))
                .and_then(|()| fs::copy(&from, &to))
                .map_err(|e| format!("cannot copy {file}: {e}"))?;
        }
    }
    Ok(())
}
