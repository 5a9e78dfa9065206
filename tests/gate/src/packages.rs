//! Programs of the system, installed by its package manager where missing.

use crate::output::{Output, printed, succeeds};

/// How to install packages with one package manager.
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

/// A program that a step needs.
pub(crate) struct Program {
    /// Its name, for messages.
    pub(crate) name: &'static str,
    /// Command that succeeds if it is present, and prints its version.
    pub(crate) check: String,
    /// Its packages for each of apt, dnf, pacman and brew.
    pub(crate) packages: [&'static str; MANAGERS.len()],
}

impl Program {
    /// Installs the program unless it is there.
    pub(crate) fn ensure(&self, out: &Output) -> Result<(), String> {
        if let Some(version) = printed(&self.check) {
            out.line(version.lines().next().unwrap_or_default());
            return Ok(());
        }
        let name = self.name;
        let mut managers = MANAGERS.iter().zip(self.packages);
        let found = managers.find(|(m, _)| succeeds(&format!("{} --version", m.program)));
        let Some((manager, packages)) = found else {
            return Err(format!(
                "{name} is missing; install it so that `{}` succeeds",
                self.check
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
        if succeeds(&self.check) {
            Ok(())
        } else {
            Err(format!("`{}` still fails", self.check))
        }
    }
}
