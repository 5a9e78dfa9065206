//! Programs that build, emulate and flash the firmware, and its image.

use std::path::Path;
use std::process::Command;

use armbridge::finding::Finding;

/// Target of the firmware images.
const TARGET: &str = "thumbv7em-none-eabihf";

/// Machine that QEMU must know.
const MACHINE: &str = "mps2-an386";

/// Package managers, and the command of each that installs QEMU.
const PACKAGE_MANAGERS: [(&str, &str); 4] = [
    ("apt-get", "sudo apt-get install qemu-system-arm"),
    ("dnf", "sudo dnf install qemu-system-arm"),
    ("pacman", "sudo pacman -S qemu-system-arm"),
    ("brew", "brew install qemu"),
];

/// QEMU and the emulated board's machine.
pub(super) fn qemu() -> Finding {
    let Some(version) = printed("qemu-system-arm", &["--version"]) else {
        return Finding::missing("not installed", install_qemu());
    };
    let version = version.lines().next().unwrap_or_default();
    let version = version.trim_start_matches("QEMU emulator version ");
    let short = version.split(' ').next().unwrap_or_default();
    let machines = printed("qemu-system-arm", &["-machine", "help"]).unwrap_or_default();
    if machines.contains(MACHINE) {
        Finding::Ok(format!("version {short}, machine {MACHINE}"))
    } else {
        Finding::missing(
            format!("version {short} has no machine {MACHINE}"),
            "install version 2.11 or later",
        )
    }
}

fn install_qemu() -> &'static str {
    let path = std::env::var_os("PATH").unwrap_or_default();
    let is_there =
        |name: &str| std::env::split_paths(&path).any(|folder| folder.join(name).is_file());
    let found = PACKAGE_MANAGERS.iter().find(|(name, _)| is_there(name));
    found.map_or(
        "install `qemu-system-arm` by the system's package manager",
        |(_, command)| command,
    )
}

/// The image that `emulate:` runs.
#[cfg(unix)]
pub(super) fn image() -> Finding {
    use armbridge_sim::emulator::{Image, ImageError};

    const BUILD: &str = "cargo build-emulator";
    match Image::current() {
        Ok(image) => Finding::Ok(format!("current, CRC-32 {:08x}", image.crc32)),
        Err(ImageError::NoTree(_)) => Finding::missing(
            "no source tree of Armbridge here",
            "change to the source tree, or name an image: emulate:IMAGE",
        ),
        Err(ImageError::NotBuilt(_)) => Finding::missing("not built", BUILD),
        Err(ImageError::Stale { source_file, .. }) => Finding::Stale {
            what: format!("older than {}", source_file.display()),
            remedy: BUILD.into(),
        },
        Err(ImageError::OtherTree { .. }) => Finding::missing("built from another tree", BUILD),
        Err(error) => Finding::missing(error.to_string(), BUILD),
    }
}

/// The image that `emulate:` runs.
#[cfg(not(unix))]
pub(super) fn image() -> Finding {
    Finding::Open("`emulate:` needs Linux or macOS".into())
}

/// The compiler's target of the firmware.
pub(super) fn rust_target() -> Finding {
    let query = ["--print", "target-libdir", "--target", TARGET];
    match printed("rustc", &query) {
        None => Finding::missing("no Rust compiler", "install Rust: https://rustup.rs"),
        Some(folder) if Path::new(folder.trim()).is_dir() => Finding::Ok(TARGET.into()),
        Some(_) => Finding::missing(TARGET, format!("rustup target add {TARGET}")),
    }
}

/// The program that writes firmware to a board.
pub(super) fn probe_rs() -> Finding {
    match printed("probe-rs", &["--version"]) {
        Some(version) => Finding::Ok(version.lines().next().unwrap_or_default().to_owned()),
        None => Finding::missing("not installed", "cargo install --locked probe-rs-tools"),
    }
}

/// Standard output of a program, if it succeeds.
fn printed(program: &str, arguments: &[&str]) -> Option<String> {
    let output = Command::new(program).args(arguments).output().ok()?;
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    output.status.success().then_some(text)
}
