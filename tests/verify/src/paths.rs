//! Folders: the workspace, and what cargo and the set-up put into its target folder.

use std::path::{Path, PathBuf};

/// The root of the workspace.
pub(crate) fn root() -> PathBuf {
    let here = Path::new(env!("CARGO_MANIFEST_DIR"));
    here.ancestors().nth(2).unwrap_or(here).to_owned()
}

/// Cargo's folder of what it builds, and of what the set-up installs.
pub(crate) fn target() -> PathBuf {
    let named = std::env::var_os("CARGO_TARGET_DIR");
    let folder = named.map_or_else(|| root().join("target"), PathBuf::from);
    std::path::absolute(&folder).unwrap_or(folder)
}

/// The virtual environment of the Python clients.
pub(crate) fn python_environment() -> PathBuf {
    target().join("python")
}
