//! Boot: the first bytes on the bus, clocks, and the states that a chip may start in.

use armbridge_board::bridge::SERVO_IDS;
use armbridge_client::flash_image::{ERASED, FlashImage};
use armbridge_client::host::NoHost;
use armbridge_link::message::{End, Fault, Mode, StopSource, ToBoard};
use armbridge_servo::stop::{StopStep, stop_steps};
use armbridge_stm32_emulator::core::Start;
use armbridge_stm32_emulator::peripherals::rcc::Reset;
use armbridge_stm32_emulator::system::Unmodelled;
use armbridge_tests::board_image::BoardRun;
use armbridge_tests::paths;
use armbridge_tests::tapped_bench::{Action, ScriptedHost};

use super::{ON_USB_MS, TestBoard, settings_sectors, until_configured, us};

/// Bytes of the stop sequence.
fn stop_sequence() -> Vec<u8> {
    let steps = stop_steps(SERVO_IDS).map(|step| match step {
        StopStep::Send(packet) => packet.to_vec(),
        StopStep::Repeat(byte, count) => vec![byte; count.into()],
        StopStep::Pause { .. } => Vec::new(),
    });
    steps.flatten().collect()
}

/// A host that only says hello, and hears what the board says.
fn listener() -> ScriptedHost {
    ScriptedHost::new([(0, Action::Message(ToBoard::Heartbeat))], u64::MAX)
}

/// The stop sequence was the first on the bus after the byte with this index.
#[track_caller]
fn assert_stopped_first<H>(run: &BoardRun<H>, first: usize) {
    let sent = &run.machine.system.line.sent[first..];
    let stop = stop_sequence();
    let bytes: Vec<u8> = sent.iter().take(stop.len()).map(|byte| byte.byte).collect();
    assert_eq!(bytes, stop);
    // On the internal oscillator and at full speed the rate is exact.
    assert!(sent.iter().all(|byte| byte.baud == 1_000_000));
}

fn motors_are_off_first_and_clocks_are_those_that_the_program_names(board: TestBoard) {
    let mut run = board.with(NoHost).powered_up();
    until_configured(&mut run, ON_USB_MS);
    assert_stopped_first(&run, 0);
    let system = &run.machine.system;
    let first = system.line.sent[0].at;
    assert!(first < us(4_000), "{:.3} ms", first.as_ms());

    let clocks = system.rcc.clocks();
    assert_eq!((clocks.core_hz, clocks.usb_hz), (168_000_000, 48_000_000));
    assert_eq!((clocks.apb1_hz, clocks.apb2_hz), (42_000_000, 84_000_000));
    // Five wait states, prefetch, both caches.
    assert_eq!(system.flash.access_control(), 0x705);

    // Idle on the bus, the servos found and their relay on.
    let last = system.line.sent.last().unwrap().at;
    assert!(last + us(2_000) > run.machine.now(), "ticks go on");
    let relay: Vec<bool> = (system.edges().iter())
        .filter(|edge| edge.pin == system.board.supply)
        .map(|edge| edge.is_high)
        .collect();
    assert_eq!(relay, [true]);
    // The USB driver asks for endpoints before it starts the block's clock.
    let odd: Vec<Unmodelled> = (system.unmodelled())
        .filter(|access| !matches!(access, Unmodelled::NoClock(0x5000_0B00..0x5000_0C00)))
        .collect();
    assert_eq!(odd, []);
    assert_eq!(run.machine.resets().len(), 1);
}

/// The checksum is listed by `cargo release` and compared by `armbridge status`.
fn the_board_reports_the_checksum_of_its_file(board: TestBoard) {
    let mut run = board.with(listener()).powered_up();
    until_configured(&mut run, ON_USB_MS);
    run.run_for(50);
    let elf = std::fs::read(paths::firmware(board.image)).unwrap();
    let image = FlashImage::of_elf(&elf, ERASED).unwrap();
    assert_eq!(run.report().unwrap().image, Some(image.crc32()));
    // The bytes of a .bin file are those that the board runs.
    let flash = run.machine.system.flash.bytes();
    assert_eq!(image.address, 0x0800_0000);
    assert!(flash.starts_with(&image.bytes));
}

/// The ROM loader jumps to a program with its own vectors, stack and clocks.
fn a_program_that_the_rom_loader_started_resets_the_chip_once(board: TestBoard) {
    let mut run = board.with(listener()).powered_up();
    let rcc = &mut run.machine.system.rcc;
    // Crystal and PLL on, 1 * 192 / 2 = 96 MHz, the PLL chosen.
    let crystal = board.wiring.crystal;
    let started = 0x0001_0083 | u32::from(crystal.is_external) << 18;
    for (at_us, offset, value) in [
        (0, 0x00, started),
        (5_000, 0x04, 0x0440_3000 + crystal.hz / 1_000_000),
        (5_000, 0x00, started | 1 << 24),
        (6_000, 0x08, 2),
    ] {
        rcc.write(us(at_us), offset, value).unwrap();
    }
    run.machine.pass_time(us(7_000));
    let vectors = run.machine.system.flash.bytes();
    let word = |at: usize| u32::from_le_bytes(vectors[at..at + 4].try_into().unwrap());
    let pc = word(4);
    run.machine.start_at(Start {
        sp: 0x2000_2000,
        pc,
        vtor: 0x1FFF_0000,
        primask: false,
    });
    let before = run.machine.system.line.sent.len();
    until_configured(&mut run, ON_USB_MS);
    let causes: Vec<Reset> = run
        .machine
        .resets()
        .iter()
        .map(|reset| reset.cause)
        .collect();
    assert_eq!(causes, [Reset::PowerUp, Reset::Software]);
    assert_stopped_first(&run, before);
}

/// A crystal that does not start: the board says so, and drives nothing.
fn a_board_without_a_crystal_says_so_and_drives_nothing(board: TestBoard) {
    let mut run = board.with(listener());
    run.machine.system.rcc.fail_crystal(us(0));
    let mut run = run.powered_up();
    until_configured(&mut run, 2 * ON_USB_MS);
    run.run_for(50);
    assert_stopped_first(&run, 0);
    let fault = Fault::EmergencyStop(StopSource::Crystal);
    let last = run.records().next_back().map(|record| record.mode);
    assert_eq!(last, Some(Mode::Fault(fault)));
    let system = &run.machine.system;
    assert_eq!(system.rcc.clocks().core_hz, 168_000_000, "from 16 MHz");
    assert!(!system.gpio.level(system.board.supply));
}

/// Flash that holds garbage is erased at boot, which stops the core for 1.1 s. The board's
/// time and the watchdog take no harm from it.
fn time_goes_on_after_flash_was_erased_at_boot(board: TestBoard) {
    for sectors in [&[0][..], &[1], &[0, 1]] {
        let mut run = board.with(listener());
        for sector in sectors {
            settings_sectors(&mut run)[*sector].fill(0x5A);
        }
        let mut run = run.powered_up();
        until_configured(&mut run, ON_USB_MS + 3_500);
        run.run_for(100);
        assert!(!run.machine.system.flash.erased().is_empty());
        assert_eq!(run.machine.resets().len(), 1);

        // Each record's tick began, by the board's clock, when it is on the wire.
        let clock = run.machine.system.timer(5).started().unwrap();
        let starts: Vec<u64> = run.records().map(|record| record.input.start_us).collect();
        assert!(starts.len() > 50 && starts.is_sorted());
        let now_us = (run.machine.now() - clock).as_us();
        let age_us = now_us - starts.last().unwrap();
        assert!(age_us < 5_000, "{sectors:?}: {age_us} us");
        assert_eq!(run.report().unwrap().last_end.cause, End::PowerUp);
    }
}

on_each_board! {
    motors_are_off_first_and_clocks_are_those_that_the_program_names,
    a_program_that_the_rom_loader_started_resets_the_chip_once,
    a_board_without_a_crystal_says_so_and_drives_nothing,
    time_goes_on_after_flash_was_erased_at_boot,
    the_board_reports_the_checksum_of_its_file,
}
