//! Path of a log: a file, the log in a run folder, or that of the latest run.

use std::fs;
use std::path::{Path, PathBuf};

use super::error::ReadError;

/// Name of the log in a run folder.
const LOG_NAME: &str = "run.mcap";

/// The log at `given`: the file itself, or the log in a
/// folder; without a path, the latest in the run folders of `base`, whose names
/// begin with the time.
///
/// # Errors
/// When there is no such log; the error has the searched path.
pub fn find(given: Option<&Path>, base: &Path) -> Result<PathBuf, ReadError> {
    let missing = |path: &Path, why: &str| ReadError {
        path: path.to_path_buf(),
        why: why.to_owned(),
    };
    let Some(path) = given else {
        return newest(base).ok_or_else(|| {
            missing(
                base,
                "no run folder with a log in it; name the log, or make one with `armbridge run`",
            )
        });
    };
    if path.is_dir() {
        let log = path.join(LOG_NAME);
        return if log.is_file() {
            Ok(log)
        } else {
            Err(missing(path, "this folder has no run.mcap in it"))
        };
    }
    if path.exists() {
        Ok(path.to_path_buf())
    } else {
        Err(missing(path, "there is no such file"))
    }
}

fn newest(base: &Path) -> Option<PathBuf> {
    let entries = fs::read_dir(base).ok()?;
    let logs = entries.filter_map(|entry| Some(entry.ok()?.path().join(LOG_NAME)));
    logs.filter(|log| log.is_file()).max()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_a_folder_or_the_newest() {
        let base = std::env::temp_dir().join(format!("armbridge-find-{}", std::process::id()));
        for run in ["2026-01-01T00-00-00Z-a", "2026-01-02T00-00-00Z-b"] {
            fs::create_dir_all(base.join(run)).unwrap();
            fs::write(base.join(run).join(LOG_NAME), "").unwrap();
        }
        // A run without a log does not count.
        fs::create_dir_all(base.join("2026-01-03T00-00-00Z-c")).unwrap();
        let [first, last] = ["2026-01-01T00-00-00Z-a", "2026-01-02T00-00-00Z-b"]
            .map(|run| base.join(run).join(LOG_NAME));
        assert_eq!(find(None, &base).unwrap(), last);
        assert_eq!(find(first.parent(), &base).unwrap(), first);
        assert_eq!(find(Some(&first), &base).unwrap(), first);
        for (given, word) in [
            (Some(base.join("2026-01-03T00-00-00Z-c")), "no run.mcap"),
            (Some(base.join("x")), "no such file"),
        ] {
            let error = find(given.as_deref(), &base).unwrap_err().to_string();
            assert!(error.contains(word), "{error}");
        }
        let error = find(None, &base.join("x")).unwrap_err().to_string();
        assert!(error.contains("armbridge run"), "{error}");
        fs::remove_dir_all(&base).unwrap();
    }
}
