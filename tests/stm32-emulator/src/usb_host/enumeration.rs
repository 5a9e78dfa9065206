//! Enumeration: the requests of a host to a new device, and the descriptors it learns.

use super::control::Outcome;
use crate::time::Time;

/// A request of a control transfer (USB 2.0, section 9.3).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Request {
    /// Direction, type, recipient.
    pub kind: u8,
    /// The request.
    pub number: u8,
    /// Its value.
    pub value: u16,
    /// Its index.
    pub index: u16,
    /// Most bytes that the device may send.
    pub length: u16,
}

impl Request {
    /// A descriptor of the device.
    fn descriptor(kind: u8, index: u8, language: u16, length: u16) -> Self {
        Self {
            kind: 0x80,
            number: 6,
            value: u16::from(kind) << 8 | u16::from(index),
            index: language,
            length,
        }
    }

    /// A request of the standard without data.
    fn standard(number: u8, value: u16) -> Self {
        Self {
            kind: 0,
            number,
            value,
            index: 0,
            length: 0,
        }
    }

    /// `SET_LINE_CODING` of the serial port's interface.
    pub fn line_coding() -> Self {
        Self {
            kind: 0x21,
            number: 0x20,
            ..Self::standard(0, 0)
        }
    }

    /// `SET_CONTROL_LINE_STATE` of the serial port's interface.
    pub fn control_lines(is_open: bool) -> Self {
        Self {
            kind: 0x21,
            number: 0x22,
            ..Self::standard(0, if is_open { 3 } else { 0 })
        }
    }

    /// Whether its data come from the device.
    pub fn is_in(&self) -> bool {
        self.kind & 0x80 != 0 && self.length != 0
    }

    /// The SETUP packet, with this many bytes to send.
    pub fn to_bytes(self, sent: usize) -> [u8; 8] {
        let length = if self.is_in() {
            self.length
        } else {
            sent as u16
        };
        let [v0, v1] = self.value.to_le_bytes();
        let [i0, i1] = self.index.to_le_bytes();
        let [l0, l1] = length.to_le_bytes();
        [self.kind, self.number, v0, v1, i0, i1, l0, l1]
    }
}

/// Descriptors of a device.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Descriptors {
    /// Device descriptor.
    pub device: Vec<u8>,
    /// Configuration, with interfaces and endpoints.
    pub configuration: Vec<u8>,
    /// Binary object store: capabilities.
    pub capabilities: Vec<u8>,
    /// Microsoft's descriptor set, version 2.0.
    pub microsoft: Vec<u8>,
    /// Manufacturer, product, serial number, as far as the device has them.
    pub strings: [Option<String>; 3],
}

/// Addresses of endpoints by function.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Endpoints {
    /// Control link.
    pub link_out: Option<u8>,
    /// Control link.
    pub link_in: Option<u8>,
    /// Serial port.
    pub serial_out: Option<u8>,
    /// Serial port.
    pub serial_in: Option<u8>,
}

impl Descriptors {
    /// Vendor and product.
    pub fn ids(&self) -> Option<(u16, u16)> {
        let word = |at: usize| {
            let bytes = self.device.get(at..at + 2)?;
            Some(u16::from_le_bytes(bytes.try_into().ok()?))
        };
        Some((word(8)?, word(10)?))
    }

    /// Endpoints of the vendor's interface and of the serial port's data interface.
    pub fn endpoints(&self) -> Endpoints {
        let mut endpoints = Endpoints::default();
        let mut class = 0;
        let mut rest = self.configuration.as_slice();
        while let [len, kind, ..] = *rest {
            let (descriptor, later) = rest.split_at(usize::from(len).clamp(1, rest.len()));
            rest = later;
            match (kind, descriptor) {
                (4, [_, _, _, _, _, interface, ..]) => class = *interface,
                (5, [_, _, address, ..]) => {
                    let slot = match (class, address & 0x80) {
                        (0xFF, 0) => &mut endpoints.link_out,
                        (0xFF, _) => &mut endpoints.link_in,
                        (0x0A, 0) => &mut endpoints.serial_out,
                        (0x0A, _) => &mut endpoints.serial_in,
                        _ => continue,
                    };
                    *slot = Some(*address);
                }
                _ => {}
            }
        }
        endpoints
    }

    /// Vendor code of the request for Microsoft's descriptors and their length: from the
    /// platform capability with their identifier.
    fn microsoft_request(&self) -> Option<(u8, u16)> {
        /// `{D8DD60DF-4589-4CC7-9CD2-659D9E648A9F}` as bytes of the descriptor.
        const ID: [u8; 16] = [
            0xDF, 0x60, 0xDD, 0xD8, 0x89, 0x45, 0xC7, 0x4C, 0x9C, 0xD2, 0x65, 0x9D, 0x9E, 0x64,
            0x8A, 0x9F,
        ];
        let at = self
            .capabilities
            .windows(16)
            .position(|bytes| bytes == ID)?;
        let after = self.capabilities.get(at + 16..at + 23)?;
        Some((after[6], u16::from_le_bytes([after[4], after[5]])))
    }

    /// Index of a string: manufacturer, product, serial number.
    fn string_index(&self, string: usize) -> u8 {
        self.device.get(14 + string).copied().unwrap_or(0)
    }
}

/// A step of the enumeration: a request.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Step {
    /// The first 8 bytes of the device descriptor, at address 0.
    Begin,
    /// An address.
    Address,
    /// The device descriptor.
    Device,
    /// The head of the configuration, which has its length.
    Head,
    /// The configuration.
    Configuration,
    /// A string: manufacturer, product, serial number.
    String(usize),
    /// The head of the capabilities.
    CapabilitiesHead,
    /// The capabilities.
    Capabilities,
    /// Microsoft's descriptors.
    Microsoft,
    /// The choice of the configuration.
    Configure,
    /// All is known.
    Done,
}

/// The address that the host gives.
const ADDRESS: u16 = 5;
/// US English.
const LANGUAGE: u16 = 0x409;

impl Step {
    /// The first one.
    pub fn first() -> Self {
        Self::Begin
    }

    /// Its request.
    pub fn request(self, known: &Descriptors) -> Request {
        let length_at = |bytes: &[u8]| match bytes {
            [_, _, low, high, ..] => u16::from_le_bytes([*low, *high]),
            _ => 0,
        };
        match self {
            Self::Begin => Request::descriptor(1, 0, 0, 64),
            Self::Address => Request::standard(5, ADDRESS),
            Self::Device => Request::descriptor(1, 0, 0, 18),
            Self::Head => Request::descriptor(2, 0, 0, 9),
            Self::Configuration => Request::descriptor(2, 0, 0, length_at(&known.configuration)),
            Self::String(string) => {
                Request::descriptor(3, known.string_index(string), LANGUAGE, 255)
            }
            Self::CapabilitiesHead => Request::descriptor(15, 0, 0, 5),
            Self::Capabilities => Request::descriptor(15, 0, 0, length_at(&known.capabilities)),
            Self::Microsoft => {
                let (number, length) = known.microsoft_request().unwrap_or((0, 0));
                Request {
                    kind: 0xC0,
                    number,
                    value: 0,
                    // `MS_OS_20_DESCRIPTOR_INDEX`.
                    index: 7,
                    length,
                }
            }
            Self::Configure | Self::Done => Request::standard(9, 1),
        }
    }

    /// Time that the host gives the device after it.
    pub fn pause(self) -> Time {
        match self {
            // Section 9.2.6.3.
            Self::Address => Time::from_us(2_000),
            _ => Time::from_us(100),
        }
    }

    /// Takes the answer, and returns the next step; `None` if the device refused a request
    /// that it must know.
    pub fn take(self, outcome: Outcome, known: &mut Descriptors) -> Option<Self> {
        let data = outcome.ok()?;
        let string_or_next = |string: usize, known: &Descriptors| {
            let mut rest = string..3;
            let next = rest.find(|string| known.string_index(*string) != 0);
            next.map_or(Self::CapabilitiesHead, Self::String)
        };
        Some(match self {
            Self::Begin => Self::Address,
            Self::Address => Self::Device,
            Self::Device => {
                known.device = data;
                Self::Head
            }
            Self::Head => {
                known.configuration = data;
                Self::Configuration
            }
            Self::Configuration => {
                known.configuration = data;
                string_or_next(0, known)
            }
            Self::String(string) => {
                let units = data.get(2..)?.chunks_exact(2);
                let units: Vec<u16> = units
                    .map(|unit| u16::from_le_bytes([unit[0], unit[1]]))
                    .collect();
                known.strings[string] = Some(String::from_utf16_lossy(&units));
                string_or_next(string + 1, known)
            }
            Self::CapabilitiesHead => {
                known.capabilities = data;
                Self::Capabilities
            }
            Self::Capabilities => {
                known.capabilities = data;
                match known.microsoft_request() {
                    Some(_) => Self::Microsoft,
                    None => Self::Configure,
                }
            }
            Self::Microsoft => {
                known.microsoft = data;
                Self::Configure
            }
            Self::Configure | Self::Done => Self::Done,
        })
    }
}
