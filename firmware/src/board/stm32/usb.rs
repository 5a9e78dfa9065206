//! Control link and transparent port: USB, full speed.
//!
//! | port             | as                  | endpoints beside control          |
//! |------------------|---------------------|-----------------------------------|
//! | transparent port | CDC ACM, a serial port | interrupt IN, bulk IN, bulk OUT |
//! | control link     | vendor's own, two pipes | bulk IN, bulk OUT              |
//!
//! The controller has three IN endpoints beside control (reference manual,
//! section 34.1), and two CDC ACM functions would need four. The port for third-party
//! programs must be a serial port; the link is used by the project's own
//! host program only, so it needs none. Windows finds its driver for it (`WinUSB`) and the
//! name of its interface by the descriptors of Microsoft's that come with it.
//!
//! # Attaching
//!
//! The driver pulls D+ up, lets go of it and pulls it up again within microseconds, while the
//! errata sheet of the chip asks for 3 ms between. Until [`ATTACH_MS`] later the pin is an
//! output that is low ([`run`]), so that a host sees one attachment.
//!
//! # A second configuration
//!
//! A host that configures the board begins at DATA0. The driver sets the board's toggles to
//! DATA0 at a bus reset, but not when it is configured a second time. Then it also empties the
//! FIFO of a packet that the host has not fetched, and leaves the endpoint waiting for it for
//! ever. [`Restart`] mends both.
//!
//! # Asserts of the driver
//!
//! The driver's interrupt handler is not in the image that links only without panics. Three of
//! its asserts depend on what the controller reports of a packet: its endpoint exists, and a
//! SETUP packet has 8 bytes and is of endpoint 0. A host cannot choose otherwise: the controller
//! takes packets for enabled endpoints alone, and SETUP only as 8 bytes on a control endpoint
//! (section 34.16.2, `GRXSTSP`). A controller that reports nonsense is a panic, and motors off.

use super::pin::Pin;
use crate::tasks::{FromClient, FromHost, LineChanges, ToHost};
use armbridge_board::bridge::transparent_port::ClientLine;
use embassy_futures::join::join;
use embassy_stm32::pac::GPIOA;
use embassy_stm32::pac::gpio::vals::Moder;
use embassy_stm32::peripherals::{PA11, PA12, USB_OTG_FS};
use embassy_stm32::usb::{self, Driver, InterruptHandler};
use embassy_stm32::{Peri, bind_interrupts, pac, uid};
use embassy_time::Timer;
use embassy_usb::class::cdc_acm::{CdcAcmClass, ControlChanged, Receiver, Sender, State};
use embassy_usb::driver::{Endpoint as _, EndpointIn as _, EndpointOut as _};
use embassy_usb::msos::{
    CompatibleIdFeatureDescriptor, PropertyData, RegistryPropertyFeatureDescriptor, windows_version,
};
use embassy_usb::{Builder, Config, Handler, UsbDevice};
use static_cell::StaticCell;

bind_interrupts!(struct Irqs {
    OTG_FS => InterruptHandler<USB_OTG_FS>;
});

/// Longest packet of a full-speed bulk endpoint.
const PACKET_MAX: usize = 64;
/// The vendor-specific class.
const VENDOR: u8 = 0xFF;
/// Request number by which Windows reads Microsoft's descriptors; the value is arbitrary.
const MICROSOFT: u8 = 0x20;
/// Name by which programs find the interface of the control link on Windows.
const INTERFACE_GUID: &str = "{9BD2DF71-6BE5-4C43-9D3B-3E0A5A1F5F43}";
/// Length of Microsoft's descriptors: 178 bytes.
const MICROSOFTS_LEN: usize = 256;
/// D+.
const PLUS: Pin = Pin::new(GPIOA, 12);
/// Time in ms from the start of the driver until the board attaches: more than 3 ms after the
/// driver's last change, which is in the first poll of the device.
const ATTACH_MS: u64 = 5;
/// Endpoints beside control that this device uses, at most, in each direction.
const ENDPOINTS: usize = 3;

/// The driver.
pub type Otg = Driver<'static, USB_OTG_FS>;
type Out = <Otg as embassy_usb::driver::Driver<'static>>::EndpointOut;
type In = <Otg as embassy_usb::driver::Driver<'static>>::EndpointIn;

/// Device and streams of [`start`].
pub struct Ports {
    /// Device, to be run for ever.
    pub device: UsbDevice<'static, Otg>,
    /// Bytes from the host.
    pub from_host: FromUsb,
    /// Bytes to the host.
    pub to_host: ToUsb,
    /// Bytes from the client of the transparent port.
    pub from_client: FromSerial,
    /// Bytes to that client.
    pub to_client: ToSerial,
    /// Changes of its port settings.
    pub changes: Changes,
}

/// Runs the device for ever, and attaches it.
pub async fn run(mut device: UsbDevice<'static, Otg>) -> ! {
    let attach = async {
        Timer::after_millis(ATTACH_MS).await;
        PLUS.set_mode(Moder::ALTERNATE);
    };
    join(device.run(), attach).await.0
}

/// Restarts the endpoints when a host configures the device: nothing to be sent, and DATA0.
struct Restart;

impl Handler for Restart {
    fn configured(&mut self, configured: bool) {
        if !configured {
            return;
        }
        for endpoint in 1..=ENDPOINTS {
            // The interrupt handler does not write these registers; the tasks that do are
            // not run meanwhile.
            let control = pac::USB_OTG_FS.diepctl(endpoint);
            if control.read().epena() {
                // NAK was set when the endpoint was enabled (section 34.17.6).
                control.modify(|w| w.set_epdis(true));
            }
            control.modify(|w| w.set_sd0pid_sevnfrm(true));
            pac::USB_OTG_FS
                .doepctl(endpoint)
                .modify(|w| w.set_sd0pid_sevnfrm(true));
        }
    }
}

/// Builds the device; call once.
pub fn start(
    otg: Peri<'static, USB_OTG_FS>,
    plus: Peri<'static, PA12>,
    minus: Peri<'static, PA11>,
) -> Ports {
    // Room for one packet of each OUT endpoint: control, link, port.
    static OUT: StaticCell<[u8; 4 * PACKET_MAX]> = StaticCell::new();
    static CONFIGURATION: StaticCell<[u8; 192]> = StaticCell::new();
    // Header, the capability that USB 2.1 asks for, Microsoft's.
    static CAPABILITIES: StaticCell<[u8; 48]> = StaticCell::new();
    static MICROSOFTS: StaticCell<[u8; MICROSOFTS_LEN]> = StaticCell::new();
    // The longest answer of a control transfer, Microsoft's descriptors, is a part of it.
    static CONTROL: StaticCell<[u8; MICROSOFTS_LEN]> = StaticCell::new();
    static RESTART: StaticCell<Restart> = StaticCell::new();
    static STATE: StaticCell<State<'static>> = StaticCell::new();

    let mut electrical = usb::Config::default();
    // PA9 is not wired to the USB connector's supply on every board, and the chip has no other
    // way to detect it.
    electrical.vbus_detection = false;
    let out = OUT.init([0; 4 * PACKET_MAX]);
    let driver = Driver::new_fs(otg, Irqs, plus, minus, out, electrical);
    PLUS.make_output(false);

    // The vendor and product id that pid.codes reserves for tests.
    let mut config = Config::new(0x1209, 0x0001);
    config.manufacturer = Some("Armbridge");
    config.product = Some("Armbridge");
    // The chip's unique identifier (section 39.1): two boards are two.
    config.serial_number = Some(uid::uid_hex());
    let mut builder = Builder::new(
        driver,
        config,
        CONFIGURATION.init([0; 192]),
        CAPABILITIES.init([0; 48]),
        MICROSOFTS.init([0; MICROSOFTS_LEN]),
        CONTROL.init([0; MICROSOFTS_LEN]),
    );
    builder.msos_descriptor(windows_version::WIN8_1, MICROSOFT);
    let state = STATE.init(State::new());
    let serial = CdcAcmClass::new(&mut builder, state, PACKET_MAX as u16);
    let (to_client, from_client, changes) = serial.split_with_control();

    builder.handler(RESTART.init(Restart));
    let mut function = builder.function(VENDOR, 0, 0);
    function.msos_feature(CompatibleIdFeatureDescriptor::new("WINUSB", ""));
    function.msos_feature(RegistryPropertyFeatureDescriptor::new(
        "DeviceInterfaceGUIDs",
        PropertyData::RegMultiSz(&[INTERFACE_GUID]),
    ));
    let mut interface = function.interface();
    let mut pipes = interface.alt_setting(VENDOR, 0, 0, None);
    let from_host = pipes.endpoint_bulk_out(None, PACKET_MAX as u16);
    let to_host = pipes.endpoint_bulk_in(None, PACKET_MAX as u16);
    drop(function);
    Ports {
        device: builder.build(),
        from_host: FromUsb(from_host),
        to_host: ToUsb(to_host),
        from_client: FromSerial(from_client),
        to_client: ToSerial(to_client),
        changes: Changes(changes),
    }
}

/// The part of `bytes` for one packet. A full packet announces another one:
/// never end on one.
fn packet(bytes: &[u8]) -> &[u8] {
    let len = match bytes.len() {
        PACKET_MAX => PACKET_MAX - 1,
        len => len.min(PACKET_MAX),
    };
    bytes.get(..len).unwrap_or_default()
}

/// Bytes from the host.
pub struct FromUsb(Out);

impl FromHost for FromUsb {
    async fn read(&mut self, buffer: &mut [u8]) -> usize {
        loop {
            match self.0.read(buffer).await {
                Ok(0) => {}
                Ok(len) => return len,
                Err(_) => self.0.wait_enabled().await,
            }
        }
    }
}

/// Bytes to the host.
pub struct ToUsb(In);

impl ToHost for ToUsb {
    async fn write(&mut self, bytes: &[u8]) -> usize {
        let packet = packet(bytes);
        if self.0.write(packet).await.is_ok() {
            return packet.len();
        }
        self.0.wait_enabled().await;
        0
    }
}

/// Bytes from the client of the transparent port.
pub struct FromSerial(Receiver<'static, Otg>);

impl FromHost for FromSerial {
    async fn read(&mut self, buffer: &mut [u8]) -> usize {
        loop {
            match self.0.read_packet(buffer).await {
                Ok(0) => {}
                Ok(len) => return len,
                Err(_) => self.0.wait_connection().await,
            }
        }
    }
}

impl FromClient for FromSerial {
    fn line(&self) -> ClientLine {
        ClientLine {
            is_open: self.0.dtr(),
            baud: self.0.line_coding().data_rate(),
        }
    }
}

/// Bytes to that client.
pub struct ToSerial(Sender<'static, Otg>);

impl ToHost for ToSerial {
    async fn write(&mut self, bytes: &[u8]) -> usize {
        let packet = packet(bytes);
        if self.0.write_packet(packet).await.is_ok() {
            return packet.len();
        }
        self.0.wait_connection().await;
        0
    }
}

/// Changes of that client's port settings.
pub struct Changes(ControlChanged<'static>);

impl LineChanges for Changes {
    async fn changed(&mut self) {
        self.0.control_changed().await;
    }
}
