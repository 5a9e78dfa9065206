//! Random exceptions, compared with QEMU's trace: preemption, tail-chaining, frames with and
//! without floating-point state, both stacks, masks, priorities and groups.
//!
//! All handlers are one, which makes random interrupts pending and uses the floating-point unit
//! half of the time, until a budget is spent; the program changes priorities and masks, makes
//! exceptions pending and renews the budget.

use armbridge_stm32_emulator::core::Step;
use armbridge_stm32_emulator::memory::{Memory, Width};

use crate::mps2::{self, Bus};
use crate::random::Random;
use crate::{elf, qemu, trace};

const STACK: u32 = 0x2000_8000;
const PROCESS_STACK: u32 = 0x2000_6000;
/// Budget, and the state of a linear congruential generator.
const STATE: u32 = 0x2000_4000;
const SKIP: u32 = 0x100;
const HANDLER: u32 = 0x120;
const CODE: u32 = 0x200;

/// Goes on behind an undefined instruction of 16 bits: TST lr, #4; ITE eq; MRS r1, MSP;
/// MRS r1, PSP; LDR r0, [r1, #24]; ADDS r0, #2; STR r0, [r1, #24]; BX lr.
const SKIP_CODE: [u16; 11] = [
    0xF01E, 0x0F04, 0xBF0C, 0xF3EF, 0x8108, 0xF3EF, 0x8109, 0x6988, 0x3002, 0x6188, 0x4770,
];

const HANDLER_CODE: [u16; 40] = [
    0xB530, // push {r4, r5, lr}
    0xF244, 0x0000, 0xF2C2, 0x0000, // r0 = 0x20004000
    0x6801, // ldr r1, [r0]
    0xB1F1, // cbz r1, end
    0x3901, // subs r1, #1
    0x6001, // str r1, [r0]
    0x6842, // ldr r2, [r0, #4]
    0xF246, 0x630D, 0xF2C0, 0x0319, // r3 = 1664525
    0x435A, // muls r2, r3, r2
    0xF24F, 0x335F, 0xF6C3, 0x436E, // r3 = 1013904223
    0x18D2, // adds r2, r2, r3
    0x6042, // str r2, [r0, #4]
    0x0051, // lsls r1, r2, #1
    0xD305, // bcc behind the floating-point instructions
    0xEE00, 0x2A10, // vmov s0, r2
    0xEE70, 0x0A80, // vadd.f32 s1, s1, s0
    0xEE20, 0x1A80, // vmul.f32 s2, s1, s0
    0xEA02, 0x11D2, // and r1, r2, r2, lsr #7
    0xEA01, 0x3152, // and r1, r1, r2, lsr #13
    0xF24E, 0x2300, 0xF2CE, 0x0300, // r3 = 0xE000E200
    0x6019, // str r1, [r3]
    0xBD30, // end: pop {r4, r5, pc}
    0xBF00,
];

/// Modes in FPSCR. A new context keeps the other bits (DDI 0403, `ExecuteFPCheck`); QEMU clears
/// them, as ARMv8-M does.
const MODES: u32 = 0x07C0_0000;

struct Program {
    bus: Bus,
    end: u32,
}

impl Program {
    fn new() -> Self {
        let mut bus = Bus::new();
        for exception in 1..48 {
            let handler = match exception {
                1 => CODE,
                2..=6 => SKIP,
                _ => HANDLER,
            };
            bus.write(exception * 4, Width::Word, handler | 1).unwrap();
        }
        bus.write(0, Width::Word, STACK).unwrap();
        let mut program = Self { bus, end: SKIP };
        program.add(&SKIP_CODE);
        program.end = HANDLER;
        program.add(&HANDLER_CODE);
        program.end = CODE;
        program
    }

    fn add(&mut self, code: &[u16]) {
        for half in code {
            let half = u32::from(*half);
            self.bus.write(self.end, Width::Half, half).unwrap();
            self.end += 2;
        }
    }

    /// MOVW and MOVT.
    fn set(&mut self, register: u32, value: u32) {
        for (first, half) in [(0xF240, value & 0xFFFF), (0xF2C0, value >> 16)] {
            let first = first | half >> 12 | (half >> 11 & 1) << 10;
            let second = register << 8 | (half >> 8 & 7) << 12 | half & 0xFF;
            self.add(&[first as u16, second as u16]);
        }
    }

    fn store(&mut self, address: u32, value: u32) {
        self.set(0, address);
        self.set(1, value);
        self.add(&[0x6001]);
    }

    fn action(&mut self, random: &mut Random) {
        match random.below(16) {
            // Priorities of four interrupts, or of SVCall, PendSV and SysTick.
            0..=2 => self.store(0xE000_E400 + random.below(8) * 4, random.next()),
            3 => {
                self.store(0xE000_ED1C, random.next() & 0xFF00_0000);
                self.store(0xE000_ED20, random.next() & 0xFFFF_0000);
            }
            // Priority groups.
            4 => self.store(0xE000_ED0C, 0x05FA_0000 | random.below(8) << 8),
            // Interrupts pending and not, enabled and not.
            5..=7 => self.store(0xE000_E200, random.next() & random.next()),
            8 => self.store(0xE000_E280, random.next() & random.next()),
            9 => {
                self.store(0xE000_E100, random.next());
                self.store(0xE000_E180, random.next() & random.next());
            }
            // MSR BASEPRI or BASEPRI_MAX, r1.
            10 => {
                self.set(1, random.next() & 0xFF & random.next());
                self.add(&[0xF381, 0x8811 + random.below(2) as u16]);
            }
            // PendSV.
            11 => self.store(0xE000_ED04, 1 << 28),
            // CPSID and CPSIE of PRIMASK or FAULTMASK.
            12 => self
                .add(&[[0xB661, 0xB662, 0xB671, 0xB672, 0xB661, 0xB662][random.below(6) as usize]]),
            // An undefined instruction, or SVC, which would be a fault if it is masked.
            13 => {
                self.unmask();
                self.add(&[0xDE00]);
            }
            14 => {
                self.unmask();
                self.add(&[0xDF00]);
            }
            // MSR CONTROL, r1, and the floating-point unit.
            _ => {
                self.set(1, random.below(4) & 2 | random.below(2) << 2);
                self.add(&[0xF381, 0x8814, 0xBF00]);
                if random.below(2) == 0 {
                    self.add(&[0xEE30, 0x8A21, 0xEE20, 0x0A08]);
                }
            }
        }
    }

    /// CPSIE i; CPSIE f; MSR BASEPRI, 0.
    fn unmask(&mut self) {
        self.add(&[0xB663]);
        self.set(1, 0);
        self.add(&[0xF381, 0x8811]);
    }
}

fn program(seed: u64, actions: u32) -> Program {
    let mut random = Random(seed);
    let mut program = Program::new();
    program.store(0xE000_ED88, 0x00F0_0000);
    program.store(0xE000_E100, u32::MAX);
    program.set(1, PROCESS_STACK);
    // MSR PSP, r1.
    program.add(&[0xF381, 0x8809]);
    program.store(STATE + 4, seed as u32);
    for number in 0..actions {
        if number % 8 == 0 {
            program.store(STATE, random.below(12));
        }
        program.action(&mut random);
        // An odd stack: SUB sp, #4 or ADD sp, #4.
        program.add(&[if number % 2 == 0 { 0xB081 } else { 0xB001 }]);
    }
    program
}

fn compare(seed: u64, actions: u32) -> [usize; 2] {
    let mut program = program(seed, actions);
    let end = program.end;
    program.add(&[0xE7FE]);
    let file = elf::file(&program.bus.bytes(0, program.end));
    let (mut core, mut bus) = mps2::machine(&file);
    let mut entries = 0;
    while core.register(15) != end {
        match core.step(&mut bus) {
            Step::Executed { .. } => {}
            Step::Entered { .. } => entries += 1,
            other => panic!("{other:?} at {:#x}", core.register(15)),
        }
        assert!(
            core.executed() < 2_000_000,
            "at {:#x} in {}",
            core.register(15),
            core.exception()
        );
    }
    // Undefined instructions are shown, but were not executed.
    let executed = core.executed() as usize;
    let path = std::env::temp_dir().join(format!("nested-{seed:x}-{}.elf", std::process::id()));
    std::fs::write(&path, &file).unwrap();
    let (mut core, mut bus) = mps2::machine(&file);
    core.set_xpsr(0x4100_0000);
    let qemu = qemu::command(&path);
    let compared = trace::compare(qemu, &mut core, &mut bus, (&(0..end), executed), MODES);
    std::fs::remove_file(&path).unwrap();
    assert_eq!(compared, executed);
    [compared, entries]
}

#[test]
fn random_exceptions_are_those_of_qemu() {
    let [compared, entries] = compare(0x0123_4567_89AB_CDEF, 1_000);
    println!("{compared} instructions, {entries} entries");
    assert!(entries > 500, "{entries}");
}

#[test]
#[ignore = "minutes: QEMU prints each instruction"]
fn many_random_exceptions_are_those_of_qemu() {
    let seeds = (1..=16).map(|number| 0x9E37_79B9_7F4A_7C15_u64.wrapping_mul(number));
    let done = seeds.map(|seed| compare(seed, 4_000));
    let [compared, entries] = done.fold([0, 0], |sum, one| [sum[0] + one[0], sum[1] + one[1]]);
    println!("{compared} instructions, {entries} entries");
    assert!(entries > 30_000, "{entries}");
}
