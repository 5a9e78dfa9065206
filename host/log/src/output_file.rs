//! Output files of commands: written completely or not at all. An existing file is replaced
//! only on request.
//!
//! A file is written under a temporary name beside its own, and renamed when it is complete:
//! a full disk or ctrl-c leaves no partial file under its name. [`Existing`] has the rule for
//! a name that is taken.
//! `-` and `/dev/stdout` are standard output, and devices and pipes are written as they are. Logs of a run in
//! progress are made by [`create_log`] under their own name, and are never replaced.

use std::ffi::OsString;
use std::fs::File;
use std::io::{ErrorKind, Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU32, Ordering};
use std::{fs, io};

use armbridge_client::stdio::Stdout;

/// Rule for a file that exists.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Existing {
    /// An error that names it: for a place that the user chose.
    Refuse,
    /// Replaced, as the user requested.
    Replace,
    /// Kept, and the new one gets the next free name, as `angles-2.svg`; one with the same
    /// contents is not written again. For a name that the program chose.
    Number,
}

/// Name that stands for standard output.
pub const STDOUT: &str = "-";

/// Largest number in a name.
const NUMBER_MAX: u32 = 1000;

/// A file being written. Dropping it before [`finish`](Self::finish) leaves nothing.
#[derive(Debug)]
pub struct OutputFile {
    path: PathBuf,
    existing: Existing,
    target: Target,
    is_interrupted: fn() -> bool,
}

#[derive(Debug)]
enum Target {
    Stdout(Stdout),
    /// A device or a pipe.
    Device(File),
    /// Beside the path.
    Beside(Temporary),
}

/// A file that is removed when it is dropped.
#[derive(Debug)]
struct Temporary {
    path: PathBuf,
    file: File,
}

impl Drop for Temporary {
    fn drop(&mut self) {
        // A complete file has its own name by then; a partial one is not kept.
        let _ = fs::remove_file(&self.path);
    }
}

impl OutputFile {
    /// Begins a file that gets this path in the end.
    ///
    /// # Errors
    /// If it exists and must not be replaced, or cannot be created.
    pub fn create(path: &Path, existing: Existing) -> io::Result<Self> {
        let is_device = fs::metadata(path).is_ok_and(|it| !it.is_file() && !it.is_dir());
        let target = if is_stdout(path) {
            Target::Stdout(Stdout)
        } else if is_device {
            Target::Device(File::options().write(true).open(path)?)
        } else {
            check(path, existing)?;
            let path = beside(&resolved(path));
            let file = File::create_new(&path)?;
            Target::Beside(Temporary { path, file })
        };
        Ok(Self {
            path: path.into(),
            existing,
            target,
            is_interrupted: || false,
        })
    }

    /// The same file, which cannot be written any more once this holds: then nothing of it is
    /// left.
    #[must_use]
    pub fn interrupted_by(self, is_interrupted: fn() -> bool) -> Self {
        Self {
            is_interrupted,
            ..self
        }
    }

    /// The path that it was created for.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Gives the file its name; returns the path, which may have a number.
    ///
    /// # Errors
    /// If it cannot be written completely, or a file of this name has appeared.
    pub fn finish(mut self) -> io::Result<PathBuf> {
        self.flush()?;
        let Self {
            path,
            existing,
            target: Target::Beside(temporary),
            ..
        } = self
        else {
            return Ok(self.path);
        };
        // After a power cut, a name without its contents would be worse than none.
        temporary.file.sync_all()?;
        match existing {
            Existing::Refuse => link(&temporary.path, &path)?,
            Existing::Replace => replace(&temporary.path, &resolved(&path))?,
            Existing::Number => return numbered(&temporary.path, &path),
        }
        Ok(path)
    }
}

impl Write for OutputFile {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        if (self.is_interrupted)() {
            return Err(io::Error::other("interrupted"));
        }
        match &mut self.target {
            Target::Stdout(stdout) => stdout.write(bytes),
            Target::Device(file) | Target::Beside(Temporary { file, .. }) => file.write(bytes),
        }
    }

    fn flush(&mut self) -> io::Result<()> {
        if (self.is_interrupted)() {
            return Err(io::Error::other("interrupted"));
        }
        match &mut self.target {
            Target::Stdout(stdout) => stdout.flush(),
            Target::Device(file) | Target::Beside(Temporary { file, .. }) => file.flush(),
        }
    }
}

impl Seek for OutputFile {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        match &mut self.target {
            Target::Stdout(_) => Err(ErrorKind::NotSeekable.into()),
            Target::Device(file) | Target::Beside(Temporary { file, .. }) => file.seek(to),
        }
    }
}

/// Writes a whole file; returns its path, which may have a number.
///
/// # Errors
/// If it exists and must not be replaced, or cannot be written.
pub fn write(path: &Path, bytes: &[u8], existing: Existing) -> io::Result<PathBuf> {
    let mut file = OutputFile::create(path, existing)?;
    file.write_all(bytes)?;
    file.finish()
}

/// Whether a path is standard output: `-`, or a name that the system has for it. It may be
/// a file, which is continued and not replaced.
pub fn is_stdout(path: &Path) -> bool {
    let names = [STDOUT, "/dev/stdout", "/dev/fd/1", "/proc/self/fd/1"];
    names.iter().any(|name| path == Path::new(name))
}

/// Checks that a file may be written, before the work begins whose result it gets.
///
/// # Errors
/// If it exists and must not be replaced.
pub fn check(path: &Path, existing: Existing) -> io::Result<()> {
    if is_stdout(path) {
        return Ok(());
    }
    match fs::metadata(path) {
        Ok(found) if found.is_dir() => Err(is_folder()),
        Ok(found) if found.is_file() && existing == Existing::Refuse => Err(exists()),
        Ok(_) | Err(_) => Ok(()),
    }
}

/// Creates a log under its own name, so that what is written of it survives the program.
///
/// # Errors
/// If it exists, or cannot be created.
pub fn create_log(path: &Path) -> io::Result<File> {
    match File::create_new(path) {
        Err(error) if error.kind() == ErrorKind::AlreadyExists => {
            if fs::metadata(path).is_ok_and(|it| it.is_file()) {
                let why = "it exists, and a log is never replaced; name another file";
                return Err(io::Error::new(ErrorKind::AlreadyExists, why));
            }
            // A device or a pipe.
            File::options().write(true).open(path)
        }
        created => created,
    }
}

fn is_folder() -> io::Error {
    io::Error::new(ErrorKind::IsADirectory, "it is a folder; name a file")
}

fn exists() -> io::Error {
    io::Error::new(ErrorKind::AlreadyExists, "it exists; --force replaces it")
}

/// The file that a path leads to: not a link to it.
fn resolved(path: &Path) -> PathBuf {
    fs::canonicalize(path).unwrap_or_else(|_| path.to_path_buf())
}

/// A path beside this one that no other file being written has.
fn beside(path: &Path) -> PathBuf {
    static COUNT: AtomicU32 = AtomicU32::new(0);
    let count = COUNT.fetch_add(1, Ordering::Relaxed);
    let mut name = OsString::from(".");
    name.push(path.file_name().unwrap_or_default());
    name.push(format!(".{}-{count}.part", std::process::id()));
    path.with_file_name(name)
}

/// Gives a complete file the name and the mode of another, which it replaces.
fn replace(temporary: &Path, path: &Path) -> io::Result<()> {
    if let Ok(before) = fs::metadata(path) {
        fs::set_permissions(temporary, before.permissions())?;
    }
    fs::rename(temporary, path)
}

/// Gives a complete file its name, unless there is one of that name.
fn link(temporary: &Path, path: &Path) -> io::Result<()> {
    match fs::hard_link(temporary, path) {
        Err(error) if error.kind() == ErrorKind::AlreadyExists => Err(exists()),
        // Some file systems have no links; there nothing is atomic.
        Err(_) if !path.exists() => fs::rename(temporary, path),
        Err(_) => Err(exists()),
        Ok(()) => Ok(()),
    }
}

/// The same under the first free of `angles.svg`, `angles-2.svg` and so on, or under the first
/// that has the same contents.
fn numbered(temporary: &Path, path: &Path) -> io::Result<PathBuf> {
    let mut free = path.to_path_buf();
    for number in 2..=NUMBER_MAX {
        match link(temporary, &free) {
            Err(error) if error.kind() == ErrorKind::AlreadyExists => {
                if is_same(temporary, &free)? {
                    return Ok(free);
                }
                let mut name = path.file_stem().unwrap_or_default().to_owned();
                name.push(format!("-{number}"));
                if let Some(extension) = path.extension() {
                    name.push(".");
                    name.push(extension);
                }
                free = path.with_file_name(name);
            }
            Err(error) => return Err(error),
            Ok(()) => return Ok(free),
        }
    }
    Err(exists())
}

/// Whether two files have the same contents.
fn is_same(one: &Path, other: &Path) -> io::Result<bool> {
    if fs::metadata(one)?.len() != fs::metadata(other)?.len() {
        return Ok(false);
    }
    let open = |path| Ok::<_, io::Error>(io::BufReader::new(File::open(path)?).bytes());
    for (a, b) in open(one)?.zip(open(other)?) {
        if a? != b? {
            return Ok(false);
        }
    }
    Ok(true)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(folder: &Path) -> Vec<String> {
        let entries = fs::read_dir(folder).unwrap();
        let names = entries.map(|entry| entry.unwrap().file_name().into_string().unwrap());
        let mut names: Vec<String> = names.collect();
        names.sort();
        names
    }

    #[test]
    fn a_file_that_exists_is_kept_unless_it_is_to_be_replaced() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("gains.toml");
        assert_eq!(write(&path, b"one", Existing::Refuse).unwrap(), path);
        let error = write(&path, b"two", Existing::Refuse).unwrap_err();
        assert_eq!(error.to_string(), "it exists; --force replaces it");
        assert_eq!(fs::read(&path).unwrap(), b"one");
        assert_eq!(write(&path, b"three", Existing::Replace).unwrap(), path);
        assert_eq!(fs::read(&path).unwrap(), b"three");
        let error = create_log(&path).unwrap_err().to_string();
        assert!(error.contains("never replaced"), "{error}");
        assert_eq!(names(folder.path()), ["gains.toml"]);
    }

    #[test]
    fn a_name_of_the_program_gets_a_number_once_for_each_contents() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("angles.svg");
        let mut wrote = Vec::new();
        for bytes in [b"a", b"b", b"a", b"c", b"b"] {
            let path = write(&path, bytes, Existing::Number).unwrap();
            wrote.push(path.file_name().unwrap().to_str().unwrap().to_owned());
        }
        let [a, b, c] = ["angles.svg", "angles-2.svg", "angles-3.svg"];
        assert_eq!(wrote, [a, b, a, c, b]);
        assert_eq!(names(folder.path()), [b, c, a]);
    }

    #[test]
    fn half_a_file_is_none() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("page.html");
        fs::write(&path, "before").unwrap();
        let mut file = OutputFile::create(&path, Existing::Replace).unwrap();
        file.write_all(b"half").unwrap();
        assert_eq!(names(folder.path()).len(), 2);
        drop(file);
        assert_eq!(names(folder.path()), ["page.html"]);
        assert_eq!(fs::read(&path).unwrap(), b"before");
        // One that appeared meanwhile is kept.
        let path = folder.path().join("late.html");
        let file = OutputFile::create(&path, Existing::Refuse).unwrap();
        fs::write(&path, "other").unwrap();
        file.finish().unwrap_err();
        assert_eq!(fs::read(&path).unwrap(), b"other");
        assert_eq!(names(folder.path()), ["late.html", "page.html"]);
    }

    #[cfg(unix)]
    #[test]
    fn a_file_that_is_replaced_keeps_its_mode() {
        use std::os::unix::fs::PermissionsExt;

        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("gains.toml");
        fs::write(&path, "before").unwrap();
        fs::set_permissions(&path, fs::Permissions::from_mode(0o600)).unwrap();
        write(&path, b"after", Existing::Replace).unwrap();
        let mode = fs::metadata(&path).unwrap().permissions().mode();
        assert_eq!(mode & 0o777, 0o600);
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn a_device_is_written_and_a_full_one_is_an_error() {
        let null = Path::new("/dev/null");
        assert_eq!(write(null, b"x", Existing::Refuse).unwrap(), null);
        let error = write(Path::new("/dev/full"), b"x", Existing::Refuse).unwrap_err();
        assert_eq!(error.kind(), ErrorKind::StorageFull);
    }
}
