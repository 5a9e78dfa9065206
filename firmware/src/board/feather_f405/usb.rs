//! The control link: USB, full speed, one CDC ACM port.

use crate::run::{FromHost, ToHost};
use embassy_stm32::peripherals::{PA11, PA12, USB_OTG_FS};
use embassy_stm32::usb::{self, Driver, InterruptHandler};
use embassy_stm32::{Peri, bind_interrupts};
use embassy_usb::class::cdc_acm::{CdcAcmClass, Receiver, Sender, State};
use embassy_usb::{Builder, Config, UsbDevice};
use static_cell::StaticCell;

bind_interrupts!(struct Irqs {
    OTG_FS => InterruptHandler<USB_OTG_FS>;
});

/// Longest packet of a full-speed bulk endpoint.
const PACKET_MAX: usize = 64;

type Otg = Driver<'static, USB_OTG_FS>;

/// What [`start`] gives.
pub struct Link {
    /// To be run for ever.
    pub device: UsbDevice<'static, Otg>,
    /// Bytes from the host.
    pub from_host: FromUsb,
    /// Bytes to the host.
    pub to_host: ToUsb,
}

/// Makes the device; once.
pub fn start(
    otg: Peri<'static, USB_OTG_FS>,
    plus: Peri<'static, PA12>,
    minus: Peri<'static, PA11>,
) -> Link {
    // Room for one packet of each OUT endpoint: control and data.
    static OUT: StaticCell<[u8; 4 * PACKET_MAX]> = StaticCell::new();
    static CONFIGURATION: StaticCell<[u8; 128]> = StaticCell::new();
    // Five bytes of header and seven of the only capability, as USB 2.1 asks.
    static CAPABILITIES: StaticCell<[u8; 12]> = StaticCell::new();
    static CONTROL: StaticCell<[u8; PACKET_MAX]> = StaticCell::new();
    static STATE: StaticCell<State<'static>> = StaticCell::new();

    let mut electrical = usb::Config::default();
    // PA9 is not wired to the USB connector's supply on this board, and the
    // chip has no other way to see it.
    electrical.vbus_detection = false;
    let out = OUT.init([0; 4 * PACKET_MAX]);
    let driver = Driver::new_fs(otg, Irqs, plus, minus, out, electrical);

    // The vendor and product that pid.codes keeps for tests.
    let mut config = Config::new(0x1209, 0x0001);
    config.manufacturer = Some("Armbridge");
    config.product = Some("Armbridge control link");
    let mut builder = Builder::new(
        driver,
        config,
        CONFIGURATION.init([0; 128]),
        CAPABILITIES.init([0; 12]),
        // No descriptors of Microsoft's own.
        &mut [],
        CONTROL.init([0; PACKET_MAX]),
    );
    let state = STATE.init(State::new());
    let port = CdcAcmClass::new(&mut builder, state, PACKET_MAX as u16);
    let (sender, receiver) = port.split();
    Link {
        device: builder.build(),
        from_host: FromUsb(receiver),
        to_host: ToUsb(sender),
    }
}

/// Bytes from the host.
pub struct FromUsb(Receiver<'static, Otg>);

impl FromHost for FromUsb {
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

/// Bytes to the host.
pub struct ToUsb(Sender<'static, Otg>);

impl ToHost for ToUsb {
    async fn write(&mut self, bytes: &[u8]) -> usize {
        // A full packet says that more is to come: never end a frame on one.
        let len = if bytes.len() == PACKET_MAX {
            PACKET_MAX - 1
        } else {
            bytes.len().min(PACKET_MAX)
        };
        let packet = bytes.get(..len).unwrap_or_default();
        if self.0.write_packet(packet).await.is_ok() {
            return len;
        }
        self.0.wait_connection().await;
        0
    }
}
