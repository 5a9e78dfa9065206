//! A small board for tests: flash, SRAM, nothing else; programs are halfwords.

use std::ops::{Deref, DerefMut};

use armbridge_stm32_emulator::core::{Build, Core, Start, Step};
use armbridge_stm32_emulator::memory::{BusError, Memory, Width};

pub(crate) const FLASH: u32 = 0x0800_0000;
pub(crate) const SRAM: u32 = 0x2000_0000;
const SIZE: usize = 0x8000;
/// Where the main program begins.
pub(crate) const PROGRAM: u32 = FLASH + 0x1000;
/// Its stack.
pub(crate) const STACK: u32 = SRAM + 0x4000;

/// Flash and SRAM.
pub(crate) struct Chip {
    flash: Vec<u8>,
    sram: Vec<u8>,
}

impl Chip {
    fn slice(&mut self, address: u32, length: usize) -> Result<&mut [u8], BusError> {
        let (memory, begin) = match address >> 28 {
            0 => (&mut self.flash, FLASH),
            2 => (&mut self.sram, SRAM),
            _ => return Err(BusError),
        };
        let start = address.checked_sub(begin).ok_or(BusError)? as usize;
        memory.get_mut(start..start + length).ok_or(BusError)
    }
}

fn bytes(width: Width) -> usize {
    match width {
        Width::Byte => 1,
        Width::Half => 2,
        Width::Word => 4,
    }
}

impl Memory for Chip {
    fn read(&mut self, address: u32, width: Width) -> Result<u32, BusError> {
        let bytes = self.slice(address, bytes(width))?;
        Ok(bytes
            .iter()
            .rev()
            .fold(0, |value, byte| value << 8 | u32::from(*byte)))
    }

    fn write(&mut self, address: u32, width: Width, value: u32) -> Result<(), BusError> {
        let length = bytes(width);
        let place = self.slice(address, length)?;
        place.copy_from_slice(&value.to_le_bytes()[..length]);
        Ok(())
    }

    fn fetch(&mut self, address: u32) -> Result<u16, BusError> {
        self.read(address, Width::Half).map(|half| half as u16)
    }
}

/// A processor with its memory.
pub(crate) struct Board {
    pub(crate) core: Core,
    pub(crate) chip: Chip,
}

impl Deref for Board {
    type Target = Core;

    fn deref(&self) -> &Core {
        &self.core
    }
}

impl DerefMut for Board {
    fn deref_mut(&mut self) -> &mut Core {
        &mut self.core
    }
}

/// Address of an exception's handler.
pub(crate) fn handler(exception: u16) -> u32 {
    FLASH + 0x2000 + u32::from(exception) * 0x40
}

impl Board {
    /// A board with a program, at its first instruction, and the floating-point unit enabled.
    /// Handlers return at once: BX lr.
    pub(crate) fn new(program: &[u16]) -> Self {
        let mut chip = Chip {
            flash: vec![0; SIZE],
            sram: vec![0; SIZE],
        };
        let mut words: Vec<u32> = vec![STACK, PROGRAM | 1];
        words.extend((2..98).map(|exception| handler(exception) | 1));
        for (place, word) in (0..).zip(words) {
            chip.write(FLASH + place * 4, Width::Word, word).unwrap();
        }
        let mut core = Core::new(Build {
            interrupts: 82,
            priority_bits: 4,
            vectors: FLASH,
            code: FLASH..FLASH + SIZE as u32,
            debugger: false,
            bit_band: true,
        });
        core.reset(&mut chip).unwrap();
        core.set_system_register(0xE000_ED88, 0x00F0_0000);
        let mut board = Self { core, chip };
        board.code(PROGRAM, program);
        for exception in 2..98 {
            board.code(handler(exception), &[0x4770]);
        }
        board
    }

    /// Writes instructions, and B to itself behind them.
    pub(crate) fn code(&mut self, address: u32, code: &[u16]) {
        for (place, half) in (0..).zip(code.iter().chain(&[0xE7FE])) {
            let half = u32::from(*half);
            self.chip
                .write(address + place * 2, Width::Half, half)
                .unwrap();
        }
        self.core.invalidate();
    }

    /// Starts at an address.
    pub(crate) fn start(&mut self, pc: u32) {
        self.core.start_at(Start {
            sp: STACK,
            pc,
            vtor: FLASH,
            primask: false,
        });
    }

    pub(crate) fn step(&mut self) -> Step {
        self.core.step(&mut self.chip)
    }

    /// Executes so many instructions, without exceptions.
    pub(crate) fn execute(&mut self, count: usize) {
        for _ in 0..count {
            let step = self.step();
            let pc = self.register(15);
            assert!(matches!(step, Step::Executed { .. }), "{step:?}, {pc:#x}");
        }
    }

    /// The next step enters this exception, at its handler.
    #[track_caller]
    pub(crate) fn enters(&mut self, exception: u16) {
        let step = self.step();
        assert!(
            matches!(step, Step::Entered { exception: entered, .. } if entered == exception),
            "{step:?}"
        );
        assert_eq!(self.register(15), handler(exception));
        assert_eq!(self.exception(), exception);
    }

    pub(crate) fn word(&mut self, address: u32) -> u32 {
        self.chip.read(address, Width::Word).unwrap()
    }

    pub(crate) fn set_word(&mut self, address: u32, value: u32) {
        self.chip.write(address, Width::Word, value).unwrap();
    }
}
