//! Disturbances of a bench on a table: noise, cables that are pulled, other servos and
//! oscillators, flash that holds anything.

use armbridge_link::message::{Drive, End, Mode, SettingsFrom, ToBoard};
use armbridge_servo::Firmware;
use armbridge_sim::Bench;
use armbridge_sim::plant::Plant;
use armbridge_sim::servo_kind::ServoKind;
use armbridge_stm32_emulator::system::BusFaults;
use armbridge_tests::board_image::Interference;
use armbridge_tests::plant;
use armbridge_tests::random::Random;
use armbridge_tests::tapped_bench::{Action, ScriptedHost, assert_all_equal, replay};

use super::faults::{are_off, driver, driving};
use super::{ON_USB_MS, TestBoard, settings_sectors, until_configured};

/// Bytes from nowhere at any time: the board goes on or ends the drive, and never resets. What
/// it decided on the samples that it had is what this program decides.
fn noise_on_the_line_ends_a_drive_at_the_worst(board: TestBoard) {
    let mut held = 0;
    for (seed, mean_us) in [(1, 50), (2, 300), (3, 3_000), (4, 30_000), (5, 100_000)] {
        let mut run = driving(board);
        run.machine.system.line.interference = Some(Interference::new(seed, mean_us));
        run.machine.system.touch();
        run.run_for(400);
        let last = run.records().next_back().unwrap();
        assert_eq!(run.machine.resets().len(), 1, "{mean_us} us");
        let faults = run.machine.system.bus_faults();
        // A byte from nowhere may come while the board drives the line.
        assert_eq!((faults.undriven, faults.cut), (0, 0));
        assert!(
            last.input.start_us / 1_000 + 60 > run.machine.now().as_us() / 1_000 - 60,
            "ticks go on"
        );
        match last.mode {
            Mode::Running(_) | Mode::Degraded(_) => held += 1,
            mode => assert!(are_off(&run), "{mean_us} us: {mode:?}"),
        }
        assert_all_equal(&replay(&run.host.events));
    }
    // A byte in 3 ms and less harms no drive.
    assert!(held >= 3, "{held}");
}

/// The cable of a board that drives is pulled: the arm is braked, then motors are off. Plugged in
/// again, the board is found.
fn a_pulled_cable_ends_the_drive_and_a_plugged_one_finds_the_board(board: TestBoard) {
    let mut run = driving(board);
    run.machine.system.usb.is_plugged = false;
    run.machine.system.touch();
    run.run_for(600);
    assert!(are_off(&run));
    run.host = armbridge_tests::tapped_bench::TappedHost::new(ScriptedHost::new(
        [(0, Action::Message(ToBoard::Heartbeat))],
        u64::MAX,
    ));
    run.machine.system.usb.is_plugged = true;
    run.machine.system.touch();
    run.run_for(1);
    until_configured(&mut run, ON_USB_MS);
    run.run_for(50);
    assert!(matches!(
        run.records().next_back().unwrap().mode,
        Mode::Fault(_)
    ));
    assert_eq!(run.machine.resets().len(), 1);
}

/// A board that is powered long before its cable is plugged in.
fn a_cable_may_come_later_than_the_supply(board: TestBoard) {
    let mut run = board.with(driver(400_000));
    run.machine.system.usb.is_plugged = false;
    let mut run = run.powered_up();
    run.run_for(300);
    run.machine.system.usb.is_plugged = true;
    run.machine.system.touch();
    let is_driven = run.run_until(2_000, |run| {
        let last = run.records().next_back();
        last.is_some_and(|record| record.mode.drive() == Some(Drive::Regulate))
    });
    assert!(is_driven);
}

/// The watchdog's oscillator at either end of its range: it never bites a board that works, and
/// bites one that hangs within 304.5 ms.
fn the_watchdog_is_right_at_17_and_at_47_khz(board: TestBoard) {
    for lsi_hz in [17_000, 47_000] {
        let mut run = board.with(driver(150_000));
        run.machine.system.iwdg.lsi_hz = lsi_hz;
        let mut run = run.powered_up();
        run.run_for(700);
        assert_eq!(run.machine.resets().len(), 1, "{lsi_hz} Hz");
        assert!(run.machine.system.iwdg.is_running());
        let period_ms = run.machine.system.iwdg.period().as_ms();
        assert!((110.0..=304.5).contains(&period_ms), "{period_ms} ms");
        let gap_ms = run.machine.system.iwdg.longest_gap().as_ms();
        assert!(gap_ms < 100.0, "{gap_ms} ms");
    }
}

/// Stock servos at the ends of their return delay, and both firmwares from any phase of a servo's
/// own loop.
fn servos_may_answer_early_late_and_at_any_phase(board: TestBoard) {
    for (firmware, baud, late_us) in [
        (Firmware::Stock, 1_000_000, 0),
        (Firmware::Stock, 500_000, 0),
        (Firmware::Stock, 117_647, 0),
        (Firmware::Stock, 57_142, 0),
        (Firmware::Morpheus, 1_000_000, 137),
        (Firmware::Morpheus, 1_000_000, 511),
        (Firmware::Morpheus, 1_000_000, 873),
    ] {
        let kinds = [1, 2].map(|id| ServoKind::new(firmware, id, baud).unwrap());
        let bench = Bench::with_servos(Plant::new(plant([0.02, -0.02], true), 1), &kinds);
        let host = ScriptedHost::new([(0, Action::Message(ToBoard::Heartbeat))], u64::MAX);
        let mut run = board.on(bench, host).powered_up();
        let from = super::us(30_000 + late_us);
        run.machine.run(from).unwrap();
        for servo in 0..2 {
            run.machine.system.line.bench.power_cycle(servo);
        }
        let is_found = run.run_until(1_500, |run| {
            let last = run.records().next_back();
            last.is_some_and(|record| record.mode == Mode::Idle)
        });
        let last = run.records().next_back();
        assert!(is_found, "{firmware:?} {baud} {late_us}: {last:?}");
        run.run_for(50);
        let last = run.records().next_back().unwrap();
        assert!(
            last.input
                .samples
                .iter()
                .all(|sample| sample.missing().is_none())
        );
        assert_eq!(run.machine.system.bus_faults(), BusFaults::default());
        assert_eq!(run.machine.system.bus_port().overruns(), 0);
    }
}

/// Flash that holds anything where settings are: the board boots, says what it made of it, and
/// does not move.
fn flash_that_holds_garbage_is_named_and_harmless(board: TestBoard) {
    for seed in 0..6 {
        let mut run = board.with(ScriptedHost::new(
            [(0, Action::Message(ToBoard::Heartbeat))],
            u64::MAX,
        ));
        let mut draw = Random::new(seed + 1);
        let mut garble = |bytes: &mut [u8]| bytes.fill_with(|| draw.byte());
        let [first, second] = settings_sectors(&mut run);
        match seed {
            0 => {
                first.fill(0);
                second.fill(0);
            }
            1 => {
                garble(first);
                garble(second);
            }
            2 => garble(first),
            3 => garble(second),
            // The head of a page is right, what follows is not.
            _ => {
                let from = 8 * (1 + seed as usize);
                garble(&mut first[from..from + 4_096]);
            }
        }
        let mut run = run.powered_up();
        until_configured(&mut run, 6_000);
        run.run_for(60);
        let report = run.report().unwrap();
        assert_eq!(report.last_end.cause, End::PowerUp, "seed {seed}");
        assert!(
            matches!(
                report.settings,
                SettingsFrom::Default | SettingsFrom::Damaged
            ),
            "seed {seed}: {:?}",
            report.settings
        );
        assert_eq!(run.records().next_back().unwrap().mode, Mode::Idle);
        assert!(are_off(&run));
        assert_eq!(run.machine.resets().len(), 1);
    }
}

on_each_board! {
    noise_on_the_line_ends_a_drive_at_the_worst,
    a_pulled_cable_ends_the_drive_and_a_plugged_one_finds_the_board,
    a_cable_may_come_later_than_the_supply,
    the_watchdog_is_right_at_17_and_at_47_khz,
    servos_may_answer_early_late_and_at_any_phase,
    flash_that_holds_garbage_is_named_and_harmless,
}
