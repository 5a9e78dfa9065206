//! Faults: their status, escalation, faults on the stack, lockup, the MPU.
//! Source: DDI 0403, B1.5.14, B1.5.15, B3.2.15, B3.5.

use armbridge_stm32_emulator::core::{Core, Step};

use crate::board::{Board, FLASH, PROGRAM, SRAM, STACK, handler};

const SHCSR: u32 = 0xE000_ED24;
const CFSR: u32 = 0xE000_ED28;
const HFSR: u32 = 0xE000_ED2C;
const MMFAR: u32 = 0xE000_ED34;
const BFAR: u32 = 0xE000_ED38;
const CCR: u32 = 0xE000_ED14;
const FORCED: u32 = 1 << 30;
const UDF: u16 = 0xDE00;
const NOP: u16 = 0xBF00;
/// LDR r1, [r0]; STR r1, [r0]
const LDR: u16 = 0x6801;
const STR: u16 = 0x6001;

fn status(board: &mut Core) -> (u32, u32) {
    (board.system_register(CFSR), board.system_register(HFSR))
}

/// The address that an exception returns to, of a frame at the stack pointer.
fn return_address(board: &mut Board) -> u32 {
    let sp = board.register(13);
    board.word(sp + 24)
}

#[test]
fn a_fault_that_is_not_enabled_is_a_hard_fault() {
    let mut board = Board::new(&[NOP, UDF]);
    board.execute(1);
    board.enters(3);
    assert_eq!(status(&mut board), (1 << 16, FORCED));
    assert_eq!(return_address(&mut board), PROGRAM + 2);
    // Ones clear.
    board.set_system_register(CFSR, 1 << 16);
    board.set_system_register(HFSR, FORCED);
    assert_eq!(status(&mut board), (0, 0));
}

#[test]
fn an_enabled_fault_is_entered_if_its_priority_allows() {
    let mut board = Board::new(&[UDF]);
    board.set_system_register(SHCSR, 7 << 16);
    board.enters(6);
    assert_eq!(status(&mut board), (1 << 16, 0));
    // In its own handler it is not: the same again is a hard fault.
    board.code(handler(6), &[UDF]);
    board.enters(3);
    assert_eq!(status(&mut board), (1 << 16, FORCED));
    assert_eq!(board.register(14), 0xFFFF_FFF1);
    // Nor with PRIMASK.
    let mut board = Board::new(&[0xB672, UDF]);
    board.set_system_register(SHCSR, 7 << 16);
    board.execute(1);
    board.enters(3);
}

#[test]
fn reads_of_nothing_are_precise_and_writes_are_not() {
    let mut board = Board::new(&[LDR, STR, NOP]);
    board.set_register(0, 0x6000_0000);
    board.enters(3);
    assert_eq!(status(&mut board), (1 << 9 | 1 << 15, FORCED));
    assert_eq!(board.system_register(BFAR), 0x6000_0000);
    assert_eq!(return_address(&mut board), PROGRAM);
    let mut board = Board::new(&[STR, NOP]);
    board.set_register(0, 0x6000_0000);
    board.execute(1);
    board.enters(3);
    assert_eq!(status(&mut board), (1 << 10, FORCED));
    assert_eq!(return_address(&mut board), PROGRAM + 2);
    // ACTLR.DISDEFWBUF
    let mut board = Board::new(&[STR, NOP]);
    board.set_register(0, 0x6000_0000);
    board.set_system_register(0xE000_E008, 2);
    board.enters(3);
    assert_eq!(status(&mut board).0, 1 << 9 | 1 << 15);
    assert_eq!(return_address(&mut board), PROGRAM);
    // A fetch: BX r0.
    let mut board = Board::new(&[0x4700]);
    board.set_register(0, 0x1000_0001);
    board.execute(1);
    board.enters(3);
    assert_eq!(status(&mut board), (1 << 8, FORCED));
    assert_eq!(return_address(&mut board), 0x1000_0000);
}

#[test]
fn a_stack_that_grows_too_far_ends_in_the_hard_faults_handler() {
    // PUSH {r0-r7} at the end of SRAM: writes below it are lost, then the frame is.
    let mut board = Board::new(&[0xB4FF, NOP]);
    board.set_register(13, SRAM + 8);
    board.execute(1);
    assert_eq!(board.register(13), SRAM + 8 - 32);
    board.enters(3);
    assert_eq!(status(&mut board), (1 << 10 | 1 << 12, FORCED));
    assert_eq!(board.register(13), SRAM + 8 - 64);
    // The handler runs while it does not need the stack; its return is a fault on the way to the
    // program, and so the handler's again. A read of its own is a lockup.
    board.enters(3);
    assert_eq!(status(&mut board).0, 1 << 10 | 1 << 11 | 1 << 12);
    // POP {r0}
    board.code(handler(3), &[0xBC01]);
    let pc = handler(3);
    assert_eq!(board.step(), Step::Lockup { pc });
}

#[test]
fn a_frame_that_cannot_be_written_is_a_bus_fault_if_that_is_enabled() {
    let mut board = Board::new(&[NOP]);
    board.set_system_register(SHCSR, 7 << 16);
    // Interrupt 0 at 0x40, bus fault at 0: it comes first, and the interrupt behind it.
    board.set_system_register(0xE000_E400, 0x40);
    board.set_system_register(0xE000_E100, 1);
    board.set_register(13, SRAM + 4);
    board.pend(0);
    board.enters(5);
    assert_eq!(status(&mut board), (1 << 12, 0));
    board.enters(16);
}

#[test]
fn a_fault_in_the_hard_faults_handler_locks_up() {
    let mut board = Board::new(&[UDF]);
    board.code(handler(3), &[NOP, UDF]);
    board.enters(3);
    board.execute(1);
    for _ in 0..3 {
        let pc = handler(3) + 2;
        assert_eq!(board.step(), Step::Lockup { pc });
    }
    // An interrupt does not end that, NMI does.
    board.set_system_register(0xE000_E100, 1);
    board.pend(0);
    assert!(matches!(board.step(), Step::Lockup { .. }));
    board.pend_nmi();
    board.enters(2);
}

#[test]
fn unaligned_and_division_traps() {
    // LDRD r1, r2, [r0]; LDM r0, {r1, r2}; VLDR s0, [r0]; LDREX r1, [r0]
    let always: [&[u16]; 4] = [
        &[0xE9D0, 0x1200],
        &[0xE890, 0x0006],
        &[0xED90, 0x0A00],
        &[0xE850, 0x1F00],
    ];
    for code in always {
        let mut board = Board::new(code);
        board.set_register(0, SRAM + 2);
        board.enters(3);
        assert_eq!(status(&mut board).0, 1 << 24, "{code:04x?}");
    }
    let mut board = Board::new(&[LDR, 0xFBB1, 0xF1F2]);
    board.set_register(0, SRAM + 2);
    board.execute(2);
    // CCR.UNALIGN_TRP and DIV_0_TRP
    for (at, bits) in [(PROGRAM, 1 << 24), (PROGRAM + 2, 1 << 25)] {
        board.start(at);
        board.set_system_register(CCR, 0x218);
        board.enters(3);
        assert_eq!(status(&mut board).0, bits);
    }
}

#[test]
fn invalid_state_and_invalid_returns() {
    // BX r0 to an even address faults at its target.
    let mut board = Board::new(&[0x4700]);
    board.set_register(0, PROGRAM + 8);
    board.execute(1);
    board.enters(3);
    assert_eq!(status(&mut board).0, 1 << 17);
    assert_eq!(return_address(&mut board), PROGRAM + 8);
    // A return to a handler from the only one: MVN lr, #14 is 0xFFFFFFF1.
    let mut board = Board::new(&[NOP]);
    board.set_system_register(SHCSR, 7 << 16);
    board.set_system_register(0xE000_E100, 1);
    board.code(handler(16), &[0xF06F, 0x0E0E, 0x4770]);
    board.pend(0);
    board.enters(16);
    let sp = board.register(13);
    board.execute(1);
    board.enters(6);
    assert_eq!(status(&mut board), (1 << 18, 0));
    assert_eq!(board.register(13), sp);
}

#[test]
fn breakpoints_without_a_debugger_and_svc() {
    let mut board = Board::new(&[0xBEAB]);
    board.execute(1);
    board.enters(3);
    assert_eq!(board.system_register(HFSR), 1 << 31);
    assert_eq!(return_address(&mut board), PROGRAM);
    let mut board = Board::new(&[0xDF07]);
    board.execute(1);
    board.enters(11);
    assert_eq!(return_address(&mut board), PROGRAM + 2);
    // Masked, it is a hard fault.
    let mut board = Board::new(&[0xB672, 0xDF07]);
    board.execute(2);
    board.enters(3);
    assert_eq!(board.system_register(HFSR), FORCED);
}

/// Region `number` with this base, size of 2^`exponent`, and further bits of RASR.
fn region(board: &mut Core, number: u32, base: u32, exponent: u32, bits: u32) {
    board.set_system_register(0xE000_ED9C, base | 1 << 4 | number);
    board.set_system_register(0xE000_EDA0, bits | (exponent - 1) << 1 | 1);
}

const FULL: u32 = 3 << 24;
const READ_ONLY: u32 = 6 << 24;
const NO_EXECUTION: u32 = 1 << 28;

/// A board whose MPU is on, with the default map for privileged code and memory faults enabled.
fn protected(program: &[u16]) -> Board {
    let mut board = Board::new(program);
    board.set_system_register(SHCSR, 7 << 16);
    board.set_system_register(0xE000_ED94, 5);
    board
}

#[test]
fn the_mpu_forbids_by_region_and_subregion() {
    let mut board = protected(&[LDR]);
    region(&mut board, 0, SRAM + 0x1000, 8, 0);
    let mut reads = |address, allowed| {
        board.start(PROGRAM);
        board.set_system_register(SHCSR, 7 << 16);
        board.set_system_register(0xE000_ED94, 5);
        region(&mut board, 0, SRAM + 0x1000, 8, 1 << 9);
        region(&mut board, 3, SRAM + 0x1080, 5, READ_ONLY);
        board.set_register(0, address);
        if allowed {
            board.execute(1);
        } else {
            board.enters(4);
            assert_eq!(board.system_register(CFSR), 1 << 1 | 1 << 7);
            assert_eq!(board.system_register(MMFAR), address);
        }
    };
    reads(SRAM + 0xFFC, true);
    reads(SRAM + 0x1000, false);
    reads(SRAM + 0x101C, false);
    // Its second eighth is not part of it; a region of higher number counts.
    reads(SRAM + 0x1020, true);
    reads(SRAM + 0x1040, false);
    reads(SRAM + 0x1080, true);
    reads(SRAM + 0x10A0, false);
    reads(SRAM + 0x1100, true);
    let mut board = protected(&[STR]);
    region(&mut board, 0, SRAM + 0x1000, 8, READ_ONLY);
    board.set_register(0, SRAM + 0x1000);
    board.enters(4);
}

#[test]
fn the_mpu_forbids_to_execute_and_to_stack() {
    // BX r0
    let mut board = protected(&[0x4700, NOP]);
    region(&mut board, 0, SRAM, 12, FULL | NO_EXECUTION);
    board.set_register(0, SRAM | 1);
    board.execute(1);
    board.enters(4);
    assert_eq!(status(&mut board), (1, 0));
    assert_eq!(return_address(&mut board), SRAM);
    // Kept instructions are checked too, and again when the MPU changes.
    let mut board = protected(&[NOP, NOP]);
    board.execute(1);
    region(&mut board, 0, FLASH + 0x1000, 12, FULL | NO_EXECUTION);
    board.enters(4);
    assert_eq!(status(&mut board), (1, 0));
    // The frame.
    let mut board = protected(&[NOP]);
    region(&mut board, 0, STACK - 0x1000, 12, READ_ONLY);
    board.set_system_register(0xE000_E100, 1);
    board.set_system_register(0xE000_E400, 0x40);
    board.pend(0);
    board.enters(4);
    assert_eq!(status(&mut board), (1 << 4, 0));
}

#[test]
fn unprivileged_code_has_its_own_rights() {
    // MSR CONTROL, r1; LDR r1, [r0]
    let mut board = Board::new(&[0xF381, 0x8814, LDR]);
    board.set_register(0, 0xE000_ED00);
    board.set_register(1, 1);
    board.execute(1);
    board.enters(3);
    assert_eq!(status(&mut board), (1 << 9 | 1 << 15, FORCED));
    // The MPU without the default map: code needs a region.
    let mut board = Board::new(&[0xF381, 0x8814, NOP]);
    board.set_system_register(SHCSR, 7 << 16);
    region(&mut board, 0, FLASH, 20, 1 << 24);
    board.set_system_register(0xE000_ED94, 1);
    board.set_register(1, 1);
    board.execute(1);
    // Neither the instruction nor the frame is permitted.
    board.enters(4);
    assert_eq!(status(&mut board).0, 1 | 1 << 4);
}

#[test]
fn devices_execute_nothing() {
    let mut board = Board::new(&[0x4700]);
    board.set_register(0, 0x4000_0001);
    board.execute(1);
    board.enters(3);
    assert_eq!(status(&mut board), (1, FORCED));
}

#[test]
fn a_vector_that_cannot_be_read_is_a_hard_fault() {
    let mut board = Board::new(&[NOP]);
    board.set_system_register(0xE000_E100, 1);
    // The table's end, behind which there is no flash.
    board.set_system_register(0xE000_ED08, FLASH + 0x8000 - 0x80);
    board.set_word(FLASH + 0x8000 - 0x80 + 12, handler(3) | 1);
    board.set_system_register(0xE000_E100, 1 << 31);
    board.pend(31);
    board.enters(3);
    assert_eq!(board.system_register(HFSR), 1 << 1);
}
