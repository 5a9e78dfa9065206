//! The servo bus on a USART with a direction pin, by DMA both ways.
//!
//! A tick with two Morpheus servos has four interrupts of the USART: two ends of transmissions,
//! and two idle lines after the replies.
//!
//! # Sending
//!
//! The bytes are copied into a buffer of the driver's own, and a DMA stream feeds the
//! transmitter (section 30.3.13). Its end is TC, not the end of the stream: the last stop bit
//! has left (section 30.3.2). That interrupt lowers the direction pin, in its first some
//! 20 instructions, whatever the tick does meanwhile; a servo may speak 45 µs later. TC can
//! only come early if the stream is late by a byte, which then is not at its end: it goes on.
//!
//! # Receiving
//!
//! A circular stream writes all that is received into a ring, for ever. Nothing is lost between
//! two exchanges or while the core is busy, but by a lap of the ring: [`RX_LEN`] bytes are
//! 2.5 ms at 2 Mbaud and 1.3 ms at 4, and in an exchange the tick reads it once a millisecond. The
//! tick is woken by an idle line, 10 bits after the last stop bit, if as many bytes as it waits for
//! are there; or by an error.
//!
//! | flag (section 30.6.1) | the byte          | reported                                      |
//! |------|--------------------|-------------------------------------------------------------|
//! | FE   | damaged            | in its place; the byte before is dropped too                |
//! | ORE  | is intact, the next is lost | after it                                           |
//! | NF   | three samples of a bit disagreed, and were voted upon | not: the packet's checksum decides |
//!
//! An error is placed by the position of the stream when its interrupt runs. Dropping two bytes
//! makes that certain if interrupts are masked for less than a byte, 10 µs at 1 Mbaud and 2.5 at 4;
//! beyond, the checksum is left. All flags are cleared by a read of SR and one of DR, which
//! takes no byte from the stream: it waits until that has emptied the register.

use super::baud::{baud_max, set_divider};
use super::clock::Clock;
use super::wiring::Wiring;
use crate::crash::memory;
use armbridge_servo::bus::{Bus, LineAfter, Received, SEND_MAX, Transmission};
use core::marker::PhantomData;
use core::sync::atomic::{AtomicBool, AtomicU8, AtomicU32, Ordering};
use embassy_stm32::pac::dma::vals::{Dir, Pl};
use embassy_stm32::pac::usart::Usart;
use embassy_stm32::pac::usart::regs::{Cr1, Cr3Usart, Sr};
use embedded_hal_nb::serial::ErrorKind;

/// Bytes of the ring; a power of two.
pub const RX_LEN: usize = 512;
const _: () = assert!(RX_LEN.is_power_of_two() && RX_LEN <= 1 << 14);
/// Bytes passed on at once: more than two replies.
const CHUNK: usize = 32;
/// Time in µs from the request of a transmission to its first start bit beyond what the
/// clock shows: its fraction, and a bit at 1 Mbaud, on whose grid the transmitter begins.
const START_US: u32 = 2;
/// Bytes before the position of the stream that a framing error may have damaged.
const DAMAGED: u32 = 2;

/// Error to be reported: flag, kind, and the ends of the damaged bytes in the ring.
const HAS_ERROR: u32 = 1 << 31;
const IS_OVERRUN: u32 = 1 << 30;

/// CR1 while nothing is sent: 8N1, with the interrupt of an idle line. The samples of a bit are as
/// the baud rate has set them.
fn idle_cr1(usart: Usart) -> Cr1 {
    let mut cr1 = Cr1(0);
    cr1.set_over8(usart.cr1().read().over8());
    cr1.set_ue(true);
    cr1.set_te(true);
    cr1.set_re(true);
    cr1.set_idleie(true);
    cr1
}

/// The port, shared by its interrupt handler and the tick.
///
/// Both buffers are of atomic bytes, which DMA may read and write at any time.
pub struct HalfDuplex<W> {
    wiring: PhantomData<W>,
    rx: [AtomicU8; RX_LEN],
    tx: [AtomicU8; SEND_MAX],
    /// From [`Bus::send`] to TC.
    is_sending: AtomicBool,
    /// Whether TC releases the line.
    releases: AtomicBool,
    /// Index of the next byte to read, written by the tick alone.
    read: AtomicU32,
    /// Number of unread bytes that wakes the tick; 0 for none.
    wanted: AtomicU32,
    error: AtomicU32,
}

impl<W: Wiring> HalfDuplex<W> {
    /// A port that has not been started.
    pub const fn new() -> Self {
        Self {
            wiring: PhantomData,
            rx: [const { AtomicU8::new(0) }; RX_LEN],
            tx: [const { AtomicU8::new(0) }; SEND_MAX],
            is_sending: AtomicBool::new(false),
            releases: AtomicBool::new(false),
            read: AtomicU32::new(0),
            wanted: AtomicU32::new(0),
            error: AtomicU32::new(0),
        }
    }

    /// Starts the port, whose clocks, pins and speed are set up.
    pub fn start(&'static self) {
        let (usart, rx, tx) = (W::USART, W::RX, W::TX);
        for (stream, buffer) in [(rx, self.rx.as_ptr()), (tx, self.tx.as_ptr())] {
            stream.stop();
            stream.clear();
            let registers = stream.registers();
            registers.par().write_value(usart.dr().as_ptr() as u32);
            registers.m0ar().write_value(buffer as u32);
        }
        rx.registers().ndtr().write(|w| w.set_ndt(RX_LEN as u16));
        rx.registers().cr().write(|w| {
            w.set_chsel(rx.channel);
            w.set_dir(Dir::PERIPHERAL_TO_MEMORY);
            w.set_minc(true);
            w.set_circ(true);
            w.set_pl(Pl::HIGH);
            w.set_en(true);
        });
        let mut cr3 = Cr3Usart(0);
        cr3.set_dmar(true);
        cr3.set_dmat(true);
        // Errors are interrupts while DMA receives.
        cr3.set_eie(true);
        usart.cr3().write_value(cr3);
        usart.cr1().write_value(idle_cr1(usart));
    }

    /// Handles the USART's interrupt; whether the tick is to be woken.
    pub fn on_interrupt(&self) -> bool {
        let usart = W::USART;
        let status = usart.sr().read();
        if status.tc() && self.is_sending.load(Ordering::Relaxed) {
            if W::TX.registers().ndtr().read().ndt() == 0 {
                if self.releases.load(Ordering::Relaxed) {
                    W::DIRECTION.set(false);
                }
                usart.cr1().modify(|w| w.set_tcie(false));
                self.is_sending.store(false, Ordering::Relaxed);
            } else {
                Self::clear_tc();
            }
        }
        let has_error = status.fe() || status.ore();
        if !(has_error || status.idle() || status.ne()) {
            return false;
        }
        // At most a few cycles: the stream reads what is there before anything else.
        for _ in 0..16 {
            if !usart.sr().read().rxne() {
                break;
            }
        }
        let _ = usart.dr().read();
        if has_error {
            self.note_error(status);
        }
        let wanted = self.wanted.load(Ordering::Relaxed);
        wanted > 0 && (has_error || self.unread() >= wanted)
    }

    /// Notes an error at the present position; several until the tick reads are one.
    fn note_error(&self, status: Sr) {
        let end = Self::written();
        let before = self.error.load(Ordering::Relaxed);
        let kind = if status.fe() { 0 } else { IS_OVERRUN };
        let damaged = if status.fe() { DAMAGED } else { 0 };
        let begin = if before == 0 {
            // Bytes that have been read were intact.
            wrap(end.wrapping_sub(damaged.min(self.unread())))
        } else {
            before >> 15 & 0x7FFF
        };
        self.error
            .store(HAS_ERROR | kind | begin << 15 | end, Ordering::Relaxed);
    }

    /// Sets the number of unread bytes that wakes the tick; true if they are there already, or
    /// an error is.
    pub fn wake_after(&self, bytes: Option<usize>) -> bool {
        let wanted = bytes.map_or(0, |bytes| bytes.clamp(1, RX_LEN - 1) as u32);
        self.wanted.store(wanted, Ordering::Relaxed);
        // The flag of an idle line that came before this is gone.
        wanted > 0 && (self.unread() >= wanted || self.error.load(Ordering::Relaxed) != 0)
    }

    /// Index that the stream writes next.
    fn written() -> u32 {
        let left = W::RX.registers().ndtr().read().ndt();
        wrap((RX_LEN as u32).wrapping_sub(left.into()))
    }

    fn unread(&self) -> u32 {
        wrap(Self::written().wrapping_sub(self.read.load(Ordering::Relaxed)))
    }

    /// TC is cleared by 0; the other flags ignore a 1 (section 30.6.1).
    fn clear_tc() {
        W::USART.sr().write(|w| {
            w.0 = u32::MAX;
            w.set_tc(false);
        });
    }

    fn send(&self, bytes: &[u8], after: LineAfter) {
        W::DIRECTION.set(true);
        let mut count = 0;
        for (cell, byte) in self.tx.iter().zip(bytes) {
            cell.store(*byte, Ordering::Relaxed);
            count += 1;
        }
        self.releases
            .store(after == LineAfter::Released, Ordering::Relaxed);
        let tx = W::TX;
        tx.clear();
        Self::clear_tc();
        tx.registers().ndtr().write(|w| w.set_ndt(count));
        // Release: the bytes are in memory before the stream is started.
        self.is_sending.store(count > 0, Ordering::Release);
        tx.registers().cr().write(|w| {
            w.set_chsel(tx.channel);
            w.set_dir(Dir::MEMORY_TO_PERIPHERAL);
            w.set_minc(true);
            w.set_en(true);
        });
        // The handler changes it only at the end of a transmission, and there is none before.
        W::USART.cr1().modify(|w| w.set_tcie(count > 0));
    }
}

impl<W: Wiring> Default for HalfDuplex<W> {
    fn default() -> Self {
        Self::new()
    }
}

/// Index in the ring.
const fn wrap(index: u32) -> u32 {
    index % RX_LEN as u32
}

/// The tick's end of a port.
pub struct HalfDuplexBus<W: Wiring> {
    port: &'static HalfDuplex<W>,
    clock: &'static Clock,
    received: [u8; CHUNK],
    send_delay_us: u32,
}

impl<W: Wiring> HalfDuplexBus<W> {
    /// The bus on a port that has been started. `clock` is the one that the tick is
    /// called with.
    pub const fn new(port: &'static HalfDuplex<W>, clock: &'static Clock) -> Self {
        Self {
            port,
            clock,
            received: [0; CHUNK],
            send_delay_us: 0,
        }
    }
}

impl<W: Wiring> Bus for HalfDuplexBus<W> {
    const RELEASES_BY_ITSELF: bool = true;
    const BAUD_MAX: u32 = baud_max(W::USART_MHZ);

    /// Keeps it for the stop sequence after a reset, too.
    fn set_baud(&mut self, baud: u32) {
        memory::set_baud(baud);
        set_divider(W::USART, W::USART_MHZ, baud);
    }

    fn send(&mut self, bytes: &[u8], after: LineAfter) {
        self.port.send(bytes, after);
        self.send_delay_us = self.clock.since_read_us() + START_US;
    }

    fn send_delay_us(&self) -> u32 {
        self.send_delay_us
    }

    fn transmission(&mut self) -> Transmission {
        if self.port.is_sending.load(Ordering::Relaxed) {
            Transmission::Sending
        } else {
            Transmission::Complete
        }
    }

    fn release(&mut self) {
        W::DIRECTION.set(false);
    }

    fn received(&mut self) -> Received<'_> {
        // In this order: an error of a byte before `end` has been noted.
        let end = HalfDuplex::<W>::written();
        let mut read = self.port.read.load(Ordering::Relaxed);
        let mut error = None;
        let noted = self.port.error.load(Ordering::Relaxed);
        let end = if noted == 0 {
            end
        } else {
            noted >> 15 & 0x7FFF
        };
        if read == end && noted == 0 {
            return Received::default();
        }
        // Up to the end of the ring, the rest in the next call.
        let run_end = if read <= end { end } else { RX_LEN as u32 };
        let run = self.port.rx.get(read as usize..run_end as usize);
        let run = run.unwrap_or_default();
        for (byte, cell) in self.received.iter_mut().zip(run) {
            *byte = cell.load(Ordering::Relaxed);
        }
        let count = run.len().min(CHUNK);
        read = wrap(read + count as u32);
        if noted != 0 && read == end {
            // The handler may have added to it meanwhile.
            let noted = self.port.error.swap(0, Ordering::Relaxed);
            read = wrap(noted & 0x7FFF);
            error = Some(if noted & IS_OVERRUN == 0 {
                ErrorKind::FrameFormat
            } else {
                ErrorKind::Overrun
            });
        }
        self.port.read.store(read, Ordering::Relaxed);
        Received {
            bytes: self.received.get(..count).unwrap_or_default(),
            error,
        }
    }
}
