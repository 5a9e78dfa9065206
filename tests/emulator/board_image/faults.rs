//! Failures while the arm is driven: each ends with the motors off and the relay open, and
//! the next hello names it.

use armbridge_link::message::{Command, Drive, End, Fault, LastEnd, Mode, StopSource, ToBoard};
use armbridge_stm32_emulator::peripherals::rcc::Reset;
use armbridge_tests::board_image::BoardRun;
use armbridge_tests::tapped_bench::{Action, ScriptedHost, TappedHost};

use super::TestBoard;

/// From a failure to the motors off by the handler's stop sequence, in ms. Its first packet does,
/// or, where a failure cut off a packet of the tick, the second, after 2.1 ms of flush.
const HANDLER_MS: f64 = 4.0;
/// The same by the stop sequence of the next program: memory is cleared first, in 2.3 ms at
/// 16 MHz. A reset may cut off a packet, too.
const BOOT_MS: f64 = 2.3 + HANDLER_MS;
/// From the last good tick to the watchdog's bite at its nominal rate, in ms.
const WATCHDOG_MS: f64 = 165.0;

/// Number of the tick's interrupt (TIM5) among the exceptions.
const TICK: u16 = 16 + 50;

/// A host that arms and regulates, on USB from this time on, in µs.
pub(super) fn driver(from_us: u64) -> ScriptedHost {
    let actions = [
        (0, Action::Message(ToBoard::Heartbeat)),
        (from_us, Action::Command(Command::Arm { session: 0 })),
        (
            from_us + 100_000,
            Action::Command(Command::Regulate([0.0, 0.0])),
        ),
    ];
    ScriptedHost::new(actions, u64::MAX)
}

/// A board that holds the arm.
pub(super) fn driving(board: TestBoard) -> BoardRun<ScriptedHost> {
    let mut run = board.with(driver(150_000)).powered_up();
    let is_driven = run.run_until(1_500, |run| {
        let last = run.records().next_back();
        last.is_some_and(|record| record.mode.drive() == Some(Drive::Regulate))
    });
    assert!(is_driven, "{:?}", run.records().next_back());
    run.run_for(20);
    assert!(!are_off(&run));
    run
}

/// Whether both motors are off. The stop sequence sends a value one count off before 1000:
/// a servo applies only a value that differs from the last.
pub(super) fn is_off(pwm: [u16; 2]) -> bool {
    pwm.iter().all(|pwm| pwm.abs_diff(1_000) <= 1)
}

/// The same of a board's servos.
pub(super) fn are_off(run: &BoardRun<ScriptedHost>) -> bool {
    let bench = &run.machine.system.line.bench;
    is_off([0, 1].map(|servo| bench.applied_pwm(servo)))
}

/// Time at which the second motor went off; `None` while one is on.
///
/// A servo reports its new PWM some µs before the bridge of its motor follows.
fn off_ns(run: &BoardRun<ScriptedHost>) -> Option<u64> {
    let bench = &run.machine.system.line.bench;
    let [first, second] = [0, 1].map(|servo| bench.last_on_ns(servo).1);
    Some(first?.max(second?))
}

/// Executes single instructions until `is_met`.
fn step_until(run: &mut BoardRun<ScriptedHost>, is_met: impl Fn(&BoardRun<ScriptedHost>) -> bool) {
    let latest = run.machine.now() + super::us(20_000);
    while !is_met(run) {
        assert!(run.machine.now() < latest);
        run.machine.step(latest).unwrap();
    }
}

/// Lets the board fail, sees the motors go off within a time, the relay open, and returns the
/// end that the next program reports.
#[track_caller]
fn end_of(
    board: TestBoard,
    fail: impl FnOnce(&mut BoardRun<ScriptedHost>),
    within_ms: f64,
) -> LastEnd {
    let mut run = driving(board);
    let (begun, edges) = (run.machine.now(), run.machine.system.edges().len());
    fail(&mut run);
    assert!(run.run_until(begun.as_us() / 1_000 + 1_000, |run| off_ns(run).is_some()));
    let took_ms = (off_ns(&run).unwrap() - begun.as_ns()) as f64 * 1e-6;
    assert!(took_ms <= within_ms, "{took_ms} ms");
    let relay = run.machine.system.board.supply;
    let mut changes = run.machine.system.edges()[edges..].iter();
    let opened = changes
        .find(|edge| edge.pin == relay)
        .expect("the relay opens");
    assert!(!opened.is_high);

    // The next program: idle, and it says what happened.
    run.host = TappedHost::new(ScriptedHost::new(
        [(0, Action::Message(ToBoard::Heartbeat))],
        u64::MAX,
    ));
    assert!(run.run_until(begun.as_us() / 1_000 + 1_000, |run| {
        run.machine.resets().len() > 1 && run.report().is_some()
    }));
    run.run_for(30);
    assert!(are_off(&run));
    assert_eq!(
        run.records().next_back().map(|record| record.mode),
        Some(Mode::Idle)
    );
    run.report().unwrap().last_end
}

fn a_panic_stops_the_motors_and_is_named(board: TestBoard) {
    let end = end_of(
        board,
        |run| {
            step_until(run, |run| run.machine.core.exception() == 0);
            // `panic_bounds_check(index, len, place)`, called with a place of its own.
            let image = armbridge_tests::board_image::image(board.image);
            let panic = image.symbol_with("panic_bounds_check").unwrap();
            let free = 0x2000_0400_u32;
            let at = (free - 0x2000_0000) as usize;
            let sram = &mut run.machine.system.sram;
            sram[at..at + 8].copy_from_slice(b"here.rs\0");
            for (index, word) in [free, 7, 42, 1].into_iter().enumerate() {
                let at = at + 8 + 4 * index;
                sram[at..at + 4].copy_from_slice(&word.to_le_bytes());
            }
            for (register, value) in [(0, 5), (1, 3), (2, free + 8), (15, panic)] {
                run.machine.core.set_register(register, value);
            }
        },
        HANDLER_MS,
    );
    assert_eq!((end.cause, end.line), (End::Panic, 42));
    assert_eq!(&end.place[..7], b"here.rs");
}

fn a_fault_of_the_processor_stops_the_motors_and_is_named(board: TestBoard) {
    let end = end_of(
        board,
        |run| {
            step_until(run, |run| run.machine.core.exception() == 0);
            // Nothing is there.
            run.machine.core.set_register(15, 0x3000_0000);
        },
        HANDLER_MS,
    );
    assert_eq!(end.cause, End::HardFault);
}

fn a_stack_that_overflows_stops_the_motors_and_is_named(board: TestBoard) {
    let end = end_of(
        board,
        |run| {
            step_until(run, |run| run.machine.core.exception() == 0);
            run.machine.core.set_register(13, 0x2000_0010);
        },
        HANDLER_MS,
    );
    assert_eq!(end.cause, End::StackOverflow);
}

fn a_tick_that_hangs_is_ended_by_the_watchdog(board: TestBoard) {
    let end = end_of(
        board,
        |run| {
            step_until(run, |run| run.machine.core.exception() == TICK);
            // A branch to itself.
            let flash = run.machine.system.flash.bytes();
            let found = flash
                .chunks(2)
                .position(|halfword| halfword == [0xFE, 0xE7]);
            let pc = 0x0800_0000 + 2 * found.unwrap() as u32;
            run.machine.core.set_register(15, pc);
        },
        WATCHDOG_MS + BOOT_MS,
    );
    assert_eq!(end.cause, End::Watchdog);
}

fn a_supply_that_sags_stops_the_motors_and_is_named(board: TestBoard) {
    let sag = |run: &mut BoardRun<ScriptedHost>| {
        run.machine.system.supply_mv = 2_850;
        run.machine.system.touch();
        run.run_for(1);
        run.machine.system.supply_mv = 3_300;
        run.machine.system.touch();
    };
    let end = end_of(board, sag, HANDLER_MS);
    assert_eq!(end.cause, End::BrownOut);
}

fn a_crystal_that_stops_ends_the_drive_and_is_named(board: TestBoard) {
    let fail = |run: &mut BoardRun<ScriptedHost>| {
        let now = run.machine.now();
        let crystal = run.machine.system.board.crystal;
        run.machine.system.rcc.fail_crystal(now);
        run.machine.system.touch();
        run.run_for(1);
        // It swings again at the next boot.
        run.machine.system.rcc.mend_crystal(crystal);
    };
    assert_eq!(end_of(board, fail, HANDLER_MS).cause, End::Crystal);
}

fn resets_from_outside_are_named(board: TestBoard) {
    let reset = |cause| move |run: &mut BoardRun<ScriptedHost>| run.machine.reset(cause).unwrap();
    assert_eq!(
        end_of(board, reset(Reset::Pin), BOOT_MS).cause,
        End::ResetPin
    );
    assert_eq!(
        end_of(board, reset(Reset::BrownOut), BOOT_MS).cause,
        End::BrownOut
    );
    // Power was gone: memory is noise.
    assert_eq!(
        end_of(board, reset(Reset::PowerUp), BOOT_MS).cause,
        End::PowerUp
    );
}

fn the_stop_switch_stops_the_motors_within_two_ticks(board: TestBoard) {
    let mut run = driving(board);
    let now = run.machine.now();
    let stop = run.machine.system.board.stop;
    // Open: the pull-up of the chip decides.
    run.machine.system.gpio.drive(now, stop, None);
    run.machine.system.touch();
    let begun_ms = now.as_us() / 1_000;
    assert!(run.run_until(begun_ms + 4, are_off));
    run.run_for(30);
    assert!(are_off(&run));
    let fault = Fault::EmergencyStop(StopSource::Pin);
    assert_eq!(
        run.records().next_back().map(|record| record.mode),
        Some(Mode::Fault(fault))
    );
    let system = &run.machine.system;
    assert!(!system.gpio.level(system.board.supply));
    assert_eq!(run.machine.resets().len(), 1);
}

on_each_board! {
    a_panic_stops_the_motors_and_is_named,
    a_fault_of_the_processor_stops_the_motors_and_is_named,
    a_stack_that_overflows_stops_the_motors_and_is_named,
    a_tick_that_hangs_is_ended_by_the_watchdog,
    a_supply_that_sags_stops_the_motors_and_is_named,
    a_crystal_that_stops_ends_the_drive_and_is_named,
    resets_from_outside_are_named,
    the_stop_switch_stops_the_motors_within_two_ticks,
}
