//! Builds with cargo that give equal bytes in any folder of one machine.
//!
//! | would differ | what makes it equal |
//! |---|---|
//! | paths of sources in panics and debug information | replaced: the project's, cargo's, the toolchain's |
//! | the commit that the program names | handed over: a build script that is not run again would keep an earlier one |
//! | names that a divided crate's parts give each other | crates are not divided |
//! | names of temporary files in a table of symbols | programs are stripped |
//! | order of imports in a program for Windows | its linker sees relative paths ([`System::linker`]) |
//! | dependencies | `--locked` |
//! | flags of the caller | not taken over |
//!
//! Toolchain, linker and, for Linux, the C library are those of the machine: another machine
//! gives equal bytes if it has the same.

use std::fs::{self, Permissions};
use std::os::unix::fs::PermissionsExt;
use std::path::{Path, PathBuf};
use std::process::Command;

use armbridge_verify::boards::BoardRow;
use armbridge_verify::{TARGET, image_arguments};

use crate::systems::System;

/// Where and from what to build.
pub(crate) struct Compiler {
    /// Root of the sources.
    root: PathBuf,
    /// Cargo's folder.
    target: PathBuf,
    /// Commit of the sources.
    pub(crate) commit: String,
    /// Path prefixes, and what they are replaced by. The last that fits counts.
    remapped: Vec<(PathBuf, &'static str)>,
}

impl Compiler {
    /// For these sources, or else those that this program was built from.
    ///
    /// # Errors
    /// If there are none, or the compiler cannot be asked where it is.
    pub(crate) fn new(sources: Option<&Path>) -> Result<Self, String> {
        let here = Path::new(env!("CARGO_MANIFEST_DIR"));
        let root = sources.or_else(|| here.ancestors().nth(2)).unwrap_or(here);
        let root = root
            .canonicalize()
            .map_err(|error| format!("no sources in {}: {error}", root.display()))?;
        let target = std::env::var_os("CARGO_TARGET_DIR").filter(|_| sources.is_none());
        let target = root.join(target.map_or_else(|| "target".into(), PathBuf::from));
        let sysroot = output("rustc", &["--print", "sysroot"], &root)?;
        let home = std::env::var_os("CARGO_HOME").map(PathBuf::from);
        let home = home.or_else(|| Some(std::env::home_dir()?.join(".cargo")));
        let home = home.ok_or("no home folder: set CARGO_HOME to cargo's")?;
        Ok(Self {
            commit: commit(&root),
            remapped: vec![
                (root.clone(), "/armbridge"),
                (target.clone(), "/armbridge/target"),
                (home, "/cargo"),
                (sysroot.into(), "/rust"),
            ],
            root,
            target,
        })
    }

    /// Folder for what is built, if no other is named.
    pub(crate) fn downloads(&self) -> PathBuf {
        self.target.join("downloads")
    }

    /// Folder for these builds alone: their flags differ from those of others.
    fn builds(&self) -> PathBuf {
        self.target.join("release-build")
    }

    /// Builds a board's image, and returns the path of its ELF file.
    pub(crate) fn image(&self, board: &BoardRow) -> Result<PathBuf, String> {
        run(&mut self.cargo(&image_arguments("build", board), TARGET, Vec::new()))?;
        let folder = self.builds().join(TARGET).join("firmware");
        Ok(folder.join(board.name))
    }

    /// Builds the host program with all its features, and returns its path.
    pub(crate) fn program(&self, system: &System) -> Result<PathBuf, String> {
        let build = format!(
            "build --release --package armbridge --features full --target {} \
             --config profile.release.codegen-units=1",
            system.target
        );
        // Not by the profile: it has no effect on a package with a level of its own.
        let mut flags = vec!["-Cstrip=symbols".to_owned()];
        flags.extend(system.flags.iter().map(ToString::to_string));
        if let Some(linker) = system.linker {
            let linker = self.relative_linker(linker)?;
            flags.push(format!("-Clinker={}", linker.display()));
            flags.push("-Clinker-flavor=gcc".to_owned());
        }
        run(&mut self.cargo(&build, system.target, flags))?;
        let name = format!("armbridge{}", system.extension);
        Ok(self.builds().join(system.target).join("release").join(name))
    }

    /// Writes a program that calls a linker in the folder of builds, with paths relative to it,
    /// and returns its path.
    fn relative_linker(&self, linker: &str) -> Result<PathBuf, String> {
        let folder = self.builds();
        let path = folder.join("relative-linker");
        let script = format!(
            "#!/bin/sh\n\
             cd '{0}' || exit 1\n\
             for argument do\n\
             \x20 shift\n\
             \x20 set -- \"$@\" \"${{argument#'{0}'/}}\"\n\
             done\n\
             exec {linker} \"$@\"\n",
            folder.display()
        );
        fs::create_dir_all(&folder)
            .and_then(|()| fs::write(&path, script))
            .and_then(|()| fs::set_permissions(&path, Permissions::from_mode(0o755)))
            .map_err(|error| format!("cannot write {}: {error}", path.display()))?;
        Ok(path)
    }

    /// Cargo with these arguments, for this target, with these flags of the compiler.
    fn cargo(&self, arguments: &str, target: &str, flags: Vec<String>) -> Command {
        let remap = self.remapped.iter().map(|(from, to)| {
            let from = from.display();
            format!("--remap-path-prefix={from}={to}")
        });
        let flags: Vec<String> = remap.chain(flags).collect();
        // An array of quoted words, in TOML as in Rust; appended to the project's own flags.
        let flags = format!("target.{target}.rustflags={flags:?}");
        let cargo = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
        let mut cargo = Command::new(cargo);
        cargo
            .args(arguments.split_whitespace())
            .args(["--locked", "--config", &flags])
            .arg("--target-dir")
            .arg(self.builds())
            .current_dir(&self.root)
            .env("ARMBRIDGE_COMMIT", &self.commit)
            .env("CARGO_INCREMENTAL", "0")
            .env_remove("RUSTFLAGS")
            .env_remove("CARGO_ENCODED_RUSTFLAGS");
        cargo
    }
}

/// `ARMBRIDGE_COMMIT`, for sources without a repository; else git's, with `-dirty` behind it
/// if a tracked file differs; else `unknown`.
fn commit(root: &Path) -> String {
    if let Ok(commit) = std::env::var("ARMBRIDGE_COMMIT") {
        return commit;
    }
    let git = |arguments: &[&str]| output("git", arguments, root).ok();
    let changes = git(&["status", "--porcelain", "--untracked-files=no"]);
    match (git(&["rev-parse", "HEAD"]), changes.as_deref()) {
        (Some(hash), Some("")) => hash,
        (Some(hash), _) => hash + "-dirty",
        (None, _) => "unknown".into(),
    }
}

/// Standard output of a command, trimmed.
fn output(program: &str, arguments: &[&str], folder: &Path) -> Result<String, String> {
    let output = Command::new(program)
        .args(arguments)
        .current_dir(folder)
        .output()
        .map_err(|error| format!("cannot start {program}: {error}"))?;
    if !output.status.success() {
        return Err(format!(
            "{program} {}: {}",
            arguments.join(" "),
            output.status
        ));
    }
    Ok(String::from_utf8_lossy(&output.stdout).trim().to_owned())
}

fn run(command: &mut Command) -> Result<(), String> {
    match command.status() {
        Ok(status) if status.success() => Ok(()),
        Ok(status) => Err(format!(
            "cargo build: {status}; `cargo verify --only rust` installs missing targets, and a \
             program for Windows needs the linker of MinGW-w64 (gcc-mingw-w64-x86-64)"
        )),
        Err(error) => Err(format!("cannot start cargo: {error}")),
    }
}
