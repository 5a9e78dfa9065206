//! Board in virtual time: the interface to the bench, and the application core in this
//! process.

use std::collections::VecDeque;

use armbridge_board::bridge::supply_relay::SupplyPermission;
use armbridge_board::bridge::transparent_port::{ClientLine, PortEnd};
use armbridge_board::bridge::{
    Bridge, BridgeEnd, LinkEnd, LinkPort, MemoryRegion, Progress, can_run,
};
use armbridge_board::store::Store;
use armbridge_board::store::memory::Memory;
use armbridge_link::message::{BoardReport, Mode, Refusal, StopSource};
use armbridge_servo::serial_bus::SerialBus;

use super::uart::{Direction, Uart};

/// Limit of the bridge's work at one instant, which is the end of an exchange and a few
/// steps of bring-up that take no time.
const POLLS_MAX: usize = 1_000;

/// Inputs of a board.
#[derive(Clone, Copy, Debug, Default)]
pub struct Input<'a> {
    /// Bytes from the servo bus.
    pub bus: &'a [u8],
    /// Bytes from the host.
    pub link: &'a [u8],
    /// Bytes from the client of the transparent port.
    pub client: &'a [u8],
    /// Settings of that client's port.
    pub line: ClientLine,
    /// The emergency stop's switch is pressed.
    pub is_stop_pressed: bool,
}

/// Outputs of a board's run.
#[derive(Debug, Default)]
pub struct Output {
    /// Bytes for the servo bus, sent back to back from the time of the run.
    pub bus: Vec<u8>,
    /// Baud rate of that bus; 0 before it is set.
    pub bus_baud: u32,
    /// Bytes for the client of the transparent port.
    pub client: Vec<u8>,
    /// Bytes of that client for which the board has no room yet.
    pub client_waiting: usize,
    /// Bytes for the host.
    pub link: Vec<u8>,
}

/// Condition for the next run of a board: a time, or a number of bytes from the bus,
/// whichever is first.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Wake {
    /// Latest time, in µs.
    pub at_us: u64,
    /// Number of bytes, if any.
    pub bus_bytes: Option<usize>,
}

/// A board in virtual time.
pub trait Board {
    /// Reason for which the board can no longer run.
    type Error;

    /// Passes the inputs, and runs the board at `now_us` until it has
    /// nothing left to do. Returns when it must run again.
    ///
    /// # Errors
    /// If the board is gone.
    fn run(
        &mut self,
        now_us: u64,
        input: Input<'_>,
        output: &mut Output,
    ) -> Result<Wake, Self::Error>;
}

/// Bytes of a page of a virtual board's flash.
const FLASH_PAGE: usize = 8 * 1_024;
/// Saves for which a boot reserves space.
const SAVES: u32 = 16;

/// Flash of a virtual board, with its settings.
pub type Flash = Memory<Vec<u8>, FLASH_PAGE>;

/// Erased flash.
pub fn blank_flash() -> Flash {
    Memory(vec![0xFF; 2 * FLASH_PAGE])
}

/// The application core in this process: the same code as on a board, in the
/// order in which a board's priorities run it.
pub struct VirtualBoard<'a> {
    store: Store<Flash>,
    uart: Uart,
    bridge: Bridge<'a, SerialBus<Uart, Direction>>,
    link: LinkPort<'a>,
    client: PortEnd<'a>,
    from_client: VecDeque<u8>,
    supply: SupplyPermission,
    /// Sum of all jumps of the board's clock.
    skew_us: i64,
}

impl<'a> VirtualBoard<'a> {
    /// A board just out of reset, with all ends of its channels, and without saved
    /// settings.
    ///
    /// # Errors
    /// If the default set-up has no controller.
    pub fn new(ends: (BridgeEnd<'a>, LinkEnd<'a>, PortEnd<'a>)) -> Result<Self, Refusal> {
        Self::with_flash(ends, blank_flash())
    }

    /// The same, with the flash of an earlier board.
    ///
    /// # Errors
    /// If the default set-up has no controller.
    pub fn with_flash(
        ends: (BridgeEnd<'a>, LinkEnd<'a>, PortEnd<'a>),
        flash: Flash,
    ) -> Result<Self, Refusal> {
        let first = BoardReport {
            session: 1,
            ..BoardReport::default()
        };
        Self::after_reset(ends, flash, first)
    }

    /// The same, with a report of the reset before and of the number of resets, its
    /// session.
    ///
    /// # Errors
    /// If the default set-up has no controller.
    pub fn after_reset(
        (bridge, link, client): (BridgeEnd<'a>, LinkEnd<'a>, PortEnd<'a>),
        flash: Flash,
        report: BoardReport,
    ) -> Result<Self, Refusal> {
        let uart = Uart::default();
        let mut store = Store::new(flash);
        // Saved settings can be loaded all the same; saving will fail.
        let _ = store.prepare(SAVES);
        let (settings, from) = store.load(can_run);
        let report = BoardReport {
            settings: from,
            ..report
        };
        let bus = SerialBus::new(uart.clone(), Direction);
        Ok(Self {
            bridge: Bridge::new(bus, bridge, 0, &settings)?,
            link: LinkPort::new(link, report, settings),
            client,
            from_client: VecDeque::new(),
            supply: SupplyPermission::Off,
            skew_us: 0,
            uart,
            store,
        })
    }

    /// Contents of the flash after power-off.
    pub fn flash(&mut self) -> &mut Flash {
        self.store.flash()
    }

    /// Shifts the board's clock, ahead or back. Its serial port has a separate clock,
    /// which is not shifted.
    pub fn shift_clock(&mut self, by_us: i64) {
        self.skew_us += by_us;
    }

    /// The time on the board's clock.
    pub(crate) fn clock_us(&self, now_us: u64) -> u64 {
        now_us.saturating_add_signed(self.skew_us)
    }

    /// Flips a bit of the board's memory, chosen by `draw`.
    pub fn inject_error(&mut self, region: MemoryRegion, draw: u32) {
        self.bridge.inject_error(region, draw);
    }

    /// Mode of the bridge.
    pub fn mode(&self) -> Mode {
        self.bridge.mode()
    }

    /// Output for the servos' supply after the last run. Nothing is connected to it: a bench
    /// without a relay is the harder one.
    pub fn supply(&self) -> SupplyPermission {
        self.supply
    }
}

impl Board for VirtualBoard<'_> {
    type Error = std::convert::Infallible;

    fn run(
        &mut self,
        now_us: u64,
        input: Input<'_>,
        output: &mut Output,
    ) -> Result<Wake, Self::Error> {
        self.link.receive(input.link);
        self.uart.deliver(now_us, input.bus);
        self.client.set_line(input.line);
        // Bytes without room wait, as they would in a USB host.
        self.from_client.extend(input.client);
        let taken = self.client.receive(self.from_client.make_contiguous());
        self.from_client.drain(..taken);
        output.client_waiting = self.from_client.len();
        if input.is_stop_pressed {
            self.bridge.emergency_stop(StopSource::Pin);
        }
        let clock_us = self.clock_us(now_us);
        let mut polls = 0;
        loop {
            let progress = self.bridge.poll(clock_us);
            self.supply = match self.bridge.supply() {
                SupplyPermission::On if !input.is_stop_pressed => SupplyPermission::On,
                _ => SupplyPermission::Off,
            };
            let Ok(progress) = progress else {
                break;
            };
            polls += 1;
            assert!(polls < POLLS_MAX, "the bridge does not come to rest");
            if progress == Progress::Sampled {
                self.bridge.decide();
                self.bridge.publish(0);
            }
        }
        loop {
            while let Some(frame) = self.link.transmit() {
                output.link.extend_from_slice(frame);
            }
            let Some((sequence, settings)) = self.link.take_save() else {
                break;
            };
            let result = self.store.save(settings);
            self.link.saved(sequence, result.is_ok());
        }
        output
            .client
            .extend(std::iter::from_fn(|| self.client.transmit()));
        self.uart.take_sent(&mut output.bus);
        output.bus_baud = self.uart.baud();
        let wake_us = self
            .bridge
            .wake_at_us()
            .saturating_add_signed(-self.skew_us);
        let sent_us = self.uart.transmit_complete_us();
        Ok(Wake {
            at_us: sent_us.map_or(wake_us, |sent_us| wake_us.min(sent_us)),
            bus_bytes: self.bridge.bytes_wanted(),
        })
    }
}
