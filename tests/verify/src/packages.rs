//! Programs of the system, installed by its package manager where missing.

use crate::output::{Output, printed, succeeds};

/// Installation of packages with one package manager.
struct Manager {
    program: &'static str,
    /// Brings the list of packages up to date, where that is a step of its own.
    refresh: Option<&'static str>,
    install: &'static str,
    needs_root: bool,
}

const MANAGERS: [Manager; 4] = [
    Manager {
        program: "apt-get",
        refresh: Some("apt-get update"),
        install: "apt-get install --yes --no-install-recommends",
        needs_root: true,
    },
    Manager {
        program: "dnf",
        refresh: None,
        install: "dnf install --assumeyes",
        needs_root: true,
    },
    Manager {
        program: "pacman",
        refresh: None,
        install: "pacman --sync --needed --noconfirm",
        needs_root: true,
    },
    Manager {
        program: "brew",
        refresh: None,
        install: "brew install",
        needs_root: false,
    },
];

/// Installs the program `name` unless it is there: unless `check`, which prints its version,
/// succeeds. Its packages are those of apt, dnf, pacman and brew.
pub(crate) fn ensure(
    out: &Output,
    name: &str,
    check: &str,
    packages: [&str; MANAGERS.len()],
) -> Result<(), String> {
    if let Some(version) = printed(check) {
        out.line(version.lines().next().unwrap_or_default());
        return Ok(());
    }
    let mut managers = MANAGERS.iter().zip(packages);
    let found = managers.find(|(m, _)| succeeds(&format!("{} --version", m.program)));
    let Some((manager, packages)) = found else {
        return Err(format!(
            "{name} is missing; install it so that `{check}` succeeds"
        ));
    };
    let root = !manager.needs_root || printed("id -u").is_some_and(|id| id.trim() == "0");
    let prefix = if root { "" } else { "sudo " };
    let install = format!("{prefix}{} {packages}", manager.install);
    if !root && !succeeds("sudo --non-interactive true") {
        return Err(format!("{name} is missing; run: {install}"));
    }
    if let Some(refresh) = manager.refresh {
        // The source that cannot be reached may not be the one needed.
        if let Err(why) = out.command(&format!("{prefix}{refresh}")) {
            out.line(&format!("{why}; going on"));
        }
    }
    out.command(&install)
        .map_err(|why| format!("{why}; {name} is missing and has to be installed"))?;
    if succeeds(check) {
        Ok(())
    } else {
        Err(format!("`{check}` still fails"))
    }
}
