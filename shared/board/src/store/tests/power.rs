//! Flash whose steps are written down, and what is in it when power goes in one.

extern crate std;

use super::{Flash, PAGE, Random};
use embedded_storage::nor_flash::{ErrorType, NorFlash, NorFlashErrorKind, ReadNorFlash};
use std::vec;
use std::vec::Vec;

/// Flash operation in which power can be cut.
#[derive(Clone, Copy, Debug)]
pub(super) enum Step {
    Word(usize, [u8; 4]),
    Erase(usize),
}

/// Writes down each step, and takes it.
pub(super) struct Traced {
    pub(super) flash: Flash,
    pub(super) steps: Vec<Step>,
}

impl Traced {
    pub(super) fn new(flash: Flash) -> Self {
        let steps = Vec::new();
        Self { flash, steps }
    }
}

impl ErrorType for Traced {
    type Error = NorFlashErrorKind;
}

impl ReadNorFlash for Traced {
    const READ_SIZE: usize = 1;

    fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), NorFlashErrorKind> {
        self.flash.read(offset, bytes)
    }

    fn capacity(&self) -> usize {
        self.flash.capacity()
    }
}

impl NorFlash for Traced {
    const WRITE_SIZE: usize = 4;
    const ERASE_SIZE: usize = PAGE;

    fn erase(&mut self, from: u32, to: u32) -> Result<(), NorFlashErrorKind> {
        assert_eq!(to - from, PAGE as u32, "page by page");
        self.steps.push(Step::Erase(from as usize));
        self.flash.erase(from, to)
    }

    fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), NorFlashErrorKind> {
        self.flash.write(offset, bytes)?;
        for (i, word) in bytes.chunks(4).enumerate() {
            let word = word.try_into().expect("whole words");
            self.steps.push(Step::Word(offset as usize + 4 * i, word));
        }
        Ok(())
    }
}

pub(super) fn take(flash: &mut Flash, step: Step) {
    match step {
        Step::Word(at, word) => flash.write(at as u32, &word).unwrap(),
        Step::Erase(at) => flash.erase(at as u32, (at + PAGE) as u32).unwrap(),
    }
}

/// The flash when power went while this step was taken, several times: it may not
/// have begun, be half done, or have left anything at all.
pub(super) fn cut(flash: &Flash, step: Step, random: &mut Random) -> Vec<Flash> {
    let mut cuts = vec![flash.clone()];
    match step {
        Step::Word(at, word) => {
            for len in 1..4 {
                let mut bytes = flash.clone();
                let cells = bytes.0[at..at + len].iter_mut();
                cells.zip(word).for_each(|(cell, byte)| *cell &= byte);
                cuts.push(bytes);
            }
            let mut bytes = flash.clone();
            let cells = bytes.0[at..at + 4].iter_mut();
            cells
                .zip(word)
                .for_each(|(cell, byte)| *cell &= byte | random.byte());
            cuts.push(bytes.clone());
            bytes.0[at..at + 4].fill_with(|| random.byte());
            cuts.push(bytes);
        }
        Step::Erase(at) => {
            let parts = [
                0..PAGE / 2,
                PAGE / 2..PAGE,
                4..PAGE - 4,
                0..4,
                PAGE - 4..PAGE,
            ];
            for part in parts {
                let mut bytes = flash.clone();
                bytes.0[at + part.start..at + part.end].fill(0xFF);
                cuts.push(bytes);
            }
            for _ in 0..4 {
                let mut bytes = flash.clone();
                for cell in &mut bytes.0[at..at + PAGE] {
                    *cell |= random.byte() & random.byte();
                }
                cuts.push(bytes.clone());
                bytes.0[at..at + PAGE].fill_with(|| random.byte());
                cuts.push(bytes);
            }
        }
    }
    cuts
}
