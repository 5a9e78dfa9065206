//! Entry, return, preemption, tail-chaining, masks, sleep. Source: DDI 0403, B1.5.

use armbridge_stm32_emulator::core::Step;

use crate::board::{Board, PROGRAM, SRAM, STACK, handler};

const ISER: u32 = 0xE000_E100;
const PRIORITIES: u32 = 0xE000_E400;
const AIRCR: u32 = 0xE000_ED0C;
const SCR: u32 = 0xE000_ED10;
const NOP: u16 = 0xBF00;

/// A board with interrupts 0 to 3 enabled, at these priorities.
fn board(program: &[u16], priorities: [u8; 4]) -> Board {
    let mut board = Board::new(program);
    board.set_system_register(PRIORITIES, u32::from_le_bytes(priorities));
    board.set_system_register(ISER, 15);
    board
}

#[test]
fn the_frame_is_on_the_stack_and_comes_back() {
    let mut board = board(&[NOP, NOP], [0; 4]);
    for number in 0..13 {
        board.set_register(number, 100 + number as u32);
    }
    board.set_register(13, STACK - 4);
    board.set_register(14, 114);
    board.set_xpsr(0xA90F_0000);
    board.execute(1);
    board.pend(0);
    board.enters(16);
    // The stack was a multiple of 4, not of 8: bit 9 of the status.
    let sp = board.register(13);
    assert_eq!(sp, STACK - 40);
    let frame: Vec<u32> = (0..8).map(|place| board.word(sp + place * 4)).collect();
    let expected = [100, 101, 102, 103, 112, 114, PROGRAM + 2, 0xA90F_0200];
    assert_eq!(frame, expected);
    assert_eq!(board.register(14), 0xFFFF_FFF9);
    assert_eq!(board.xpsr(), 0xA90F_0010);
    board.execute(1);
    assert_eq!(board.register(13), STACK - 4);
    assert_eq!(board.register(15), PROGRAM + 2);
    assert_eq!(board.xpsr(), 0xA90F_0000);
    assert_eq!(board.register(12), 112);
}

#[test]
fn a_lower_number_preempts_and_equal_groups_do_not() {
    let mut board = board(&[NOP], [0x20, 0x10, 0x20, 0x28]);
    board.code(handler(16), &[NOP, NOP, 0x4770]);
    board.pend(0);
    board.enters(16);
    board.pend(2);
    board.pend(3);
    board.execute(1);
    board.pend(1);
    board.enters(17);
    assert_eq!(board.register(14), 0xFFFF_FFF1);
    // Back to handler 0, for the others have its priority: BX lr, NOP. Then they are chained.
    board.execute(1);
    assert_eq!(board.exception(), 16);
    board.execute(1);
    board.enters(18);
    assert_eq!(board.register(14), 0xFFFF_FFF9);
    board.enters(19);
    board.execute(1);
    assert_eq!((board.exception(), board.register(13)), (0, STACK));
    assert_eq!(board.executed_in(16), 3);
    assert_eq!(board.executed_in(17), 1);
}

#[test]
fn subpriorities_order_but_do_not_preempt() {
    // Two bits of group: 0x40 and 0x60 differ in the subpriority.
    let mut board = board(&[NOP], [0x60, 0x40, 0x50, 0]);
    board.set_system_register(AIRCR, 0x05FA_0000 | 6 << 8);
    board.code(handler(16), &[NOP, 0x4770]);
    board.pend(0);
    board.enters(16);
    board.pend(1);
    board.pend(2);
    board.execute(1);
    // They come in the order of their subpriorities.
    board.enters(17);
    board.enters(18);
    // Without the key nothing changes.
    board.set_system_register(AIRCR, 0);
    assert_eq!(board.system_register(AIRCR), 0xFA05_0600);
}

#[test]
fn tail_chaining_takes_no_frame() {
    let mut board = board(&[NOP], [0; 4]);
    board.pend(1);
    board.pend(0);
    let entry = board.step();
    assert_eq!(
        (entry, entry.cycles()),
        (
            Step::Entered {
                exception: 16,
                cycles: 12
            },
            12
        )
    );
    let sp = board.register(13);
    board.set_register(0, 77);
    let chained = board.step();
    assert_eq!(
        chained,
        Step::Entered {
            exception: 17,
            cycles: 6
        }
    );
    assert_eq!(board.register(13), sp);
    assert_eq!(board.register(14), 0xFFFF_FFF9);
    // What the first left in r0 is there, until the frame is restored.
    assert_eq!(board.register(0), 77);
    board.execute(1);
    assert_eq!((board.register(0), board.register(13)), (0, STACK));
}

/// VMOV s0, r0.
const USE_FLOAT: [u16; 2] = [0xEE00, 0x0A10];

#[test]
fn floating_point_state_survives_chained_handlers_that_use_the_unit() {
    let [a, b] = USE_FLOAT;
    let mut board = board(&[a, b, NOP], [0; 4]);
    for exception in [16, 17] {
        // MOVS r0, #99; VMOV s0, r0; BX lr
        board.code(handler(exception), &[0x2063, a, b, 0x4770]);
    }
    board.set_register(0, 0x4048_F5C3);
    board.execute(1);
    assert_eq!(board.control(), 4);
    board.pend(0);
    board.pend(1);
    board.enters(16);
    // 26 words are reserved, and not written yet.
    let sp = board.register(13);
    assert_eq!(sp, STACK - 104);
    assert_eq!(board.register(14), 0xFFFF_FFE9);
    assert_eq!(board.control(), 0);
    assert_eq!(board.word(sp + 32), 0);
    assert_eq!(board.system_register(0xE000_EF38), sp + 32);
    assert_eq!(board.system_register(0xE000_EF34) & 1, 1);
    board.execute(2);
    assert_eq!(board.word(sp + 32), 0x4048_F5C3);
    assert_eq!(board.system_register(0xE000_EF34) & 1, 0);
    assert_eq!(board.float(0), 99);
    // The second handler uses the unit too, and its state is not kept.
    board.enters(17);
    assert_eq!(board.register(14), 0xFFFF_FFE9);
    board.execute(3);
    assert_eq!(board.float(0), 0x4048_F5C3);
    assert_eq!((board.control(), board.register(13)), (4, STACK));
}

#[test]
fn unused_floating_point_state_is_not_stacked_and_nested_state_is() {
    let [a, b] = USE_FLOAT;
    let mut board = board(&[a, b, NOP], [0x20, 0x10, 0, 0]);
    board.code(handler(16), &[0x2063, a, b, NOP, 0x4770]);
    board.code(handler(17), &[0x2058, a, b, 0x4770]);
    board.set_register(0, 11);
    board.execute(1);
    // A handler that does not use it.
    board.set_system_register(ISER, 4);
    board.pend(2);
    board.enters(18);
    let sp = board.register(13);
    board.execute(1);
    assert_eq!((board.word(sp + 32), board.float(0)), (0, 11));
    // One that does, preempted by another that does.
    board.pend(0);
    board.enters(16);
    board.execute(2);
    board.pend(1);
    board.enters(17);
    assert_eq!(board.register(14), 0xFFFF_FFE1);
    board.execute(2);
    assert_eq!(board.float(0), 88);
    board.execute(1);
    assert_eq!((board.exception(), board.float(0)), (16, 99));
    board.execute(2);
    assert_eq!((board.exception(), board.float(0)), (0, 11));
}

#[test]
fn a_high_line_is_pending_again_behind_its_handler() {
    let mut board = board(&[NOP], [0; 4]);
    board.code(handler(16), &[NOP, 0x4770]);
    board.set_line(0, true);
    board.enters(16);
    assert_eq!(board.system_register(0xE000_E200), 0);
    board.execute(1);
    board.enters(16);
    // It falls while the handler runs.
    board.set_line(0, false);
    board.execute(2);
    assert_eq!(board.exception(), 0);
    // A pulse is latched, and cleared by the program only while the line is low.
    board.set_system_register(0xE000_E180, 1);
    board.set_line(0, true);
    board.set_system_register(0xE000_E280, 1);
    assert_eq!(board.system_register(0xE000_E200), 1);
    board.set_line(0, false);
    assert_eq!(board.system_register(0xE000_E200), 1);
    board.set_system_register(0xE000_E280, 1);
    assert_eq!(board.system_register(0xE000_E200), 0);
}

#[test]
fn masks_hold_exceptions_back() {
    // CPSID i; NOP; CPSIE i
    let mut board = board(&[0xB672, NOP, 0xB662], [0x40, 0x30, 0, 0]);
    board.execute(1);
    board.pend(0);
    board.execute(2);
    board.enters(16);
    board.execute(1);
    // MSR BASEPRI, r0: 0x40 holds 0x40 back, not 0x30. Low bits do not exist.
    board.code(PROGRAM, &[0xF380, 0x8811, NOP, NOP]);
    board.set_register(15, PROGRAM);
    board.set_register(0, 0x4F);
    board.execute(1);
    board.pend(0);
    board.execute(1);
    board.pend(1);
    board.enters(17);
    board.execute(2);
    assert_eq!(board.exception(), 0);
}

#[test]
fn waiting_ends_with_what_would_be_entered() {
    // CPSID i; WFI; NOP
    let mut board = board(&[0xB672, 0xBF30, NOP, NOP], [0x40, 0, 0, 0]);
    board.execute(2);
    assert_eq!(board.step(), Step::Sleeping);
    // Not enabled.
    board.pend(5);
    assert_eq!(board.step(), Step::Sleeping);
    board.pend(0);
    board.execute(1);
    assert_eq!(board.exception(), 0);
    // Without PRIMASK it is entered.
    board.code(PROGRAM, &[0xB662, 0xBF30]);
    board.set_register(15, PROGRAM);
    board.execute(1);
    board.enters(16);
}

#[test]
fn events_end_wfe() {
    // SEV; WFE; WFE; NOP
    let mut board = board(&[0xBF40, 0xBF20, 0xBF20, NOP, 0xBF20, NOP], [0; 4]);
    board.execute(3);
    assert_eq!(board.step(), Step::Sleeping);
    board.send_event();
    board.execute(1);
    // SEVONPEND: an interrupt that is not enabled.
    board.set_system_register(SCR, 1 << 4);
    board.execute(1);
    assert_eq!(board.step(), Step::Sleeping);
    board.pend(9);
    board.execute(1);
    assert_eq!(board.exception(), 0);
}

#[test]
fn sleep_on_exit() {
    let mut board = board(&[NOP, NOP], [0; 4]);
    board.set_system_register(SCR, 1 << 1);
    board.pend(0);
    board.enters(16);
    board.execute(1);
    assert_eq!(board.step(), Step::Sleeping);
    board.pend(0);
    board.enters(16);
    assert_eq!(board.word(STACK - 8), PROGRAM);
}

#[test]
fn the_process_stack_is_thread_modes_alone() {
    // MSR PSP, r0; MSR CONTROL, r1; PUSH {r1}
    let mut board = board(&[0xF380, 0x8809, 0xF381, 0x8814, 0xB402], [0; 4]);
    board.set_register(0, SRAM + 0x1000);
    board.set_register(1, 2);
    board.execute(3);
    assert_eq!(board.register(13), SRAM + 0xFFC);
    board.pend(0);
    board.enters(16);
    assert_eq!(
        (board.register(13), board.register(14)),
        (STACK, 0xFFFF_FFFD)
    );
    // The frame is a multiple of 8 on the other.
    assert_eq!(board.word(SRAM + 0xFF8 - 32 + 24), PROGRAM + 10);
    board.execute(1);
    assert_eq!((board.register(13), board.control()), (SRAM + 0xFFC, 2));
}

#[test]
fn time_is_the_callers() {
    let mut board = board(&[NOP], [0; 4]);
    // DEMCR.TRCENA and DWT_CTRL.CYCCNTENA; both are needed.
    board.set_system_register(0xE000_1000, 1);
    board.advance(10);
    assert_eq!(board.system_register(0xE000_1004), 0);
    board.set_system_register(0xE000_EDFC, 1 << 24);
    board.advance(1_000);
    assert_eq!(board.system_register(0xE000_1004), 1_000);
    board.set_system_register(0xE000_1004, u32::MAX);
    board.advance(3);
    assert_eq!(board.system_register(0xE000_1004), 2);
    // SysTick: 100 cycles a period, the first from the written 0.
    board.set_system_register(0xE000_E014, 99);
    board.set_system_register(0xE000_E018, 1);
    board.set_system_register(0xE000_E010, 7);
    assert_eq!(board.systick_due(), Some(100));
    board.advance(99);
    board.execute(1);
    board.advance(1);
    board.enters(15);
    assert_eq!(board.system_register(0xE000_E010), 7 | 1 << 16);
    assert_eq!(board.system_register(0xE000_E010), 7);
    board.execute(1);
    board.advance(100);
    board.enters(15);
    assert_eq!(board.cycles(), 10 + 1_000 + 3 + 200);
}

#[test]
fn a_reset_leaves_what_silicon_leaves() {
    let mut board = board(&[NOP], [0x40, 0, 0, 0]);
    board.set_system_register(0xE000_EDFC, 1 << 24);
    board.set_register(5, 55);
    // STR r1, [r0]: AIRCR.SYSRESETREQ.
    board.code(PROGRAM, &[0x6001]);
    board.set_register(0, AIRCR);
    board.set_register(1, 0x05FA_0004);
    board.execute(1);
    assert_eq!(board.step(), Step::ResetRequested);
    let Board { core, chip } = &mut board;
    core.reset(chip).unwrap();
    assert_eq!((board.register(13), board.register(15)), (STACK, PROGRAM));
    assert_eq!(board.register(5), 55);
    assert_eq!(board.system_register(0xE000_EDFC), 1 << 24);
    assert_eq!(board.system_register(ISER), 0);
    assert_eq!(board.system_register(PRIORITIES), 0);
    // The unit is off again, and an instruction of it has no coprocessor.
    let [a, b] = USE_FLOAT;
    board.code(PROGRAM, &[a, b]);
    board.enters(3);
    assert_eq!(board.system_register(0xE000_ED28), 1 << 19);
}

#[test]
fn cycles_of_the_table() {
    // MOVS; LDR, LDR of a pair; STR and a load behind it; LDM of 3; a branch; VDIV, VADD and
    // VFMA, each of the result before; UDIV of 1 by 1 and of 2^31 by 1.
    #[rustfmt::skip]
    let code = [
        0x2001, 0x6819, 0x681A, 0xBF00, 0x601A, 0x6819, 0xCB70, 0xE7FF, 0xEE80, 0x0A20, 0xEE30,
        0x1A00, 0xEEA1, 0x0A01, 0xFBB0, 0xF1F0, 0xFBB7, 0xF1F0,
    ];
    let mut board = board(&code, [0; 4]);
    board.set_register(3, SRAM);
    board.set_register(7, 1 << 31);
    let steps = (0..13).map(|_| board.step());
    let cycles: Vec<u32> = steps.map(Step::cycles).collect();
    assert_eq!(cycles, [1, 2, 1, 1, 1, 1, 4, 3, 14, 2, 4, 3, 12]);
}

#[test]
fn bit_band_aliases() {
    let mut board = board(&[0x6001, 0x6802], [0; 4]);
    board.set_word(SRAM + 0x40, 0xF0);
    // Bit 9 of the word at SRAM + 0x40.
    board.set_register(0, 0x2200_0000 + 0x41 * 32 + 4);
    board.set_register(1, 0xFFFF);
    board.execute(2);
    assert_eq!((board.word(SRAM + 0x40), board.register(2)), (0x2F0, 1));
}
