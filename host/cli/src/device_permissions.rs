//! Permissions for serial ports and USB devices.

use crate::finding::Finding;

/// Serial ports that the user may read and write.
#[cfg(unix)]
pub fn serial_ports() -> Finding {
    use std::os::unix::fs::MetadataExt;
    use std::path::PathBuf;

    use rustix::fs::{Access, access};

    /// Beginnings of the names of USB serial ports on Linux and macOS.
    const NAMES: [&str; 3] = ["ttyACM", "ttyUSB", "cu.usb"];

    let entries = std::fs::read_dir("/dev").into_iter().flatten().flatten();
    let paths = entries.map(|entry| entry.path());
    let is_port = |path: &PathBuf| {
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        NAMES.iter().any(|begin| name.starts_with(begin))
    };
    let mut ports: Vec<PathBuf> = paths.filter(is_port).collect();
    ports.sort();
    if ports.is_empty() {
        return Finding::Open("none is plugged in".into());
    }
    let is_closed =
        |path: &&PathBuf| access(path.as_path(), Access::READ_OK | Access::WRITE_OK).is_err();
    if let Some(closed) = ports.iter().find(is_closed) {
        let group = std::fs::metadata(closed).map(|metadata| metadata.gid());
        let group = group.ok().and_then(group_name);
        return Finding::missing(
            format!("no permission for {}", closed.display()),
            format!(
                "sudo usermod -aG {} $USER; then log in again",
                group.as_deref().unwrap_or("dialout")
            ),
        );
    }
    let names: Vec<String> = ports
        .iter()
        .map(|path| path.display().to_string())
        .collect();
    Finding::Ok(names.join(", "))
}

/// Name of a group.
#[cfg(unix)]
fn group_name(id: u32) -> Option<String> {
    let groups = std::fs::read_to_string("/etc/group").ok()?;
    let id = id.to_string();
    let line = groups
        .lines()
        .find(|line| line.split(':').nth(2) == Some(&*id))?;
    line.split(':').next().map(str::to_owned)
}

/// Serial ports, for which this system needs no permission.
#[cfg(not(unix))]
pub fn serial_ports() -> Finding {
    let names = armbridge_client::servo_bus::serial_device::names();
    if names.is_empty() {
        return Finding::Open("none is plugged in".into());
    }
    Finding::Ok(names.join(", "))
}

/// Whether udev lets the user open a board.
#[cfg(target_os = "linux")]
pub fn usb_permission() -> Finding {
    use armbridge_client::transport::usb::{PRODUCT_ID, UDEV_RULE, UDEV_RULE_FILE, VENDOR_ID};

    if rustix::process::geteuid().is_root() {
        return Finding::Ok("root may open every device".into());
    }
    let folders = [
        "/etc/udev/rules.d",
        "/run/udev/rules.d",
        "/usr/lib/udev/rules.d",
        "/lib/udev/rules.d",
    ];
    let entries = folders
        .iter()
        .flat_map(std::fs::read_dir)
        .flatten()
        .flatten();
    let ids = [VENDOR_ID, PRODUCT_ID].map(|id| format!("{id:04x}"));
    let is_ours = |text: &String| {
        text.lines()
            .any(|line| !line.starts_with('#') && ids.iter().all(|id| line.contains(id)))
    };
    let mut rules = entries.filter_map(|entry| {
        let text = std::fs::read_to_string(entry.path()).ok();
        text.filter(is_ours)
            .map(|_| entry.path().display().to_string())
    });
    match rules.next() {
        Some(path) => Finding::Ok(path),
        None => Finding::missing(
            "no udev rule for the board",
            format!(
                "echo '{UDEV_RULE}' |\n\
                 sudo tee {UDEV_RULE_FILE}; sudo udevadm control --reload"
            ),
        ),
    }
}

/// Whether the user may open a board.
#[cfg(not(target_os = "linux"))]
pub fn usb_permission() -> Finding {
    Finding::Open(
        if cfg!(windows) {
            "no permission is needed; Windows gives the board its driver, WinUSB, by itself"
        } else {
            "this system needs no permission"
        }
        .into(),
    )
}
