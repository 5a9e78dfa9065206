//! Folder of a run's files: `runs/2026-11-21T10-55-00.250Z-demo/`.
//!
//! The name begins with the UTC time of creation in ms, so that names sort by time, with
//! dashes instead of colons, which some file systems reject. An existing folder is never
//! reused: a second one in the same millisecond gets `-2`, and so on.
//! [`log_path`](armbridge_log::log_path) finds the newest run by these names.

use std::fs;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};
use std::time::{Duration, SystemTime, UNIX_EPOCH};

/// Default folder for run folders.
pub const DEFAULT_BASE: &str = "runs";

/// Largest number of folders of the same millisecond.
const MAX_PER_MS: u32 = 1000;

/// Folder created for one run.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RunFolder {
    path: PathBuf,
}

/// The folder could not be created.
#[derive(Debug, thiserror::Error)]
#[error(
    "cannot create the run folder {path}: {source}; choose another place with --out",
    path = path.display()
)]
pub struct RunFolderError {
    /// Path of the folder.
    pub path: PathBuf,
    /// Error of the operating system.
    pub source: std::io::Error,
}

impl RunFolder {
    /// Creates a folder for a run with a name, in `base` or [`DEFAULT_BASE`].
    ///
    /// # Errors
    /// If the folder cannot be created; the error names it.
    pub fn create(base: Option<&Path>, name: &str) -> Result<Self, RunFolderError> {
        let base = base.unwrap_or(Path::new(DEFAULT_BASE));
        fs::create_dir_all(base).map_err(|source| RunFolderError {
            path: base.to_path_buf(),
            source,
        })?;
        let now = SystemTime::now()
            .duration_since(UNIX_EPOCH)
            .unwrap_or_default();
        Self::create_at(base, name, now)
    }

    fn create_at(base: &Path, name: &str, now: Duration) -> Result<Self, RunFolderError> {
        let stem = format!("{}-{name}", utc(now));
        let mut path = base.join(&stem);
        for next in 2.. {
            // `create_dir` fails on an existing folder, so two programs never share one.
            match fs::create_dir(&path) {
                Ok(()) => break,
                Err(e) if e.kind() == ErrorKind::AlreadyExists && next <= MAX_PER_MS => {
                    path = base.join(format!("{stem}-{next}"));
                }
                Err(source) => return Err(RunFolderError { path, source }),
            }
        }
        Ok(Self { path })
    }

    /// The folder.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Path of a file in the folder.
    pub fn file(&self, name: &str) -> PathBuf {
        self.path.join(name)
    }
}

/// UTC time as `2026-11-21T10-55-00.250Z`, from the time since 1970.
///
/// Civil calendar from a day number as in Howard Hinnant's
/// `civil_from_days`: years begin in March, so that leap days come last.
fn utc(now: Duration) -> String {
    let (now_s, ms) = (now.as_secs(), now.subsec_millis());
    let (days, second_of_day) = (now_s / 86_400, now_s % 86_400);
    let days = days + 719_468;
    let (era, day_of_era) = (days / 146_097, days % 146_097);
    let year_of_era =
        (day_of_era - day_of_era / 1460 + day_of_era / 36_524 - day_of_era / 146_096) / 365;
    let day_of_year = day_of_era - (365 * year_of_era + year_of_era / 4 - year_of_era / 100);
    let month_from_march = (5 * day_of_year + 2) / 153;
    let day = day_of_year - (153 * month_from_march + 2) / 5 + 1;
    let month = if month_from_march < 10 {
        month_from_march + 3
    } else {
        month_from_march - 9
    };
    let year = era * 400 + year_of_era + u64::from(month <= 2);
    let (hour, minute, second) = (
        second_of_day / 3600,
        second_of_day / 60 % 60,
        second_of_day % 60,
    );
    format!("{year:04}-{month:02}-{day:02}T{hour:02}-{minute:02}-{second:02}.{ms:03}Z")
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A folder of this test alone, removed again when it ends well.
    fn scratch(name: &str) -> PathBuf {
        let path = std::env::temp_dir().join(format!("armbridge-{name}-{}", std::process::id()));
        let _ = fs::remove_dir_all(&path);
        path
    }

    #[test]
    fn times_are_those_of_the_calendar() {
        // From `date --utc --date=@N`.
        for (seconds, time) in [
            (0, "1970-01-01T00-00-00"),
            (951_782_400, "2000-02-29T00-00-00"),
            (1_795_258_500, "2026-11-21T10-55-00"),
            (4_107_542_399, "2100-02-28T23-59-59"),
            (4_107_542_400, "2100-03-01T00-00-00"),
        ] {
            let now = Duration::from_secs(seconds) + Duration::from_millis(70);
            assert_eq!(utc(now), format!("{time}.070Z"));
        }
    }

    #[test]
    fn an_existing_folder_is_left_alone() {
        let base = scratch("existing");
        fs::create_dir_all(&base).unwrap();
        let names: Vec<_> = (0..3)
            .map(|_| {
                RunFolder::create_at(&base, "demo", Duration::ZERO)
                    .unwrap()
                    .path
            })
            .map(|path| path.file_name().unwrap().to_str().unwrap().to_owned())
            .collect();
        let stem = "1970-01-01T00-00-00.000Z-demo";
        assert_eq!(
            names,
            [stem.to_owned(), format!("{stem}-2"), format!("{stem}-3")]
        );
        fs::remove_dir_all(&base).unwrap();
    }

    #[test]
    fn a_place_that_is_no_folder_is_named() {
        let base = scratch("file");
        fs::write(&base, "in the way").unwrap();
        let text = RunFolder::create(Some(&base.join("x")), "demo")
            .unwrap_err()
            .to_string();
        assert!(
            text.contains("armbridge-file") && text.contains("--out"),
            "{text}"
        );
        fs::remove_file(&base).unwrap();
    }
}
