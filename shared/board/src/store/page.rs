//! One page of the flash: a log of records, kept by `sequential-storage`.
//!
//! The crate's queue with a single page frames records, finds the end of the log
//! and steps over what a power cut left half written. It must not
//! erase: it would after some kinds of damage, and erasing stalls the processor.
//! [`NoErase`] refuses that.

use super::record::{Bytes, HEADER, Kind, MAX, Record};
use core::pin::pin;
use core::task::{Context, Poll, Waker};
use embedded_storage::nor_flash::{ErrorType, NorFlash, NorFlashError, NorFlashErrorKind};
use embedded_storage_async::nor_flash as by_future;
use sequential_storage::Error;
use sequential_storage::cache::{Cache, Uncached};
use sequential_storage::queue::{QueueConfig, QueueStorage};

/// Failure of a flash operation.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum FlashError {
    /// The driver reports it.
    Driver(NorFlashErrorKind),
    /// There is no room for the record, but by erasing.
    Full,
    /// Written or erased bytes do not read back as expected.
    Mismatch,
}

impl NorFlashError for FlashError {
    fn kind(&self) -> NorFlashErrorKind {
        match self {
            Self::Driver(kind) => *kind,
            Self::Full | Self::Mismatch => NorFlashErrorKind::Other,
        }
    }
}

/// Flash for the storage crate: every operation completes at once, erasing is refused,
/// and the last word of the page reads as erased.
///
/// That word is where the crate marks a page that is full and was followed by
/// another. There is never another here, so a mark is damage; the crate would erase
/// the page, or not look at what is in it.
struct NoErase<'a, F> {
    flash: &'a mut F,
    last_word: u32,
}

impl<F> ErrorType for NoErase<'_, F> {
    type Error = FlashError;
}

impl<F: NorFlash> by_future::ReadNorFlash for NoErase<'_, F> {
    const READ_SIZE: usize = F::READ_SIZE;

    async fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), FlashError> {
        self.flash
            .read(offset, bytes)
            .map_err(|error| FlashError::Driver(error.kind()))?;
        let before = self.last_word.saturating_sub(offset) as usize;
        bytes.get_mut(before..).unwrap_or_default().fill(0xFF);
        Ok(())
    }

    fn capacity(&self) -> usize {
        self.flash.capacity()
    }
}

impl<F: NorFlash> by_future::NorFlash for NoErase<'_, F> {
    const WRITE_SIZE: usize = F::WRITE_SIZE;
    const ERASE_SIZE: usize = F::ERASE_SIZE;

    async fn erase(&mut self, _from: u32, _to: u32) -> Result<(), FlashError> {
        Err(FlashError::Full)
    }

    async fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), FlashError> {
        self.flash
            .write(offset, bytes)
            .map_err(|error| FlashError::Driver(error.kind()))
    }
}

/// Bytes of a page that are used at most: a save reads three times as many at most,
/// and a host that waits for its answer asks again after 25 ms.
const LOG_MAX: u32 = 16 * 1_024;

type Queue<'a, F> = QueueStorage<NoErase<'a, F>, Cache<Uncached, Uncached, Uncached>>;

impl From<Error<Self>> for FlashError {
    fn from(error: Error<Self>) -> Self {
        match error {
            Error::Storage { value, .. } => value,
            Error::FullStorage | Error::ItemTooBig => Self::Full,
            _ => Self::Mismatch,
        }
    }
}

/// The result of a future that never waits.
fn at_once<T>(
    future: impl Future<Output = Result<T, Error<FlashError>>>,
) -> Result<T, Error<FlashError>> {
    match pin!(future).poll(&mut Context::from_waker(Waker::noop())) {
        Poll::Ready(result) => result,
        Poll::Pending => Err(Error::Storage {
            value: FlashError::Driver(NorFlashErrorKind::Other),
        }),
    }
}

/// Contents of a page.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct PageScan {
    /// Whether the page is erased.
    pub(super) is_blank: bool,
    /// Bytes left for records, framing included; 0 if nothing can be appended.
    pub(super) room: u32,
    /// The highest generation that has a receipt.
    pub(super) receipt: Option<u32>,
    /// The highest generation of intact settings.
    pub(super) settings: Option<u32>,
}

impl PageScan {
    /// The highest generation of anything intact.
    pub(super) fn generation(&self) -> Option<u32> {
        self.receipt.max(self.settings)
    }

    /// Generation of the newest settings, unless newer ones are known to have been damaged.
    pub(super) fn in_force(&self) -> Option<u32> {
        self.settings
            .filter(|generation| Some(*generation) >= self.receipt)
    }

    fn take(&mut self, record: &Record<'_>) {
        let highest = match record.kind {
            Kind::Receipt => &mut self.receipt,
            Kind::Settings => &mut self.settings,
        };
        *highest = (*highest).max(Some(record.generation));
    }
}

/// One page.
#[derive(Debug)]
pub(super) struct Page<'a, F> {
    flash: &'a mut F,
    start: u32,
}

impl<'a, F: NorFlash> Page<'a, F> {
    const SIZE: u32 = F::ERASE_SIZE as u32;
    /// Word in bytes that the crate writes at once, and reserves at either end of a page.
    const WORD: u32 = if F::WRITE_SIZE > F::READ_SIZE {
        F::WRITE_SIZE as u32
    } else {
        F::READ_SIZE as u32
    };
    /// Used part of a page in bytes, from its start.
    const USED: u32 = if Self::SIZE > LOG_MAX {
        LOG_MAX
    } else {
        Self::SIZE
    };
    /// Bytes for records in an erased page.
    pub(super) const ROOM: u32 = Self::USED.saturating_sub(2 * Self::WORD);

    /// The page with this number, counting from 0.
    pub(super) fn new(flash: &'a mut F, number: u32) -> Self {
        let start = number * Self::SIZE;
        Self { flash, start }
    }

    fn end(&self) -> u32 {
        self.start + Self::SIZE
    }

    fn queue(&mut self) -> Result<Queue<'_, F>, FlashError> {
        let range = self.start..self.end();
        let last_word = range.end.saturating_sub(Self::WORD);
        if self.flash.capacity() < range.end as usize {
            return Err(FlashError::Driver(NorFlashErrorKind::OutOfBounds));
        }
        let config = QueueConfig::try_new(range)
            .map_err(|_| FlashError::Driver(NorFlashErrorKind::NotAligned))?;
        Ok(Queue::new(
            NoErase {
                last_word,
                flash: &mut *self.flash,
            },
            config,
            Cache::new_uncached(),
        ))
    }

    /// Bytes of a page that a record takes.
    pub(super) const fn cost(len: usize) -> u32 {
        Queue::<'_, F>::item_overhead_size() + (len as u32).next_multiple_of(Self::WORD)
    }

    /// Finds what is in the page.
    pub(super) fn scan(&mut self) -> Result<PageScan, FlashError> {
        let mut scan = PageScan::default();
        if self.is_erased_from(self.start)? {
            scan.is_blank = true;
            scan.room = Self::ROOM;
            return Ok(scan);
        }
        let is_complete = self.visit(&mut |bytes| {
            if let Some(record) = Record::read(bytes) {
                scan.take(&record);
            }
        })?;
        if !is_complete {
            return Ok(scan);
        }
        let space = at_once(self.queue()?.space_left())?;
        let room = space
            .saturating_sub(Self::SIZE - Self::USED)
            .min(Self::ROOM);
        let used = Self::USED.saturating_sub(room + Self::WORD);
        if self.is_erased_from(self.start + used)? {
            scan.room = room;
        }
        Ok(scan)
    }

    /// The record with the settings of this generation: of equals the last.
    pub(super) fn settings(&mut self, generation: u32) -> Result<Bytes, FlashError> {
        let mut found = Bytes::new();
        self.visit(&mut |bytes| {
            let record = Record::read(bytes);
            if record.is_some_and(|r| r.kind == Kind::Settings && r.generation == generation) {
                found.clear();
                // As long as the longest that is read.
                let _ = found.extend_from_slice(bytes);
            }
        })?;
        Ok(found)
    }

    /// Whether the page has this record: of those with the same header the last.
    pub(super) fn holds(&mut self, record: &[u8]) -> Result<bool, FlashError> {
        let mut is_held = false;
        self.visit(&mut |bytes| {
            if bytes.get(..HEADER) == record.get(..HEADER) {
                is_held = bytes == record;
            }
        })?;
        Ok(is_held)
    }

    /// Reads the records in their order; false if there is one longer than any, after which no
    /// other can be found.
    #[inline(never)]
    fn visit(&mut self, take: &mut dyn FnMut(&[u8])) -> Result<bool, FlashError> {
        let mut buffer = [0; MAX];
        let mut queue = self.queue()?;
        let mut records = at_once(queue.iter())?;
        loop {
            match at_once(records.next(&mut buffer)) {
                Ok(Some(bytes)) => take(&bytes),
                Ok(None) => return Ok(true),
                Err(Error::Storage { value, .. }) => return Err(value),
                Err(_) => return Ok(false),
            }
        }
    }

    /// Appends a record.
    pub(super) fn append(&mut self, record: &[u8]) -> Result<(), FlashError> {
        Ok(at_once(self.queue()?.push(record, false))?)
    }

    /// Erases the page.
    pub(super) fn erase(&mut self) -> Result<(), FlashError> {
        self.flash
            .erase(self.start, self.end())
            .map_err(|error| FlashError::Driver(error.kind()))?;
        if self.is_erased_from(self.start)? {
            Ok(())
        } else {
            Err(FlashError::Mismatch)
        }
    }

    /// Whether nothing is written in what is used of the page, from here on.
    fn is_erased_from(&mut self, mut at: u32) -> Result<bool, FlashError> {
        // A multiple of every word size the crate supports.
        let mut chunk = [0; 32];
        let end = self.start + Self::USED;
        while at < end {
            let len = chunk.len().min((end - at) as usize);
            let bytes = chunk.get_mut(..len).unwrap_or_default();
            self.flash
                .read(at, bytes)
                .map_err(|error| FlashError::Driver(error.kind()))?;
            if bytes.iter().any(|byte| *byte != 0xFF) {
                return Ok(false);
            }
            at += len as u32;
        }
        Ok(true)
    }
}
