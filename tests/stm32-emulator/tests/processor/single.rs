//! Single instructions with operands at the edges; expected values by the manual's pseudocode.

use armbridge_stm32_emulator::core::Step;

use crate::board::{Board, PROGRAM, SRAM};

const N: u32 = 1 << 31;
const Z: u32 = 1 << 30;
const C: u32 = 1 << 29;
const V: u32 = 1 << 28;
const Q: u32 = 1 << 27;

/// Code, r0 to r2, flags; then r0 and the flags.
type Case = (&'static [u16], [u32; 3], u32, u32, u32);

#[rustfmt::skip]
const ARITHMETIC: &[Case] = &[
    // ADDS r0, r0, r1
    (&[0x1840], [0xFFFF_FFFF, 1, 0], 0, 0, Z | C),
    (&[0x1840], [0x7FFF_FFFF, 1, 0], 0, 0x8000_0000, N | V),
    (&[0x1840], [0x8000_0000, 0x8000_0000, 0], 0, 0, Z | C | V),
    // SUBS r0, r0, r1
    (&[0x1A40], [0, 1, 0], C, 0xFFFF_FFFF, N),
    (&[0x1A40], [0x8000_0000, 1, 0], 0, 0x7FFF_FFFF, C | V),
    (&[0x1A40], [5, 5, 0], 0, 0, Z | C),
    // ADCS r0, r1; SBCS r0, r1; RSBS r0, r1, #0
    (&[0x4148], [0xFFFF_FFFF, 0, 0], C, 0, Z | C),
    (&[0x4148], [0x7FFF_FFFF, 0, 0], C, 0x8000_0000, N | V),
    (&[0x4148], [0xFFFF_FFFF, 0xFFFF_FFFF, 0], C, 0xFFFF_FFFF, N | C),
    (&[0x4188], [0, 0, 0], 0, 0xFFFF_FFFF, N),
    (&[0x4188], [0, 0, 0], C, 0, Z | C),
    (&[0x4188], [0x8000_0000, 0, 0], 0, 0x7FFF_FFFF, C | V),
    (&[0x4248], [9, 0x8000_0000, 0], 0, 0x8000_0000, N | V),
    (&[0x4248], [9, 0, 0], 0, 0, Z | C),
    // MOVS r0, #0x80000000: the carry of the rotation; MOVS r0, #0x80: none.
    (&[0xF05F, 0x4000], [0, 0, 0], 0, 0x8000_0000, N | C),
    (&[0xF05F, 0x0080], [0, 0, 0], C | V, 0x80, C | V),
    // MOV r0, #0x80000000 without flags.
    (&[0xF04F, 0x4000], [0, 0, 0], Z, 0x8000_0000, Z),
    // MOVW, MOVT
    (&[0xF64F, 0x70FF, 0xF6CF, 0x70FE], [0, 0, 0], 0, 0xFFFE_FFFF, 0),
    // SDIV and UDIV r0, r0, r1
    (&[0xFB90, 0xF0F1], [0x8000_0000, 0xFFFF_FFFF, 0], 0, 0x8000_0000, 0),
    (&[0xFB90, 0xF0F1], [0xFFFF_FFF9, 2, 0], 0, 0xFFFF_FFFD, 0),
    (&[0xFB90, 0xF0F1], [7, 0, 0], 0, 0, 0),
    (&[0xFBB0, 0xF0F1], [0x8000_0000, 0xFFFF_FFFF, 0], 0, 0, 0),
    (&[0xFBB0, 0xF0F1], [0xFFFF_FFFF, 2, 0], 0, 0x7FFF_FFFF, 0),
];

#[rustfmt::skip]
const SHIFTS: &[Case] = &[
    // LSLS r0, r1 by 0, 1, 31, 32, 33, 255, 256
    (&[0x4088], [0x8000_0001, 0, 0], C, 0x8000_0001, N | C),
    (&[0x4088], [0x8000_0001, 1, 0], 0, 2, C),
    (&[0x4088], [0x8000_0001, 31, 0], 0, 0x8000_0000, N),
    (&[0x4088], [0x8000_0001, 32, 0], 0, 0, Z | C),
    (&[0x4088], [0x8000_0001, 33, 0], C, 0, Z),
    (&[0x4088], [0x8000_0001, 0xFF, 0], C, 0, Z),
    (&[0x4088], [0x8000_0001, 0x100, 0], 0, 0x8000_0001, N),
    // LSRS r0, r1
    (&[0x40C8], [0x8000_0001, 0, 0], C, 0x8000_0001, N | C),
    (&[0x40C8], [0x8000_0001, 31, 0], C, 1, 0),
    (&[0x40C8], [0x8000_0001, 32, 0], 0, 0, Z | C),
    (&[0x40C8], [0x8000_0001, 33, 0], C, 0, Z),
    // ASRS r0, r1
    (&[0x4108], [0x8000_0001, 31, 0], C, 0xFFFF_FFFF, N),
    (&[0x4108], [0x8000_0001, 32, 0], 0, 0xFFFF_FFFF, N | C),
    (&[0x4108], [0x8000_0001, 200, 0], 0, 0xFFFF_FFFF, N | C),
    (&[0x4108], [0x7FFF_FFFF, 32, 0], C, 0, Z),
    // RORS r0, r1
    (&[0x41C8], [0x8000_0001, 0, 0], 0, 0x8000_0001, N),
    (&[0x41C8], [0x8000_0001, 1, 0], 0, 0xC000_0000, N | C),
    (&[0x41C8], [0x8000_0001, 32, 0], 0, 0x8000_0001, N | C),
    (&[0x41C8], [0x0000_0003, 33, 0], 0, 0x8000_0001, N | C),
    // LSRS r0, r1, #32; ASRS r0, r1, #32; LSLS r0, r1, #0
    (&[0x0808], [9, 0x8000_0000, 0], 0, 0, Z | C),
    (&[0x1008], [9, 0x8000_0000, 0], 0, 0xFFFF_FFFF, N | C),
    (&[0x0008], [9, 0, 0], C | V, 0, Z | C | V),
    // RRXS r0, r1
    (&[0xEA5F, 0x0031], [9, 1, 0], C, 0x8000_0000, N | C),
    (&[0xEA5F, 0x0031], [9, 2, 0], 0, 1, 0),
];

#[rustfmt::skip]
const OTHERS: &[Case] = &[
    // UMULL and SMULL r2, r0, r1, r1: the high word; UMAAL r2, r0, r1, r1
    (&[0xFBA1, 0x2001], [0, 0xFFFF_FFFF, 0], 0, 0xFFFF_FFFE, 0),
    (&[0xFB81, 0x2001], [9, 0xFFFF_FFFF, 0], 0, 0, 0),
    (&[0xFBE1, 0x2061], [0xFFFF_FFFF; 3], 0, 0xFFFF_FFFF, 0),
    // SMLABB r0, r1, r1, r2; SMULWB r0, r1, r2
    (&[0xFB11, 0x2001], [0, 0x7FFF, 0x7FFF_FFFF], 0, 0xBFFF_0000, Q),
    (&[0xFB11, 0x2001], [0, 0x8000, 0], 0, 0x4000_0000, 0),
    (&[0xFB31, 0xF002], [0, 0x8000_0000, 0x8000], 0, 0x4000_0000, 0),
    // SMMULR r0, r1, r2
    (&[0xFB51, 0xF012], [0, 0x0000_8000, 0x0001_0000], 0, 1, 0),
    // SSAT r0, #8, r1; USAT r0, #8, r1
    (&[0xF301, 0x0007], [0, 200, 0], 0, 127, Q),
    (&[0xF301, 0x0007], [0, (-200_i32) as u32, 0], 0, 0xFFFF_FF80, Q),
    (&[0xF301, 0x0007], [0, 5, 0], 0, 5, 0),
    (&[0xF381, 0x0008], [0, 0xFFFF_FFFF, 0], 0, 0, Q),
    (&[0xF381, 0x0008], [0, 300, 0], Q, 255, Q),
    // QADD r0, r1, r2; QDSUB r0, r1, r2: both steps saturate
    (&[0xFA82, 0xF081], [0, 0x7FFF_FFFF, 1], 0, 0x7FFF_FFFF, Q),
    (&[0xFA82, 0xF0B1], [0, 0, 0x8000_0000], 0, 0x7FFF_FFFF, Q),
    // CLZ, RBIT, REVSH, REV16, SXTH of r1
    (&[0xFAB1, 0xF081], [9, 0, 0], 0, 32, 0),
    (&[0xFA91, 0xF0A1], [9, 1, 0], 0, 0x8000_0000, 0),
    (&[0xBAC8], [9, 0x80, 0], 0, 0xFFFF_8000, 0),
    (&[0xBA48], [9, 0x1122_3344, 0], 0, 0x2211_4433, 0),
    (&[0xB208], [9, 0x8000, 0], 0, 0xFFFF_8000, 0),
    // UXTAB r0, r2, r1, ROR #8
    (&[0xFA52, 0xF091], [9, 0x0000_FF00, 1], 0, 0x100, 0),
    // BFI r0, r1, #4, #8; BFC r0, #0, #32; UBFX and SBFX r0, r1, #31, #1
    (&[0xF361, 0x100B], [0xFFFF_FFFF, 0x500, 0], 0, 0xFFFF_F00F, 0),
    (&[0xF36F, 0x001F], [0xFFFF_FFFF, 0, 0], 0, 0, 0),
    (&[0xF3C1, 0x70C0], [9, 0x8000_0000, 0], 0, 1, 0),
    (&[0xF341, 0x70C0], [9, 0x8000_0000, 0], 0, 0xFFFF_FFFF, 0),
    // UADD8 and SSUB16 r0, r1, r2: GE; then SEL r0, r1, r2
    (&[0xFA81, 0xF042], [0, 0xFF00_FF00, 0x0101_0101], 0, 0x0001_0001, 0xA_0000),
    (&[0xFAD1, 0xF002], [0, 0x0001_8000, 0x0002_7FFF], 0, 0xFFFF_0001, 0),
    (&[0xFAA1, 0xF082], [0, 0x1122_3344, 0x5566_7788], 0xA_0000, 0x1166_3388, 0xA_0000),
    // PKHTB r0, r1, r2, ASR #32
    (&[0xEAC1, 0x0022], [0, 0x1234_5678, 0x8000_0000], 0, 0x1234_FFFF, 0),
];

#[rustfmt::skip]
const BLOCKS: &[Case] = &[
    // ITE eq; MOV r0, #1; MOV r0, #2: the flags stay.
    (&[0xBF0C, 0x2001, 0x2002], [9, 0, 0], Z, 1, Z),
    (&[0xBF0C, 0x2001, 0x2002], [9, 0, 0], N, 2, N),
    // IT eq; ADD r0, r0, r1 sets no flags; then ADDS does.
    (&[0xBF08, 0x1840], [0xFFFF_FFFF, 1, 0], Z, 0, Z),
    (&[0xBF08, 0x1840, 0x1840], [0xFFFF_FFFF, 1, 0], Z, 1, 0),
    // ITT eq; CMP r0, r1 sets flags, after which the second is not executed.
    (&[0xBF04, 0x4288, 0x2007], [3, 2, 0], Z, 3, C),
    // ITTTT of each condition: executed four times or not at all, ADD r0, r0, r1.
    (&[0xBF81, 0x1840, 0x1840, 0x1840, 0x1840], [0, 1, 0], C, 4, C),
    (&[0xBF81, 0x1840, 0x1840, 0x1840, 0x1840], [0, 1, 0], C | Z, 0, C | Z),
    (&[0xBFB8, 0x1840], [0, 1, 0], N, 1, N),
    (&[0xBFB8, 0x1840], [0, 1, 0], N | V, 0, N | V),
    (&[0xBFC8, 0x1840], [0, 1, 0], V | N, 1, V | N),
    (&[0xBFC8, 0x1840], [0, 1, 0], V | N | Z, 0, V | N | Z),
];

fn check(cases: &[Case]) {
    for (code, operands, flags, result, flags_after) in cases {
        let mut board = Board::new(code);
        for (number, value) in operands.iter().enumerate() {
            board.set_register(number, *value);
        }
        board.set_xpsr(1 << 24 | flags);
        let end = PROGRAM + code.len() as u32 * 2;
        while board.register(15) != end {
            board.execute(1);
        }
        let name = format!("{code:04x?} of {operands:x?} with {flags:#x}");
        assert_eq!(
            board.register(0),
            *result,
            "{name}: r0 {:#x}",
            board.register(0)
        );
        let after = board.xpsr() & !(1 << 24);
        assert_eq!(after, *flags_after, "{name}: xpsr {after:#x}");
    }
}

#[test]
fn arithmetic_and_its_flags() {
    check(ARITHMETIC);
}

#[test]
fn shifts_by_0_to_256() {
    check(SHIFTS);
}

#[test]
fn multiplication_saturation_and_bits() {
    check(OTHERS);
}

#[test]
fn it_blocks() {
    check(BLOCKS);
}

#[test]
fn unaligned_accesses_of_memory() {
    // LDR, LDRH, LDRSH, LDRSB r0, [r1]; then STR, STRH r2, [r1] and LDR r0, [r1, #-1].
    #[rustfmt::skip]
    let cases: [(&[u16], u32); 6] = [
        (&[0x6808], 0x8483_8281),
        (&[0x8808], 0x8281),
        (&[0xF9B1, 0x0000], 0xFFFF_8281),
        (&[0xF991, 0x0000], 0xFFFF_FF81),
        (&[0x600A, 0xF851, 0x0C01], 0x3344_5580),
        (&[0x800A, 0xF851, 0x0C01], 0x8344_5580),
    ];
    for (code, expected) in cases {
        let mut board = Board::new(code);
        board.set_word(SRAM + 0x100, 0x8382_8180);
        board.set_word(SRAM + 0x104, 0x8786_8584);
        board.set_register(1, SRAM + 0x101);
        board.set_register(2, 0x1133_4455);
        while board.register(15) != PROGRAM + code.len() as u32 * 2 {
            board.execute(1);
        }
        let r0 = board.register(0);
        assert_eq!(r0, expected, "{code:04x?}: {r0:#x}");
    }
}

#[test]
fn loads_of_several_registers_and_branches() {
    // PUSH {r0-r2, lr}; POP {r3-r5, pc}
    let mut board = Board::new(&[0xB507, 0xBD38]);
    for number in 0..3 {
        board.set_register(number, 10 + number as u32);
    }
    board.set_register(14, PROGRAM + 0x101);
    let sp = board.register(13);
    board.execute(2);
    let registers: Vec<u32> = [3, 4, 5, 13, 15].map(|n| board.register(n)).to_vec();
    assert_eq!(registers, [10, 11, 12, sp, PROGRAM + 0x100]);
    // TBH [pc, r0, LSL #1] with the table behind it: the second is 4 halfwords on.
    let mut board = Board::new(&[0xE8DF, 0xF010, 2, 4]);
    board.set_register(0, 1);
    board.execute(1);
    assert_eq!(board.register(15), PROGRAM + 4 + 8);
    // BL over one halfword; CBNZ r0 over one.
    let mut board = Board::new(&[0xF000, 0xF801, 0xBF00, 0xB908]);
    board.set_register(0, 1);
    board.execute(2);
    assert_eq!(board.register(14), (PROGRAM + 4) | 1);
    assert_eq!(board.register(15), PROGRAM + 12);
}

#[test]
fn exclusives_succeed_once_and_not_behind_an_exception() {
    // LDREX r0, [r1]; STREX r2, r0, [r1]; STREX r3, r0, [r1]
    let code = [0xE851, 0x0F00, 0xE841, 0x0200, 0xE841, 0x0300];
    let mut board = Board::new(&code);
    board.set_register(1, SRAM);
    board.set_register(2, 7);
    board.execute(3);
    assert_eq!([board.register(2), board.register(3)], [0, 1]);
    let mut board = Board::new(&code);
    board.set_register(1, SRAM);
    board.execute(1);
    board.set_system_register(0xE000_E100, 1);
    board.pend(0);
    board.enters(16);
    board.execute(2);
    assert_eq!(board.register(2), 1);
}

#[test]
fn what_the_emulator_lacks_is_said_and_faults() {
    // VSELEQ s0, s0, s0, of ARMv8-M, is undefined; ADD pc, r0, r1 (wide) is left open.
    let mut board = Board::new(&[0xFE00, 0x0A00]);
    board.enters(3);
    let mut board = Board::new(&[0xEB00, 0x0F01]);
    let expected = Step::Unimplemented {
        pc: PROGRAM,
        opcode: 0xEB00_0F01,
    };
    assert_eq!(board.step(), expected);
    board.enters(3);
    assert_eq!(board.system_register(0xE000_ED28), 1 << 16);
}
