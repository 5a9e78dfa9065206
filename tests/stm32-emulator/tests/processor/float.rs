//! Floating-point instructions with operands at the edges; expected values by IEEE 754 and the
//! manual's pseudocode.

use crate::board::{Board, PROGRAM};

const IOC: u32 = 1 << 0;
const DZC: u32 = 1 << 1;
const OFC: u32 = 1 << 2;
const UFC: u32 = 1 << 3;
const IXC: u32 = 1 << 4;
const IDC: u32 = 1 << 7;
const UP: u32 = 1 << 22;
const DOWN: u32 = 2 << 22;
const TO_ZERO: u32 = 3 << 22;
const FZ: u32 = 1 << 24;
const DN: u32 = 1 << 25;

const ONE: u32 = 0x3F80_0000;
const INF: u32 = 0x7F80_0000;
const NAN: u32 = 0x7FC0_0000;
const MIN: u32 = 0x0080_0000;
const MAX: u32 = 0x7F7F_FFFF;
const HALF: u32 = 0x3F00_0000;
const MINUS: u32 = 1 << 31;

const VADD: [u16; 2] = [0xEE30, 0x0A20];
const VSUB: [u16; 2] = [0xEE30, 0x0A60];
const VMUL: [u16; 2] = [0xEE20, 0x0A20];
const VDIV: [u16; 2] = [0xEE80, 0x0A20];
/// Of s1.
const VSQRT: [u16; 2] = [0xEEB1, 0x0AE0];
/// s0 and s1 squared.
const VFMA: [u16; 2] = [0xEEA0, 0x0AA0];
const VMLA: [u16; 2] = [0xEE00, 0x0AA0];
const TO_S32: [u16; 2] = [0xEEBD, 0x0AE0];
const TO_U32: [u16; 2] = [0xEEBC, 0x0AE0];
const ROUNDED_TO_S32: [u16; 2] = [0xEEBD, 0x0A60];
const FROM_S32: [u16; 2] = [0xEEB8, 0x0AE0];
const FROM_U32: [u16; 2] = [0xEEB8, 0x0A60];
const TO_HALF: [u16; 2] = [0xEEB3, 0x0A60];
const FROM_HALF: [u16; 2] = [0xEEB2, 0x0A60];

/// Code, s0, s1, modes; then s0 and the exceptions.
type Case = ([u16; 2], u32, u32, u32, u32, u32);

#[rustfmt::skip]
const CASES: &[Case] = &[
    (VADD, INF, INF | MINUS, 0, NAN, IOC),
    (VADD, INF, ONE, 0, INF, 0),
    // Signalling before quiet, the first of equals, with its payload; the default.
    (VADD, 0x7FC0_1111, 0xFF80_0001, 0, 0xFFC0_0001, IOC),
    (VADD, 0x7FC0_1111, 0x7FC0_2222, 0, 0x7FC0_1111, 0),
    (VADD, 0xFFC0_1111, ONE, DN, NAN, 0),
    (VSUB, ONE, 0x7FC0_2222, 0, 0x7FC0_2222, 0),
    (VADD, MAX, MAX, 0, INF, OFC | IXC),
    (VADD, MAX, MAX, TO_ZERO, MAX, OFC | IXC),
    // A tie to even, and the other modes.
    (VADD, ONE, 0x3380_0000, 0, ONE, IXC),
    (VADD, ONE, 0x3380_0001, 0, ONE + 1, IXC),
    (VADD, ONE, 0x3300_0000, UP, ONE + 1, IXC),
    (VADD, ONE, 0x3380_0000, DOWN, ONE, IXC),
    // Zeros.
    (VADD, MINUS, MINUS, 0, MINUS, 0),
    (VADD, ONE, ONE | MINUS, 0, 0, 0),
    (VADD, ONE, ONE | MINUS, DOWN, MINUS, 0),
    (VSUB, 0, 0, 0, 0, 0),
    // Denormals: exact, flushed as result and as operand, rounded away.
    (VMUL, MIN, HALF, 0, 0x0040_0000, 0),
    (VMUL, MIN, HALF, FZ, 0, UFC),
    (VMUL, 0x8040_0000, ONE, FZ, MINUS, IDC),
    (VMUL, 1, HALF, 0, 0, UFC | IXC),
    (VMUL, 3, HALF, 0, 2, UFC | IXC),
    // Rounded up to the least normal number: it was less before.
    (VMUL, 0x0100_0000, 0x3EFF_FFFF, 0, MIN, UFC | IXC),
    (VMUL, 0, INF, 0, NAN, IOC),
    (VDIV, ONE, 0, 0, INF, DZC),
    (VDIV, ONE, MINUS, 0, INF | MINUS, DZC),
    (VDIV, 0, 0, 0, NAN, IOC),
    (VDIV, INF, INF, 0, NAN, IOC),
    (VDIV, ONE, 0x4040_0000, 0, 0x3EAA_AAAB, IXC),
    (VDIV, ONE, 0x4040_0000, DOWN, 0x3EAA_AAAA, IXC),
    (VSQRT, 0, ONE | MINUS, 0, NAN, IOC),
    (VSQRT, 0, MINUS, 0, MINUS, 0),
    (VSQRT, 0, 0x4000_0000, 0, 0x3FB5_04F3, IXC),
    (VSQRT, 0, 0x4080_0000, 0, 0x4000_0000, 0),
    // (1 + 2^-23)^2 - (1 + 2^-22) is 2^-46, but 0 if the product is rounded.
    (VFMA, 0xBF80_0002, 0x3F80_0001, 0, 0x2880_0000, 0),
    (VMLA, 0xBF80_0002, 0x3F80_0001, 0, 0, IXC),
    (VFMA, INF | MINUS, INF, 0, NAN, IOC),
    (VFMA, 0xFFC0_0123, ONE, 0, 0xFFC0_0123, 0),
    // To integers.
    (TO_S32, 0, NAN, 0, 0, IOC),
    (TO_S32, 0, INF, 0, 0x7FFF_FFFF, IOC),
    (TO_S32, 0, INF | MINUS, 0, 0x8000_0000, IOC),
    (TO_S32, 0, 0x4F00_0000, 0, 0x7FFF_FFFF, IOC),
    (TO_S32, 0, 0xCF00_0000, 0, 0x8000_0000, 0),
    (TO_S32, 0, MINUS, 0, 0, 0),
    (TO_S32, 0, 0xBFC0_0000, 0, 0xFFFF_FFFF, IXC),
    (TO_U32, 0, ONE | MINUS, 0, 0, IOC),
    (TO_U32, 0, HALF | MINUS, 0, 0, IXC),
    (TO_U32, 0, 0x4F7F_FFFF, 0, 0xFFFF_FF00, 0),
    (ROUNDED_TO_S32, 0, 0x4020_0000, 0, 2, IXC),
    (ROUNDED_TO_S32, 0, 0x4060_0000, 0, 4, IXC),
    (ROUNDED_TO_S32, 0, 0x4020_0000, UP, 3, IXC),
    (ROUNDED_TO_S32, 0, 0xC020_0000, DOWN, 0xFFFF_FFFD, IXC),
    // From integers; VCVT.F32.S32 s0, s0, #1 and VCVT.S16.F32 s0, s0, #8.
    (FROM_S32, 0, 0xFFFF_FFFF, 0, ONE | MINUS, 0),
    (FROM_S32, 0, 0x7FFF_FFFF, 0, 0x4F00_0000, IXC),
    (FROM_U32, 0, 0xFFFF_FFFF, 0, 0x4F80_0000, IXC),
    (FROM_U32, 0, 0xFFFF_FFFF, TO_ZERO, 0x4F7F_FFFF, IXC),
    ([0xEEBA, 0x0AEF], 3, 0, 0, 0x3FC0_0000, 0),
    ([0xEEBE, 0x0A44], 0xBFC0_0000, 0, 0, 0xFFFF_FE80, 0),
    // Half precision: the other half stays.
    (TO_HALF, 0xAAAA_0000, ONE, 0, 0xAAAA_3C00, 0),
    (TO_HALF, 0, 0x477F_F000, 0, 0x7C00, OFC | IXC),
    (TO_HALF, 0, 0x477F_EFFF, 0, 0x7BFF, IXC),
    (TO_HALF, 0, 0x3300_0000, 0, 0, UFC | IXC),
    (FROM_HALF, 0, 0x8001, 0, 0xB380_0000, 0),
    (FROM_HALF, 0, 0x7C01, 0, 0x7FC0_2000, IOC),
    // VABS and VNEG of s1 are no arithmetic; VMOV s0, #1.0.
    ([0xEEB0, 0x0AE0], 0, 0xFF80_0001, 0, 0x7F80_0001, 0),
    ([0xEEB1, 0x0A60], 0, 0x7F80_0001, FZ, 0xFF80_0001, 0),
    ([0xEEB7, 0x0A00], 0, 0, 0, ONE, 0),
];

/// With the exceptions clear before, and all set: then the host's arithmetic may be used.
#[test]
fn results_and_exceptions() {
    for (code, s0, s1, modes, result, exceptions) in CASES {
        for before in [0, 0x9F] {
            let mut board = Board::new(&[0xEEE1, 0x0A10, code[0], code[1]]);
            board.set_register(0, modes | before);
            board.execute(1);
            board.set_float(0, *s0);
            board.set_float(1, *s1);
            board.execute(1);
            let name = format!("{code:04x?} of {s0:#x}, {s1:#x} with {:#x}", modes | before);
            assert_eq!(board.float(0), *result, "{name}: {:#x}", board.float(0));
            let after = board.fpscr();
            assert_eq!(after, modes | exceptions | before, "{name}: {after:#x}");
        }
    }
}

#[test]
fn comparisons() {
    // VCMP s0, s1; VCMPE s0, s1; both with VMRS APSR_nzcv, FPSCR.
    let [quiet, signalling] = [0x0A60, 0x0AE0];
    #[rustfmt::skip]
    let cases = [
        (quiet, ONE, ONE, 0x6, 0),
        (quiet, MINUS, 0, 0x6, 0),
        (quiet, ONE | MINUS, ONE, 0x8, 0),
        (quiet, INF, MAX, 0x2, 0),
        (quiet, NAN, ONE, 0x3, 0),
        (quiet, 0x7F80_0001, ONE, 0x3, IOC),
        (signalling, NAN, ONE, 0x3, IOC),
        (signalling, ONE, INF, 0x8, 0),
    ];
    for (compare, s0, s1, flags, exceptions) in cases {
        let mut board = Board::new(&[0xEEB4, compare, 0xEEF1, 0xFA10]);
        board.set_float(0, s0);
        board.set_float(1, s1);
        board.execute(2);
        assert_eq!(board.xpsr() >> 28, flags, "{s0:#x}, {s1:#x}");
        assert_eq!(board.fpscr() & 0x9F, exceptions, "{s0:#x}, {s1:#x}");
    }
}

/// Sums of products on the host's own instruction.
#[test]
fn fused_is_fused() {
    let mut bits = 0x1234_5678_u32;
    let mut next = || {
        bits = bits.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        // Exponents near 1, where sums cancel.
        bits & 0x807F_FFFF | (0x3C + (bits >> 28 & 3)) << 24
    };
    let mut board = Board::new(&VFMA);
    for _ in 0..20_000 {
        let [addend, a] = [next(), next()];
        board.set_register(15, PROGRAM);
        board.set_float(0, addend);
        board.set_float(1, a);
        board.execute(1);
        let expected = f32::from_bits(a).mul_add(f32::from_bits(a), f32::from_bits(addend));
        assert_eq!(board.float(0), expected.to_bits(), "{addend:#x}, {a:#x}");
    }
}
