//! Flash that is a region of memory, for an emulated or a virtual board.
//!
//! It behaves as the flash of an STM32F405 does: it is programmed by words of four
//! bytes, which only clears bits, and erased by pages, which sets all.

use embedded_storage::nor_flash::{
    ErrorType, NorFlash, NorFlashErrorKind, ReadNorFlash, check_erase, check_read, check_write,
};

/// Bytes that are programmed at once.
const WORD: usize = 4;

/// Flash in `M`, with pages of `PAGE` bytes.
#[derive(Clone, Debug)]
pub struct Memory<M, const PAGE: usize>(pub M);

impl<M, const PAGE: usize> ErrorType for Memory<M, PAGE> {
    type Error = NorFlashErrorKind;
}

impl<M: AsMut<[u8]> + AsRef<[u8]>, const PAGE: usize> ReadNorFlash for Memory<M, PAGE> {
    const READ_SIZE: usize = 1;

    fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), NorFlashErrorKind> {
        check_read(self, offset, bytes.len())?;
        let from = self.0.as_ref().get(offset as usize..);
        let from = from.and_then(|from| from.get(..bytes.len()));
        bytes.copy_from_slice(from.ok_or(NorFlashErrorKind::OutOfBounds)?);
        Ok(())
    }

    fn capacity(&self) -> usize {
        self.0.as_ref().len()
    }
}

impl<M: AsMut<[u8]> + AsRef<[u8]>, const PAGE: usize> NorFlash for Memory<M, PAGE> {
    const WRITE_SIZE: usize = WORD;
    const ERASE_SIZE: usize = PAGE;

    fn erase(&mut self, from: u32, to: u32) -> Result<(), NorFlashErrorKind> {
        check_erase(self, from, to)?;
        let bytes = self.0.as_mut().get_mut(from as usize..to as usize);
        bytes.ok_or(NorFlashErrorKind::OutOfBounds)?.fill(0xFF);
        Ok(())
    }

    fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), NorFlashErrorKind> {
        check_write(self, offset, bytes.len())?;
        let to = self.0.as_mut().iter_mut().skip(offset as usize);
        to.zip(bytes).for_each(|(to, from)| *to &= *from);
        Ok(())
    }
}
