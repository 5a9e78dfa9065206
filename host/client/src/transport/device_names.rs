//! Examples of devices' names, as users of this system know them, for messages.

#[cfg(not(windows))]
mod here {
    /// A serial device.
    pub const DEVICE: &str = "/dev/ttyUSB0";
    /// The link to a board at its serial port.
    pub const SERIAL_LINK: &str = "serial:///dev/ttyACM0";
}

#[cfg(windows)]
mod here {
    /// A serial device.
    pub const DEVICE: &str = "COM3";
    /// The link to a board at its serial port.
    pub const SERIAL_LINK: &str = "serial:COM3";
}

pub use here::{DEVICE, SERIAL_LINK};
