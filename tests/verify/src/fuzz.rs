//! Builds the fuzz targets of `tests/fuzz` and runs each for a given time.
//!
//! Neither cargo-fuzz nor a nightly toolchain is needed: the stable toolchain inserts
//! libFuzzer's counters too (`tests/fuzz/.cargo/config.toml`), and only a C++ compiler
//! has to be installed. libFuzzer's output goes to `target/fuzz/TARGET.log`; inputs with
//! new coverage are kept in `target/fuzz/corpus`, and failing inputs beside the log.

use std::fs::{self, File};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};

use crate::output::{Output, cargo, printed};
use crate::paths;

/// Time for which each target runs in the gate, in s.
const SHORT_S: u32 = 5;
/// Time for which each target runs in the campaign, in s.
const LONG_S: u32 = 600;
/// Targets that run at the same time: processors of the smallest machine.
const AT_ONCE: usize = 2;

/// Builds all targets and runs each for [`SHORT_S`].
pub(crate) fn short(out: &Output) -> Result<(), String> {
    run(out, SHORT_S, 1)
}

/// Builds all targets and runs each for [`LONG_S`].
pub(crate) fn long(out: &Output) -> Result<(), String> {
    run(out, LONG_S, 3)
}

/// Level 3 takes longer to build than level 1, and then tries more inputs.
fn run(out: &Output, duration_s: u32, opt_level: u8) -> Result<(), String> {
    let project = paths::root().join("tests/fuzz");
    let host = printed("rustc --print host-tuple").ok_or("cannot ask rustc for its host")?;
    let target = paths::target().join("fuzz");
    build(out, &project, host.trim(), &target, opt_level)?;
    let binaries = target.join(host.trim()).join("release");
    for names in names(&project)?.chunks(AT_ONCE) {
        // All are started before one is waited for.
        let start = |name: &String| Running::start(name, &binaries, &project, &target, duration_s);
        let running: Vec<_> = names.iter().map(start).collect::<Result<_, _>>()?;
        running.into_iter().try_for_each(|it| it.finish(out))?;
    }
    Ok(())
}

fn build(
    out: &Output,
    project: &Path,
    host: &str,
    target: &Path,
    opt_level: u8,
) -> Result<(), String> {
    let mut build = cargo("build --release --manifest-path tests/fuzz/Cargo.toml");
    build
        // Its own flags: cargo looks for them from where it runs.
        .arg("--config")
        .arg(project.join(".cargo/config.toml"))
        .args(["--target", host, "--target-dir"])
        .arg(target)
        .env("CARGO_PROFILE_RELEASE_OPT_LEVEL", opt_level.to_string())
        // They would take the place of the project's own.
        .env_remove("RUSTFLAGS")
        .env_remove("CARGO_ENCODED_RUSTFLAGS");
    out.run(&mut build)
}

/// Names of the targets: a file each.
fn names(project: &Path) -> Result<Vec<String>, String> {
    let files = fs::read_dir(project.join("fuzz_targets"))
        .map_err(|e| format!("cannot list the fuzz targets: {e}"))?;
    let mut names: Vec<String> = files
        .filter_map(|file| Some(file.ok()?.path().file_stem()?.to_str()?.to_owned()))
        .collect();
    names.sort();
    Ok(names)
}

/// A target that runs.
struct Running {
    name: String,
    binary: PathBuf,
    log: PathBuf,
    child: Child,
}

impl Running {
    fn start(
        name: &str,
        binaries: &Path,
        project: &Path,
        target: &Path,
        duration_s: u32,
    ) -> Result<Self, String> {
        let binary = binaries.join(name);
        let log = target.join(format!("{name}.log"));
        let corpus = target.join("corpus").join(name);
        let artifacts = target.join(format!("{name}-"));
        let log_file = fs::create_dir_all(&corpus)
            .and_then(|()| File::create(&log))
            .map_err(|e| format!("cannot write to {}: {e}", target.display()))?;
        let child = Command::new(&binary)
            .arg(format!("-max_total_time={duration_s}"))
            // A single input that takes longer hangs.
            .arg("-timeout=10")
            .arg(format!("-artifact_prefix={}", artifacts.display()))
            .args([corpus, project.join("seeds").join(name)])
            .stdin(Stdio::null())
            .stdout(Stdio::null())
            .stderr(log_file)
            .spawn()
            .map_err(|e| format!("cannot start {}: {e}", binary.display()))?;
        Ok(Self {
            name: name.to_owned(),
            binary,
            log,
            child,
        })
    }

    /// Waits for its end.
    fn finish(mut self, out: &Output) -> Result<(), String> {
        let status = self.child.wait();
        let Self { name, log, .. } = &self;
        let status = status.map_err(|e| format!("{name}: {e}"))?;
        let text = fs::read(log).map_err(|e| format!("{}: {e}", log.display()))?;
        let text = String::from_utf8_lossy(&text);
        let done = text.lines().rfind(|line| line.starts_with("Done "));
        if let (true, Some(done)) = (status.success(), done) {
            out.line(&format!("    {name:<12}{done}"));
            return Ok(());
        }
        let input = text
            .lines()
            .find_map(|line| line.split_once("Test unit written to "))
            .map_or("INPUT", |(_, path)| path);
        let why = text.lines().find(|line| line.contains("panicked at"));
        Err(format!(
            "fuzz target `{name}`: {}; see {}\n  one input again:   {} {input}",
            why.unwrap_or("it failed"),
            log.display(),
            self.binary.display(),
        ))
    }
}

impl Drop for Running {
    /// Another target has failed: this one is not needed any more.
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}
