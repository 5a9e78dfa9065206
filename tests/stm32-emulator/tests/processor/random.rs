//! Random instructions with operands at the edges, compared with QEMU's trace.
//!
//! A program is made while the emulator executes it: an instruction that would branch, fault or
//! reach beyond the data is not taken. Then QEMU executes it too. The seeds are constant.

use armbridge_stm32_emulator::core::{Core, Step};
use armbridge_stm32_emulator::memory::{BusError, Memory, Width};

use crate::mps2::{self, Bus};
use crate::{elf, qemu, trace};

const CODE: u32 = 0x100;
const HANDLER: u32 = 0x80;
const DATA: std::ops::Range<u32> = 0x2000_1000..0x2000_3000;
const STACK: u32 = 0x2000_8000;

/// Xorshift, 64 bits.
pub(crate) struct Random(pub(crate) u64);

impl Random {
    pub(crate) fn next(&mut self) -> u32 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 16) as u32
    }

    pub(crate) fn below(&mut self, limit: u32) -> u32 {
        self.next() % limit
    }

    fn of(&mut self, values: &[u32]) -> u32 {
        values[self.below(values.len() as u32) as usize]
    }
}

/// Integers and single-precision numbers at which something changes.
const EDGES: [u32; 44] = [
    0,
    1,
    2,
    31,
    32,
    33,
    0x7F,
    0x80,
    0xFF,
    0x100,
    0x7FFF,
    0x8000,
    0xFFFF,
    0x1_0000,
    0x7FFF_FFFF,
    0x8000_0000,
    0x8000_0001,
    0xFFFF_FFFF,
    0xFFFF_8000,
    0x8080_8080,
    0x7F7F_7F7F,
    0x8000_7FFF,
    // One, a half, three halves, five halves, their negatives.
    0x3F80_0000,
    0x3F00_0000,
    0x3FC0_0000,
    0x4020_0000,
    0xBF80_0000,
    0xBF00_0000,
    0xC020_0000,
    // Infinities, NaNs, the least and greatest numbers.
    0x7F80_0000,
    0xFF80_0000,
    0x7FC0_0000,
    0xFFC1_2345,
    0x7F80_0001,
    0xFFA0_0000,
    0x0000_0001,
    0x807F_FFFF,
    0x0080_0000,
    0x7F7F_FFFF,
    0x0080_0001,
    // 2^31, -2^31, 2^32, and a number behind 2^31.
    0x4F00_0000,
    0xCF00_0000,
    0x4F80_0000,
    0x4EFF_FFFF,
];

/// Fixed bits and their values of the groups of 32-bit instructions, first halfword on top.
const GROUPS: [(u32, u32); 17] = [
    // Data processing: modified and plain immediates, shifted registers.
    (0xFA00_8000, 0xF000_0000),
    (0xFA00_8000, 0xF200_0000),
    (0xFE00_8000, 0xEA00_0000),
    // Registers, multiplication, long multiplication.
    (0xFF00_F000, 0xFA00_F000),
    (0xFF80_00C0, 0xFB00_0000),
    (0xFF80_F0C0, 0xFB00_F000),
    (0xFF80_0000, 0xFB80_0000),
    // Single accesses on the base 8: immediates of 12 and 8 bits.
    (0xFE8F_0000, 0xF888_0000),
    (0xFE8F_0800, 0xF808_0800),
    // Pairs, several.
    (0xFE4F_0000, 0xE848_0000),
    (0xFE4F_2000, 0xE808_0000),
    // Floating point: data (twice, for there is much), accesses, transfers.
    (0xFF00_0F10, 0xEE00_0A00),
    (0xFFB0_0F50, 0xEEB0_0A40),
    (0xFE0F_0E00, 0xEC08_0A00),
    (0xFF00_0F7F, 0xEE00_0A10),
    (0xFFE0_0EC0, 0xEC40_0A00),
    // Special registers, hints, barriers.
    (0xFFE0_D000, 0xF3A0_8000),
];

/// Memory of which only the data may be accessed; says what was not.
struct Guarded<'a> {
    bus: &'a mut Bus,
    failed: bool,
    written: Vec<(u32, u32)>,
}

impl Guarded<'_> {
    fn check(&mut self, address: u32) -> Result<(), BusError> {
        if DATA.contains(&address) && DATA.contains(&(address + 3)) {
            return Ok(());
        }
        self.failed = true;
        Err(BusError)
    }
}

impl Memory for Guarded<'_> {
    fn read(&mut self, address: u32, width: Width) -> Result<u32, BusError> {
        self.check(address)?;
        self.bus.read(address, width)
    }

    fn write(&mut self, address: u32, width: Width, value: u32) -> Result<(), BusError> {
        self.check(address)?;
        let old = self.bus.read(address, Width::Word)?;
        self.written.push((address, old));
        self.bus.write(address, width, value)
    }

    fn fetch(&mut self, address: u32) -> Result<u16, BusError> {
        self.bus.fetch(address)
    }
}

/// A program, and the processor that has executed it.
struct Program {
    core: Core,
    bus: Bus,
    end: u32,
    /// Instructions that QEMU shows.
    shown: usize,
}

impl Program {
    fn new() -> Self {
        let mut bus = Bus::new();
        let mut word = |address, value| bus.write(address, Width::Word, value).unwrap();
        word(0, STACK);
        word(4, CODE | 1);
        for exception in 2..16 {
            word(exception * 4, HANDLER | 1);
        }
        // The handler goes on behind the instruction: LDR r0, [sp, #24]; LDRH r1, [r0];
        // LSRS r1, #11; CMP r1, #29; ITE cs; ADD r0, #4; ADD r0, #2; STR r0, [sp, #24]; BX lr.
        let handler = [
            0x9806, 0x8801, 0x0AC9, 0x291D, 0xBF2C, 0x3004, 0x3002, 0x9006, 0x4770,
        ];
        for (place, code) in (0..).zip(handler) {
            bus.write(HANDLER + place * 2, Width::Half, code).unwrap();
        }
        let mut core = mps2::core(0);
        core.reset(&mut bus).unwrap();
        let mut program = Self {
            core,
            bus,
            end: CODE,
            shown: 0,
        };
        // The unit is enabled: r1 is CPACR.
        program.set(0, 0x00F0_0000);
        program.set(1, 0xE000_ED88);
        program.always(&[0x6008]);
        program
    }

    /// Adds an instruction, if it executes and goes on to the next on the same stack; or, if it
    /// shall not be `defined`, if it ends in the handler.
    fn add(&mut self, code: &[u16], defined: bool) -> bool {
        let before = self.core.clone();
        for (place, half) in (0..).zip(code) {
            let address = self.end + place * 2;
            let half = u32::from(*half);
            self.bus.write(address, Width::Half, half).unwrap();
        }
        self.core.set_register(15, self.end);
        let behind = self.end + code.len() as u32 * 2;
        let mut memory = Guarded {
            bus: &mut self.bus,
            failed: false,
            written: Vec::new(),
        };
        let step = self.core.step(&mut memory);
        let (failed, written) = (memory.failed, memory.written);
        let added = match step {
            Step::Executed { .. } => {
                let core = &self.core;
                let on = core.register(15) == behind && core.register(13) == before.register(13);
                defined && on && !failed
            }
            Step::Unimplemented { .. } => !defined,
            _ => false,
        };
        if !added {
            self.core = before;
            for (address, old) in written.into_iter().rev() {
                self.bus.write(address, Width::Word, old).unwrap();
            }
            return false;
        }
        self.shown += 1;
        if !defined {
            let executed = self.core.executed();
            while self.core.register(15) != behind {
                self.core.step(&mut self.bus);
            }
            self.shown += (self.core.executed() - executed) as usize;
        }
        self.end = behind;
        true
    }

    fn always(&mut self, code: &[u16]) {
        assert!(self.add(code, true), "{code:04x?}");
    }

    /// MOVW and MOVT.
    fn set(&mut self, register: u32, value: u32) {
        for (first, half) in [(0xF240, value & 0xFFFF), (0xF2C0, value >> 16)] {
            let first = first | half >> 12 | (half >> 11 & 1) << 10;
            let second = register << 8 | (half >> 8 & 7) << 12 | half & 0xFF;
            self.always(&[first as u16, second as u16]);
        }
    }

    /// Changes registers that would be addresses of private peripherals, in which QEMU has less.
    fn leave_private(&mut self) {
        for register in (0..13).chain([14]) {
            if self.core.register(register as usize) >> 24 == 0xE0 {
                self.set(register, 0);
            }
        }
    }

    /// An edge in some registers, flags, modes of the unit, and the base of accesses.
    fn set_up(&mut self, random: &mut Random) {
        for _ in 0..3 {
            let value = match random.below(4) {
                0 => random.next(),
                _ => random.of(&EDGES),
            };
            let register = random.below(8);
            self.set(register, value);
            // VMOV to two singles.
            for _ in 0..2 {
                let single = random.below(8);
                let first = 0xEE00 | single >> 1;
                let second = register << 12 | 0xA10 | (single & 1) << 7;
                self.always(&[first as u16, second as u16]);
            }
        }
        // MSR APSR_nzcvqg, r9.
        self.set(9, random.next() & 0xF80F_0000);
        self.always(&[0xF389, 0x8C00]);
        // VMSR FPSCR, r9.
        let modes = match random.below(4) {
            0 | 1 => 0,
            2 => random.next() & 0x0300_0000,
            _ => random.next() & 0x07C0_0000,
        };
        self.set(9, modes | random.of(&[0, 0x9F, 0x10]));
        self.always(&[0xEEE1, 0x9A10]);
        self.set(8, DATA.start + 0xC00 + random.below(4) * random.below(3));
    }
}

fn candidate(random: &mut Random) -> Vec<u16> {
    if random.below(4) == 0 {
        let code = random.below(0xE800);
        return vec![code as u16];
    }
    let (mask, value) = GROUPS[random.below(GROUPS.len() as u32) as usize];
    let code = random.next() & !mask | value;
    vec![(code >> 16) as u16, code as u16]
}

/// Instructions that wait, call, or that QEMU treats otherwise for a reason: it compares
/// addresses of exclusives, which a Cortex-M4 need not.
fn is_left_out(code: &[u16], in_it: bool) -> bool {
    match *code {
        // Conditional branches, CBZ, IT and CPS belong outside of IT blocks.
        [code] if in_it && matches!(code >> 12, 0xB | 0xD) => true,
        [first, second] if in_it && first >> 11 == 0x1E && second >> 15 != 0 => true,
        [code] => matches!(code, 0xBF20 | 0xBF30 | 0xDF00..=0xDFFF),
        [0xF3AF, second] => second & 0xFF == 2 || second & 0xFF == 3,
        [first, second] => {
            first & 0xFFE0 == 0xE840
                || first & 0xFFE0 == 0xE8C0 && matches!(second >> 4 & 15, 4 | 5)
        }
        _ => false,
    }
}

/// Executes the program under QEMU and once more in the emulator, and compares.
fn compare(program: &mut Program, name: &str) -> usize {
    // B to itself.
    let length = program.end + 2;
    let mut code = program.bus.bytes(0, length);
    code[length as usize - 2..].copy_from_slice(&[0xFE, 0xE7]);
    let file = elf::file(&code);
    let path = std::env::temp_dir().join(format!("{name}-{}.elf", std::process::id()));
    std::fs::write(&path, &file).unwrap();
    let (mut core, mut bus) = mps2::machine(&file);
    core.set_xpsr(0x4100_0000);
    let qemu = qemu::command(&path);
    let wanted = (&(0..length), program.shown);
    let compared = trace::compare(qemu, &mut core, &mut bus, wanted, u32::MAX);
    std::fs::remove_file(&path).unwrap();
    compared
}

/// So many blocks of a set-up and 20 instructions; how many instructions were compared.
fn random_program(seed: u64, blocks: u32) -> usize {
    let mut random = Random(seed);
    let mut program = Program::new();
    for _ in 0..blocks {
        program.set_up(&mut random);
        let mut added = 0;
        while added < 20 {
            program.leave_private();
            let code = candidate(&mut random);
            let in_it = program.core.xpsr() & 0x0600_FC00 != 0;
            added += u32::from(!is_left_out(&code, in_it) && program.add(&code, true));
        }
    }
    let shown = program.shown;
    assert_eq!(compare(&mut program, &format!("random-{seed:x}")), shown);
    shown
}

#[test]
fn random_instructions_do_what_they_do_under_qemu() {
    let compared = random_program(0x9E37_79B9_7F4A_7C15, 500);
    assert!(compared > 15_000, "{compared}");
}

#[test]
#[ignore = "minutes: QEMU prints each instruction"]
fn many_random_instructions_do_what_they_do_under_qemu() {
    let seeds = (1..=16).map(|number| 0x9E37_79B9_7F4A_7C15_u64.wrapping_mul(number));
    let compared: usize = seeds.map(|seed| random_program(seed, 2_000)).sum();
    println!("{compared}");
    assert!(compared > 1_000_000, "{compared}");
}
