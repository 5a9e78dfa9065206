//! Finds the board's serial port among all others, by its USB identity.
//!
//! Linux lists terminals under `/sys/class/tty`; each leads to its USB interface,
//! and that to the device, where vendor, product and serial number are. On other systems
//! a port is not found: there `serial:` is the control link over pipes, and the transparent
//! port has to be named.

use std::fs;
use std::path::{Path, PathBuf};

use super::LinkUri;
use super::device_names::SERIAL_LINK;
use super::usb::{self, PRODUCT_ID, PRODUCT_NAME, VENDOR_CLASS, VENDOR_ID};
use crate::servo_bus::serial_device;

/// Directory in which Linux lists terminals.
pub(crate) const TERMINALS: &str = "/sys/class/tty";

/// Whether this system tells which serial ports are a board's.
pub(crate) const IS_SUPPORTED: bool = cfg!(target_os = "linux");

/// A board's serial port.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Found {
    /// Path, for example `/dev/ttyACM0`.
    pub terminal: PathBuf,
    /// The board's serial number, if it has one.
    pub serial: Option<String>,
    /// The board has pipes of its own for the control link; the serial port is its
    /// transparent one then.
    pub has_pipes: bool,
}

/// Reason for which the port is not known.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum FindError {
    /// There is none.
    #[error(
        "no serial port of a board is plugged in; check its cable and power, or name the port: \
         {SERIAL_LINK}"
    )]
    None,
    /// This system does not tell which ports are a board's.
    #[error(
        "name the board's serial port, as in {SERIAL_LINK}: on this system it is not found by \
         itself; there is {}", if .0.is_empty() { "none".into() } else { .0.join(", ") }
    )]
    NotNamed(Vec<String>),
    /// There are several.
    #[error("{} boards are plugged in; name one of {}", .0.len(), listed(.0))]
    Several(Vec<Found>),
}

fn listed(found: &[Found]) -> String {
    let names = found
        .iter()
        .map(|found| format!("serial://{}", found.terminal.display()));
    names.collect::<Vec<_>>().join(", ")
}

/// The port of the only board.
///
/// # Errors
/// If there is none, or more than one.
pub fn find() -> Result<Found, FindError> {
    if !IS_SUPPORTED {
        return Err(FindError::NotNamed(serial_device::names()));
    }
    find_under(Path::new(TERMINALS))
}

/// Links of all boards that are plugged in: where boards are not found by their serial
/// ports, those that USB lists.
pub fn links() -> Vec<LinkUri> {
    let found = all_under(Path::new(TERMINALS));
    let ports = found.into_iter().map(|found| match found.serial {
        Some(serial) if found.has_pipes => LinkUri::Usb(Some(serial)),
        _ => LinkUri::Serial(Some(found.terminal)),
    });
    let mut links: Vec<LinkUri> = ports.collect();
    for serial in usb::serials() {
        let link = LinkUri::Usb(serial);
        if !links.contains(&link) {
            links.push(link);
        }
    }
    links
}

fn all_under(terminals: &Path) -> Vec<Found> {
    let entries = fs::read_dir(terminals).into_iter().flatten().flatten();
    let mut found: Vec<Found> = entries
        .filter_map(|entry| identify(&entry.path()))
        .collect();
    found.sort_by(|a, b| a.terminal.cmp(&b.terminal));
    found
}

fn find_under(terminals: &Path) -> Result<Found, FindError> {
    let mut found = all_under(terminals);
    match found.pop() {
        None => Err(FindError::None),
        Some(only) if found.is_empty() => Ok(only),
        Some(last) => {
            found.push(last);
            Err(FindError::Several(found))
        }
    }
}

/// The board behind a terminal, if there is one.
fn identify(terminal: &Path) -> Option<Found> {
    let interface = terminal.join("device").canonicalize().ok()?;
    // A driver may insert a folder of its own.
    let device = interface
        .ancestors()
        .take(4)
        .find(|folder| folder.join("idVendor").exists())?;
    let is_ours = number(device, "idVendor") == Some(VENDOR_ID)
        && number(device, "idProduct") == Some(PRODUCT_ID)
        && text(device, "product").as_deref() == Some(PRODUCT_NAME);
    is_ours.then(|| Found {
        terminal: Path::new("/dev").join(terminal.file_name().unwrap_or_default()),
        serial: text(device, "serial"),
        has_pipes: has_pipes(device),
    })
}

fn has_pipes(device: &Path) -> bool {
    let interfaces = fs::read_dir(device).into_iter().flatten().flatten();
    interfaces
        .map(|entry| number(&entry.path(), "bInterfaceClass"))
        .any(|class| class == Some(u16::from(VENDOR_CLASS)))
}

fn text(folder: &Path, file: &str) -> Option<String> {
    let text = fs::read_to_string(folder.join(file)).ok()?;
    Some(text.trim().to_owned())
}

fn number(folder: &Path, file: &str) -> Option<u16> {
    u16::from_str_radix(&text(folder, file)?, 16).ok()
}

#[cfg(all(test, target_os = "linux"))]
mod tests {
    use super::*;
    use std::os::unix::fs::symlink;

    /// A tree like that of Linux.
    struct Tree(PathBuf);

    impl Tree {
        fn new(name: &str) -> Self {
            let root =
                std::env::temp_dir().join(format!("armbridge-{name}-{}", std::process::id()));
            let _ = fs::remove_dir_all(&root);
            fs::create_dir_all(root.join("tty")).unwrap();
            Self(root)
        }

        fn plug(&self, terminal: &str, ids: [&str; 3], serial: &str, classes: &[&str]) {
            let device = self.0.join("usb").join(terminal);
            for (number, class) in classes.iter().enumerate() {
                let interface = device.join(format!("1-1:1.{number}"));
                fs::create_dir_all(&interface).unwrap();
                fs::write(interface.join("bInterfaceClass"), format!("{class}\n")).unwrap();
            }
            for (file, value) in ["idVendor", "idProduct", "product"].iter().zip(ids) {
                fs::write(device.join(file), format!("{value}\n")).unwrap();
            }
            fs::write(device.join("serial"), format!("{serial}\n")).unwrap();
            let entry = self.0.join("tty").join(terminal);
            fs::create_dir_all(&entry).unwrap();
            symlink(device.join("1-1:1.0"), entry.join("device")).unwrap();
        }

        fn find(&self) -> Result<Found, FindError> {
            find_under(&self.0.join("tty"))
        }
    }

    impl Drop for Tree {
        fn drop(&mut self) {
            let _ = fs::remove_dir_all(&self.0);
        }
    }

    const OURS: [&str; 3] = ["1209", "0001", "Armbridge"];

    #[test]
    fn a_board_is_known_by_its_identity() {
        let tree = Tree::new("identity");
        fs::create_dir_all(tree.0.join("tty/console")).unwrap();
        tree.plug("ttyUSB0", ["0403", "6014", "USB2Dynamixel"], "X", &["ff"]);
        // The same numbers are used for experiments by others.
        tree.plug("ttyACM0", ["1209", "0001", "Blinky"], "Y", &["02", "0a"]);
        assert_eq!(tree.find(), Err(FindError::None));
        tree.plug("ttyACM1", OURS, "A1", &["02", "0a", "ff"]);
        let found = Found {
            terminal: "/dev/ttyACM1".into(),
            serial: Some("A1".into()),
            has_pipes: true,
        };
        assert_eq!(tree.find(), Ok(found));
        tree.plug("ttyACM2", OURS, "B2", &["02", "0a"]);
        let error = tree.find().unwrap_err().to_string();
        assert_eq!(
            error,
            "2 boards are plugged in; name one of serial:///dev/ttyACM1, serial:///dev/ttyACM2"
        );
    }
}
