//! USB OTG FS (section 34), the device's side, in slave mode.
//!
//! [`endpoint`] has what an endpoint does with its control register. The host's side of the
//! cable is [`crate::usb_host`], which calls the functions of [`bus`](self) below: bus
//! reset, suspend, and one transaction at a time. Isochronous endpoints, frame interrupts,
//! DMA and the host's role are not modelled.

pub mod endpoint;
mod registers;

use std::collections::VecDeque;

use endpoint::Endpoint;

/// Endpoints of each direction, control included.
pub const ENDPOINTS: usize = 6;

const GINT: u32 = 1;
/// Interrupts that are raised and cleared by name (section 34.16.2).
const RXFLVL: u32 = 1 << 4;
const USBSUSP: u32 = 1 << 11;
const USBRST: u32 = 1 << 12;
const ENUMDNE: u32 = 1 << 13;
const IEPINT: u32 = 1 << 18;
const OEPINT: u32 = 1 << 19;
const WKUPINT: u32 = 1 << 31;

const DCTL_SDIS: u32 = 1 << 1;
/// Transceiver on, despite its name.
const GCCFG_PWRDWN: u32 = 1 << 16;

/// Status words of the receive FIFO (GRXSTSP).
const OUT_DATA: u32 = 2;
const OUT_DONE: u32 = 3;
const SETUP_DONE: u32 = 4;
const SETUP_DATA: u32 = 6;

/// The device's answer to a transaction.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Answer {
    /// It took the packet.
    Ack,
    /// Not now.
    Nak,
    /// The request or the endpoint is halted.
    Stall,
    /// A packet, and its data toggle.
    Data(Vec<u8>, bool),
    /// Nothing: no such endpoint or address.
    Silence,
}

/// An entry of the receive FIFO.
#[derive(Clone, Debug)]
struct Entry {
    status: u32,
    endpoint: usize,
    data: Vec<u8>,
}

/// The block.
#[derive(Clone, Debug)]
pub struct Otg {
    interrupts: u32,
    mask: u32,
    ahb: u32,
    usb: u32,
    session: u32,
    phy: u32,
    id: u32,
    device: u32,
    device_control: u32,
    in_mask: u32,
    out_mask: u32,
    all_mask: u32,
    empty_mask: u32,
    power: u32,
    receive_words: u32,
    transmit: [u32; ENDPOINTS],
    received: VecDeque<Entry>,
    /// Words of the entry that was popped, not yet read.
    reading: VecDeque<u32>,
    inputs: [Endpoint; ENDPOINTS],
    outputs: [Endpoint; ENDPOINTS],
    /// D+ is a pin of this block: its alternate function is chosen.
    pub is_wired: bool,
    /// Packets that the device could not take since its FIFO was full.
    refused: u32,
}

impl Default for Otg {
    fn default() -> Self {
        Self {
            interrupts: 0,
            mask: 0,
            ahb: 0,
            usb: 0x0000_1440,
            session: 0x0001_0000,
            phy: 0,
            id: 0x0000_1200,
            device: 0x0220_0000,
            // As after a reset: connected as soon as the transceiver is on.
            device_control: 0,
            in_mask: 0,
            out_mask: 0,
            all_mask: 0,
            empty_mask: 0,
            power: 0,
            receive_words: 0x200,
            transmit: [0x0200_0200; ENDPOINTS],
            received: VecDeque::new(),
            reading: VecDeque::new(),
            inputs: endpoints(),
            outputs: endpoints(),
            is_wired: false,
            refused: 0,
        }
    }
}

/// Endpoints of one direction.
fn endpoints() -> [Endpoint; ENDPOINTS] {
    let mut endpoints: [Endpoint; ENDPOINTS] = Default::default();
    endpoints[0] = Endpoint::zero();
    endpoints
}

impl Otg {
    /// The block of a chip whose core has this id (register CID).
    pub fn with_id(id: u32) -> Self {
        Self {
            id,
            ..Self::default()
        }
    }

    /// Whether the pull-up of D+ tells the host that there is a device.
    pub fn is_pulled_up(&self) -> bool {
        self.is_wired && self.device_control & DCTL_SDIS == 0 && self.phy & GCCFG_PWRDWN != 0
    }

    /// Packets for which the receive FIFO had no room.
    pub fn refused(&self) -> u32 {
        self.refused
    }

    /// Whether its interrupt line is high.
    pub fn is_interrupt(&self) -> bool {
        self.ahb & GINT != 0 && self.pending() & self.mask != 0
    }

    fn pending(&self) -> u32 {
        let all = self.all_interrupts() & self.all_mask;
        let bit = |is_set: bool, bit: u32| if is_set { bit } else { 0 };
        self.interrupts
            | bit(!self.received.is_empty(), RXFLVL)
            | bit(all & 0xFFFF != 0, IEPINT)
            | bit(all >> 16 != 0, OEPINT)
    }

    /// DAINT: endpoints with an interrupt that is not masked.
    fn all_interrupts(&self) -> u32 {
        let inputs = self.inputs.iter().enumerate().map(|(index, endpoint)| {
            let is_empty_wanted = self.empty_mask >> index & 1 != 0;
            let is_set = endpoint.interrupts & self.in_mask != 0
                || is_empty_wanted && endpoint.fifo.is_empty();
            u32::from(is_set) << index
        });
        let outputs = self.outputs.iter().enumerate().map(|(index, endpoint)| {
            u32::from(endpoint.interrupts & self.out_mask != 0) << (16 + index)
        });
        inputs.chain(outputs).fold(0, |word, bit| word | bit)
    }

    /// The host resets the bus.
    pub fn bus_reset(&mut self) {
        self.interrupts |= USBRST;
        self.device &= !(0x7F << 4);
        self.received.clear();
        self.inputs.iter_mut().for_each(Endpoint::bus_reset);
        self.outputs.iter_mut().for_each(Endpoint::bus_reset);
    }

    /// The end of the bus reset: the speed is known.
    pub fn enumerated(&mut self) {
        self.interrupts |= ENUMDNE;
    }

    /// The bus has been idle for 3 ms.
    pub fn suspend(&mut self) {
        self.interrupts |= USBSUSP;
    }

    /// The host resumes.
    pub fn resume(&mut self) {
        self.interrupts |= WKUPINT;
    }

    fn words_used(&self) -> usize {
        let words = |entry: &Entry| 1 + entry.data.len().div_ceil(4);
        self.received.iter().map(words).sum::<usize>() + self.reading.len()
    }

    fn has_room(&self, len: usize) -> bool {
        self.words_used() + 2 + len.div_ceil(4) <= self.receive_words as usize
    }

    fn push(&mut self, status: u32, endpoint: usize, data: &[u8]) {
        self.received.push_back(Entry {
            status,
            endpoint,
            data: data.to_vec(),
        });
    }

    /// A SETUP transaction: the device must take it.
    pub fn setup(&mut self, packet: [u8; 8]) -> Answer {
        if !self.has_room(packet.len()) {
            self.refused += 1;
            return Answer::Silence;
        }
        self.inputs[0].setup();
        self.outputs[0].setup();
        self.push(SETUP_DATA, 0, &packet);
        self.push(SETUP_DONE, 0, &[]);
        Answer::Ack
    }

    /// An OUT transaction.
    pub fn out(&mut self, endpoint: usize, data: &[u8], toggle: bool) -> Answer {
        if !self.has_room(data.len()) {
            self.refused += 1;
            return Answer::Nak;
        }
        let Some(output) = self.outputs.get_mut(endpoint) else {
            return Answer::Silence;
        };
        let (answer, is_new, is_done) = output.output(data.len(), toggle);
        if is_new {
            self.push(OUT_DATA, endpoint, data);
        }
        if is_done {
            self.push(OUT_DONE, endpoint, &[]);
        }
        answer
    }

    /// Whether an OUT transaction would be taken or stalled.
    pub fn is_out_ready(&self, endpoint: usize) -> bool {
        self.outputs[endpoint].is_out_ready() && self.has_room(64)
    }

    /// Whether an IN transaction would get data or a stall.
    pub fn is_in_ready(&self, endpoint: usize) -> bool {
        self.inputs[endpoint].is_in_ready()
    }

    /// An IN transaction; the host acknowledges the data.
    pub fn input(&mut self, endpoint: usize) -> Answer {
        match self.inputs.get_mut(endpoint) {
            Some(input) => input.input(),
            None => Answer::Silence,
        }
    }
}
