//! As much of QEMU's machine `mps2-an386` as the image `instructions` uses: memory, the timer
//! that is its clock, and semihosting. Time is a nanosecond an instruction.

use armbridge_stm32_emulator::core::{Build, Core, Step};
use armbridge_stm32_emulator::memory::{BusError, Memory, Width};

use crate::elf;

const CODE: usize = 0x40_0000;
const DATA_BEGIN: u32 = 0x2000_0000;
const DATA: usize = 0x40_0000;
const TIMER0: u32 = 0x4000_0000;
/// The timer counts at 25 MHz.
const TIMER_PERIOD_NS: u64 = 40;

/// Memory and devices.
#[derive(Clone)]
pub(crate) struct Bus {
    code: Vec<u8>,
    data: Vec<u8>,
    timer: Timer,
    pub(crate) now_ns: u64,
    /// Output of the image.
    pub(crate) printed: Vec<u8>,
}

/// A CMSDK timer, as far as it is a clock.
#[derive(Clone, Default)]
struct Timer {
    control: u32,
    reload: u32,
    begun_ns: u64,
}

impl Timer {
    fn read(&self, offset: u32, now_ns: u64) -> u32 {
        match offset {
            0 => self.control,
            4 if self.control & 1 != 0 => {
                let elapsed_ns = now_ns - self.begun_ns;
                self.reload
                    .wrapping_sub((elapsed_ns / TIMER_PERIOD_NS) as u32)
            }
            8 => self.reload,
            _ => 0,
        }
    }

    fn write(&mut self, offset: u32, value: u32, now_ns: u64) {
        match offset {
            0 => {
                self.control = value & 0xF;
                self.begun_ns = now_ns;
            }
            8 => {
                self.reload = value;
                self.begun_ns = now_ns;
            }
            _ => {}
        }
    }
}

impl Bus {
    /// Memory without contents.
    pub(crate) fn new() -> Self {
        Self {
            code: vec![0; CODE],
            data: vec![0; DATA],
            timer: Timer::default(),
            now_ns: 0,
            printed: Vec::new(),
        }
    }

    fn slice(&mut self, address: u32, length: usize) -> Result<&mut [u8], BusError> {
        let (memory, begin) = if address < DATA_BEGIN {
            (&mut self.code, 0)
        } else {
            (&mut self.data, DATA_BEGIN)
        };
        let start = (address - begin) as usize;
        memory.get_mut(start..start + length).ok_or(BusError)
    }

    /// Bytes of memory.
    pub(crate) fn bytes(&mut self, address: u32, length: u32) -> Vec<u8> {
        self.slice(address, length as usize).unwrap().to_vec()
    }

    fn word(&mut self, address: u32) -> u32 {
        self.read(address, Width::Word).unwrap()
    }
}

impl Memory for Bus {
    #[inline]
    fn read(&mut self, address: u32, width: Width) -> Result<u32, BusError> {
        if address & 0xFFFF_FF00 == TIMER0 {
            return Ok(self.timer.read(address & 0xFF, self.now_ns));
        }
        match width {
            Width::Byte => self.slice(address, 1).map(|bytes| u32::from(bytes[0])),
            Width::Half => {
                let bytes = self.slice(address, 2)?;
                Ok(u32::from(u16::from_le_bytes([bytes[0], bytes[1]])))
            }
            Width::Word => {
                let bytes = self.slice(address, 4)?;
                Ok(u32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]]))
            }
        }
    }

    #[inline]
    fn write(&mut self, address: u32, width: Width, value: u32) -> Result<(), BusError> {
        if address & 0xFFFF_FF00 == TIMER0 {
            self.timer.write(address & 0xFF, value, self.now_ns);
            return Ok(());
        }
        let bytes = value.to_le_bytes();
        match width {
            Width::Byte => self.slice(address, 1)?[0] = bytes[0],
            Width::Half => self.slice(address, 2)?.copy_from_slice(&bytes[..2]),
            Width::Word => self.slice(address, 4)?.copy_from_slice(&bytes),
        }
        Ok(())
    }

    fn fetch(&mut self, address: u32) -> Result<u16, BusError> {
        self.read(address, Width::Half).map(|half| half as u16)
    }

    #[inline]
    fn executes(&mut self, _address: u32, _halfwords: u32) {
        self.now_ns += 1;
    }
}

/// A machine with an image in it, after a reset.
pub(crate) fn machine(image: &[u8]) -> (Core, Bus) {
    let mut bus = Bus::new();
    for (address, bytes) in elf::parts(image) {
        let place = bus.slice(address, bytes.len()).unwrap();
        place.copy_from_slice(bytes);
    }
    let mut core = core(CODE);
    core.reset(&mut bus).unwrap();
    (core, bus)
}

/// The machine's processor before a reset, which keeps so many bytes of code decoded.
pub(crate) fn core(kept: usize) -> Core {
    Core::new(Build {
        interrupts: 32,
        priority_bits: 8,
        vectors: 0,
        code: 0..kept as u32,
        debugger: true,
        bit_band: false,
    })
}

/// A semihosting call: its exit code if the image ends with it.
pub(crate) fn semihosting(core: &mut Core, bus: &mut Bus) -> Option<u32> {
    const OPEN: u32 = 0x01;
    const WRITE: u32 = 0x05;
    const EXIT_EXTENDED: u32 = 0x20;
    let block = core.register(1);
    let result = match core.register(0) {
        OPEN => 1,
        WRITE => {
            let (text, length) = (bus.word(block + 4), bus.word(block + 8));
            let text = bus.bytes(text, length);
            bus.printed.extend(text);
            0
        }
        EXIT_EXTENDED => return Some(bus.word(block + 4)),
        other => panic!("no semihosting call {other:#x}"),
    };
    core.set_register(0, result);
    None
}

/// Runs the image to its end; its exit code.
pub(crate) fn run(core: &mut Core, bus: &mut Bus) -> u32 {
    loop {
        match core.step(bus) {
            Step::Executed { .. } | Step::Entered { .. } => {}
            Step::Breakpoint(0xAB) => {
                if let Some(code) = semihosting(core, bus) {
                    return code;
                }
            }
            other => panic!("{other:?} at {:#x}", core.register(15)),
        }
    }
}
