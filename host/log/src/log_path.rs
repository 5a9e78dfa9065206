//! Path of a log: a file, the log in a run folder, or that of the newest run.
//!
//! The newest run is the one with the latest time in its folder's name, as
//! `2026-11-21T10-55-00.250Z-demo`; of several with the same time, as names without
//! milliseconds may have, the one with the highest number. A folder without a time in its
//! name is older than any other.

use std::cmp::Ordering;
use std::fs;
use std::path::{Path, PathBuf};

use super::error::ReadError;

/// Name of the log in a run folder.
const LOG_NAME: &str = "run.mcap";

/// The log at `given`: the file itself, or the log in a folder; without a path, that of the
/// newest run in `base`.
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

/// The log of the newest run that has one.
fn newest(base: &Path) -> Option<PathBuf> {
    let names = fs::read_dir(base).ok()?;
    let names = names.filter_map(|entry| entry.ok()?.file_name().into_string().ok());
    let with_log = names.filter(|name| base.join(name).join(LOG_NAME).is_file());
    let name = with_log.max_by(|a, b| by_age(a, b))?;
    Some(base.join(name).join(LOG_NAME))
}

/// Order of the names of run folders from old to new.
pub fn by_age(one: &str, other: &str) -> Ordering {
    let split = |name: &str| {
        let (time, rest) = split_time(name);
        (time.map(str::to_owned), rest.to_owned())
    };
    let ((time, rest), (other_time, other_rest)) = (split(one), split(other));
    let by_time = time.cmp(&other_time);
    by_time.then_with(|| by_number(&rest, &other_rest))
}

/// The time at the beginning of a name up to its `Z`, and the rest. A name without
/// milliseconds has those of its whole second.
fn split_time(name: &str) -> (Option<&str>, &str) {
    const SHAPE: &[u8] = b"0000-00-00T00-00-00";
    let is_time = |time: &str| {
        let (second, fraction) = time.split_at_checked(SHAPE.len()).unwrap_or(("", time));
        let fits = |(byte, shape): (u8, &u8)| match shape {
            b'0' => byte.is_ascii_digit(),
            mark => byte == *mark,
        };
        let digits = fraction.strip_prefix('.').unwrap_or(fraction);
        second.len() == SHAPE.len()
            && second.bytes().zip(SHAPE).all(fits)
            && digits.bytes().all(|byte| byte.is_ascii_digit())
    };
    match name.split_once('Z') {
        Some((time, rest)) if is_time(time) => (Some(time), rest),
        _ => (None, name),
    }
}

/// Order of names in which runs of digits count as numbers: `demo-9` before `demo-12`.
fn by_number(one: &str, other: &str) -> Ordering {
    let (mut one, mut other) = (one, other);
    loop {
        let ((digits, rest), (other_digits, other_rest)) = (number(one), number(other));
        // Without leading zeros, the longer number is the larger one.
        let (a, b) = (
            digits.trim_start_matches('0'),
            other_digits.trim_start_matches('0'),
        );
        let order = a.len().cmp(&b.len()).then_with(|| a.cmp(b));
        if order.is_ne() && !digits.is_empty() && !other_digits.is_empty() {
            return order;
        }
        let (mut letters, mut other_letters) = (rest.chars(), other_rest.chars());
        match (letters.next(), other_letters.next()) {
            (None, None) => return one.cmp(other),
            (a, b) if a == b => (one, other) = (letters.as_str(), other_letters.as_str()),
            (a, b) => return a.cmp(&b),
        }
    }
}

/// Digits at the beginning, and the rest.
fn number(text: &str) -> (&str, &str) {
    let end = text.find(|letter: char| !letter.is_ascii_digit());
    text.split_at(end.unwrap_or(text.len()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_newest_name_is_the_latest_and_not_the_last_of_the_alphabet() {
        let old_to_new = [
            "favourite",
            "2026-01-01T00-00-00Z-zero",
            "2026-01-02T00-00-00Z-demo",
            "2026-01-02T00-00-00Z-demo-2",
            "2026-01-02T00-00-00Z-demo-9",
            "2026-01-02T00-00-00Z-demo-12",
            "2026-01-02T00-00-00Z-demo-100",
            "2026-01-02T00-00-00.007Z-zero",
            "2026-01-02T00-00-00.080Z-demo",
            "2026-01-02T00-00-01Z-arm",
        ];
        for (index, one) in old_to_new.iter().enumerate() {
            for (other_index, other) in old_to_new.iter().enumerate() {
                let order = index.cmp(&other_index);
                assert_eq!(by_age(one, other), order, "{one} and {other}");
            }
        }
    }

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
