//! Control link of a board on USB: two bulk pipes of a vendor-specific
//! interface.
//!
//! The board's serial port is its transparent one; see the firmware's
//! `board::stm32::usb`. Pure Rust, without libusb: on Linux through usbfs, on
//! Windows through `WinUSB`, on macOS through `IOKit`. The choice of a board and the errors
//! are tested; the pipes themselves have not been run on hardware.

use std::io::{self, Write};
use std::time::{Duration, Instant};

use armbridge_link::frame;
use nusb::io::{EndpointRead, EndpointWrite};
use nusb::transfer::{Bulk, Direction, In, Out};
use nusb::{DeviceInfo, ErrorKind, Interface, MaybeFuture};

use crate::servo_bus::Line;
use crate::servo_bus::line::read_chunk;

/// Vendor: pid.codes.
pub const VENDOR_ID: u16 = 0x1209;
/// Product: its number for tests, which others use too.
pub const PRODUCT_ID: u16 = 0x0001;
/// Vendor and product of the ROM loader of the board's chip (ST's AN3156), which has no
/// string of ours.
const ROM_LOADER: (u16, u16) = (0x0483, 0xDF11);
/// Rule by which udev lets every user open a board.
pub const UDEV_RULE: &str = r#"ATTR{idVendor}=="1209", ATTR{idProduct}=="0001", MODE="0666""#;
/// File for the rule.
pub const UDEV_RULE_FILE: &str = "/etc/udev/rules.d/70-armbridge.rules";
/// Where the system shows a board that is plugged in.
const SHOWN: &str = if cfg!(windows) {
    "the Device Manager must show Armbridge"
} else if cfg!(target_os = "macos") {
    "`ioreg -p IOUSB` must show Armbridge"
} else {
    "`lsusb` must show 1209:0001"
};
/// Product name, which distinguishes our boards from those.
pub(crate) const PRODUCT_NAME: &str = "Armbridge";
/// Class of the interface with the pipes.
pub(crate) const VENDOR_CLASS: u8 = 0xFF;

/// Size of a transfer's buffer: a page, the smallest that Linux allocates, and more than
/// any frame.
const TRANSFER: usize = 4_096;
const _: () = assert!(TRANSFER >= frame::MAX);
/// Transfers that are kept open; they take 256 KiB, of 16 MiB that Linux has for USB.
///
/// A transfer ends with a packet that is not full, and the board ends each frame with
/// one: a transfer holds one frame, however large its buffer. While the host does not
/// read, all transfers but the one that it read last are filled, then the board's own
/// queue of 15 records and the frame that it has taken out. At 1 kHz that is
/// 63 + 15 + 1 ms: records are dropped when the host stalls for more than 79 ms. Each
/// other message takes the place of a record.
const TRANSFERS: usize = 64;
/// Longest time for which the board may accept no bytes.
const STUCK: Duration = Duration::from_secs(1);

/// Reason for which there is no link to a board.
#[derive(Debug, thiserror::Error)]
pub enum UsbError {
    /// USB devices cannot be listed.
    #[error("USB devices cannot be listed: {0}; is there USB here? Inside a container, often not")]
    List(#[source] io::Error),
    /// No board.
    #[error("no board is plugged in: check its USB cable and power; {SHOWN}")]
    NoBoard,
    /// The chip waits for a program.
    #[error(
        "a chip in its ROM loader is plugged in, and no board: it waits for its firmware, by \
         `dfu-util`, or B0 is still wired to 3.3 V"
    )]
    RomLoader,
    /// No board with this serial number.
    #[error("no board has the serial number {wanted}; there is {}", .there.join(", "))]
    OtherSerial {
        /// Requested serial number.
        wanted: String,
        /// URIs of the boards that are plugged in.
        there: Vec<String>,
    },
    /// More than one board.
    #[error("{} boards are plugged in; name one of {}", .0.len(), .0.join(", "))]
    Several(Vec<String>),
    /// Missing permission.
    #[error("{name} may not be opened: {remedy}, and plug it in again", name = .0, remedy = permission_remedy())]
    Permission(String),
    /// Another program uses it.
    #[error("{0} is in use: another host has the link; end that one first")]
    Busy(String),
    /// No interface for the control link.
    #[error("{0} has no control link: is its firmware of this version?")]
    NoPipes(String),
    /// Any other error.
    #[error("{name} does not open: {source}; plug it in again")]
    Other {
        /// URI of the board.
        name: String,
        /// Error of the system.
        source: io::Error,
    },
}

fn permission_remedy() -> String {
    if cfg!(target_os = "linux") {
        format!("let your user have it by the line {UDEV_RULE} in {UDEV_RULE_FILE}")
    } else {
        "end the other programs that may use it".into()
    }
}

/// Opens the control link of the board with this serial number, or of the only one.
///
/// # Errors
/// If there is none, more than one, or it cannot be opened.
pub fn open(serial: Option<&str>) -> Result<UsbLine, UsbError> {
    let devices: Vec<DeviceInfo> = nusb::list_devices()
        .wait()
        .map_err(|error| UsbError::List(error.into()))?
        .collect();
    let has_loader = devices
        .iter()
        .any(|device| (device.vendor_id(), device.product_id()) == ROM_LOADER);
    let boards: Vec<&DeviceInfo> = devices.iter().filter(|device| is_board(device)).collect();
    let serials: Vec<Option<&str>> = boards.iter().map(|board| board.serial_number()).collect();
    let board = boards[pick(&serials, serial, has_loader)?];
    let name = name(board.serial_number());
    let explain = |error: nusb::Error| explain(&name, error.kind(), error.into());
    let pipes = board
        .interfaces()
        .find(|interface| interface.class() == VENDOR_CLASS)
        .ok_or_else(|| UsbError::NoPipes(name.clone()))?;
    let device = board.open().wait().map_err(explain)?;
    let interface = device
        .claim_interface(pipes.interface_number())
        .wait()
        .map_err(explain)?;
    UsbLine::on(&interface)
        .map_err(explain)?
        .ok_or(UsbError::NoPipes(name))
}

/// Serial number of the only board that is plugged in, if it has one.
pub(super) fn serial_of_the_only_one() -> Option<String> {
    match serials().as_slice() {
        [only] => only.clone(),
        _ => None,
    }
}

/// Serial numbers of all boards with pipes that are plugged in; none where USB cannot be
/// listed.
pub(super) fn serials() -> Vec<Option<String>> {
    let Ok(devices) = nusb::list_devices().wait() else {
        return Vec::new();
    };
    let serials = devices
        .filter(is_board)
        .filter(|board| {
            let mut interfaces = board.interfaces();
            interfaces.any(|interface| interface.class() == VENDOR_CLASS)
        })
        .map(|board| board.serial_number().map(str::to_owned));
    serials.collect()
}

fn is_board(device: &DeviceInfo) -> bool {
    device.vendor_id() == VENDOR_ID
        && device.product_id() == PRODUCT_ID
        && device.product_string() == Some(PRODUCT_NAME)
}

/// URI of a board.
fn name(serial: Option<&str>) -> String {
    format!("usb:{}", serial.unwrap_or_default())
}

/// Index of the requested board.
fn pick(
    serials: &[Option<&str>],
    wanted: Option<&str>,
    has_loader: bool,
) -> Result<usize, UsbError> {
    let names = || serials.iter().map(|serial| name(*serial)).collect();
    match (serials, wanted) {
        ([], _) if has_loader => Err(UsbError::RomLoader),
        ([], _) => Err(UsbError::NoBoard),
        ([_], None) => Ok(0),
        (_, None) => Err(UsbError::Several(names())),
        (_, Some(wanted)) => serials
            .iter()
            .position(|serial| *serial == Some(wanted))
            .ok_or_else(|| UsbError::OtherSerial {
                wanted: wanted.into(),
                there: names(),
            }),
    }
}

fn explain(name: &str, kind: ErrorKind, source: io::Error) -> UsbError {
    let name = name.to_owned();
    match kind {
        ErrorKind::PermissionDenied => UsbError::Permission(name),
        ErrorKind::Busy => UsbError::Busy(name),
        ErrorKind::NotFound => UsbError::NoPipes(name),
        _ => UsbError::Other { name, source },
    }
}

/// The two pipes.
pub struct UsbLine {
    from_board: EndpointRead<Bulk>,
    to_board: EndpointWrite<Bulk>,
}

impl UsbLine {
    /// The pipes of this interface, if it has one in each direction.
    fn on(interface: &Interface) -> Result<Option<Self>, nusb::Error> {
        let address = |direction| {
            let pipes = interface.descriptor()?;
            let pipe = pipes
                .endpoints()
                .find(|pipe| pipe.direction() == direction)?;
            Some(pipe.address())
        };
        let (Some(from), Some(to)) = (address(Direction::In), address(Direction::Out)) else {
            return Ok(None);
        };
        let from_board = interface.endpoint::<Bulk, In>(from)?;
        let to_board = interface.endpoint::<Bulk, Out>(to)?;
        Ok(Some(Self {
            from_board: from_board.reader(TRANSFER).with_num_transfers(TRANSFERS),
            to_board: to_board.writer(TRANSFER).with_write_timeout(STUCK),
        }))
    }
}

impl Line for UsbLine {
    fn send(&mut self, bytes: &[u8]) -> io::Result<()> {
        self.to_board.write_all(bytes)?;
        self.to_board.flush()
    }

    fn receive(&mut self, until: Instant) -> io::Result<Vec<u8>> {
        let wait = until.saturating_duration_since(Instant::now());
        self.from_board.set_read_timeout(wait);
        read_chunk(&mut self.from_board)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_board_that_is_meant_is_found() {
        let (a, b) = (Some("A1"), Some("B2"));
        assert_eq!(pick(&[None], None, false).unwrap(), 0);
        assert_eq!(pick(&[a, b], b, true).unwrap(), 1);
        let error = pick(&[], None, true).unwrap_err().to_string();
        assert!(error.contains("B0 is still wired"), "{error}");
        for (there, wanted, words) in [
            (&[][..], None, "no board is plugged in"),
            (&[], a, "no board is plugged in"),
            (
                &[a, b],
                None,
                "2 boards are plugged in; name one of usb:A1, usb:B2",
            ),
            (&[a, None], b, "serial number B2; there is usb:A1, usb:"),
        ] {
            let error = pick(there, wanted, false).unwrap_err().to_string();
            assert!(error.contains(words), "{error}");
        }
    }

    #[test]
    fn system_errors_become_messages_with_a_remedy() {
        for (kind, words) in [
            (ErrorKind::PermissionDenied, &*permission_remedy()),
            (ErrorKind::Busy, "another host has the link"),
            (ErrorKind::NotFound, "firmware of this version"),
            (ErrorKind::Disconnected, "gone; plug it in again"),
        ] {
            let error = explain("usb:A1", kind, io::Error::other("gone")).to_string();
            assert!(error.contains("usb:A1") && error.contains(words), "{error}");
            assert!(!error.contains('\n'), "{error}");
        }
    }
}
