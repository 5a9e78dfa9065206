//! Settings memory: the two sectors of the chip's flash that follow the program's.
//!
//! They are of 128 kB each (section 3.3), and `memory.x` says where: in a chip of 1 MB sectors 10
//! and 11, in one of 512 kB sectors 6 and 7. Words of 32 bits are programmed at once, which
//! needs 2.7 V at least (section 3.6.2); boards have 3.3 V.
//!
//! While a sector is erased or a word programmed, a core that fetches from flash waits,
//! interrupt handlers included: 1 to 2 s and 16 µs (data sheet, flash memory
//! programming).
//!
//! At 168 MHz a read of flash takes six cycles. [`accelerate`] enables prefetch and caches,
//! which hide most of that. A write changes a cached word too; erasing does not (section
//! 3.5.4), so that the data cache is flushed after it.

use embassy_stm32::flash::{Blocking, Flash, MAX_ERASE_SIZE, READ_SIZE, WRITE_SIZE};
use embassy_stm32::peripherals::FLASH;
use embassy_stm32::{Peri, pac};
use embedded_storage::nor_flash::{
    ErrorType, NorFlash, NorFlashError, NorFlashErrorKind, ReadNorFlash, check_erase, check_read,
    check_write,
};

/// Length of both sectors.
const LEN: usize = 256 * 1_024;
const _: () = assert!(MAX_ERASE_SIZE == LEN / 2);

/// Offset of the first of them from the beginning of the flash.
fn first() -> u32 {
    unsafe extern "C" {
        static _settings_offset: u8;
    }
    (&raw const _settings_offset).addr() as u32
}

/// Enables prefetch, and the caches of instructions and data, empty.
pub fn accelerate() {
    flush();
    pac::FLASH.acr().modify(|w| w.set_prften(true));
}

/// Empties both caches, which must be off meanwhile (section 3.9.1), and enables them.
fn flush() {
    let acr = pac::FLASH.acr();
    acr.modify(|w| {
        w.set_icen(false);
        w.set_dcen(false);
    });
    acr.modify(|w| {
        w.set_icrst(true);
        w.set_dcrst(true);
    });
    acr.modify(|w| {
        w.set_icrst(false);
        w.set_dcrst(false);
    });
    acr.modify(|w| {
        w.set_icen(true);
        w.set_dcen(true);
    });
}

/// The two sectors.
pub struct Sectors(Flash<'static, Blocking>);

impl Sectors {
    /// Takes the flash.
    pub fn new(flash: Peri<'static, FLASH>) -> Self {
        Self(Flash::new_blocking(flash))
    }
}

impl ErrorType for Sectors {
    type Error = NorFlashErrorKind;
}

impl ReadNorFlash for Sectors {
    const READ_SIZE: usize = READ_SIZE;

    fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), NorFlashErrorKind> {
        check_read(self, offset, bytes.len())?;
        let result = self.0.blocking_read(first() + offset, bytes);
        result.map_err(|error| error.kind())
    }

    fn capacity(&self) -> usize {
        LEN
    }
}

impl NorFlash for Sectors {
    const WRITE_SIZE: usize = WRITE_SIZE;
    const ERASE_SIZE: usize = MAX_ERASE_SIZE;

    fn erase(&mut self, from: u32, to: u32) -> Result<(), NorFlashErrorKind> {
        check_erase(self, from, to)?;
        let result = self.0.blocking_erase(first() + from, first() + to);
        flush();
        result.map_err(|error| error.kind())
    }

    fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), NorFlashErrorKind> {
        check_write(self, offset, bytes.len())?;
        let result = self.0.blocking_write(first() + offset, bytes);
        result.map_err(|error| error.kind())
    }
}
