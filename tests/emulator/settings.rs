//! Settings outlive a reset of the emulated board, whose flash is memory that it leaves alone.

use std::io::Read;
use std::time::{Duration, Instant};

use armbridge_client::tcp_pump;
use armbridge_link::message::{Refusal, SettingsFrom};
use armbridge_sim::emulator::{Failure, Image, Provocation, Qemu, QemuOptions, Time};
use armbridge_sim::raw_bus_server::WallClockBench;
use armbridge_tests::command_host::{CommandHost, Request, SAVE, bench, configure};

/// Saves settings on a board that fails then, and has a second host send these requests to the
/// next boot. Returns both hosts.
fn save_and_restart(failure: Failure, requests: &[Request]) -> [CommandHost; 2] {
    /// Times slower than the wall clock, for a machine with other things to do.
    const SLOW: u32 = 10;
    const FAILS_MS: u32 = 1_200;
    let begun = Instant::now();
    let mut qemu = Qemu::start(&QemuOptions {
        image: Image::current().unwrap(),
        time: Time::Slow(SLOW),
        icount: false,
        provoke: Some(Provocation {
            failure,
            at_ms: FAILS_MS,
        }),
    })
    .unwrap();
    // The board has booted in between: on a busy machine that takes seconds.
    let running = Instant::now();
    let (from, to) = (qemu.bus.try_clone().unwrap(), qemu.bus.try_clone().unwrap());
    // Ends with QEMU.
    std::thread::spawn(move || WallClockBench::new(bench(), SLOW).serve(from, to, || None, false));

    let mut first = CommandHost::new([configure(2_000), SAVE]);
    tcp_pump::run(&mut qemu.link, &mut first, SLOW).unwrap();
    assert_eq!(first.received.settings, Some(SettingsFrom::Saved));
    assert_eq!(first.received.answers, [Ok(()); 2]);
    let fails_at = Duration::from_millis(u64::from(FAILS_MS * SLOW));
    assert!(
        begun.elapsed() < fails_at,
        "too slow a machine for this test"
    );

    let over = fails_at + Duration::from_secs(2);
    std::thread::sleep(over.saturating_sub(running.elapsed()));
    // The last messages of the first boot are discarded.
    let link = &mut qemu.link;
    link.set_read_timeout(Some(Duration::from_millis(100)))
        .unwrap();
    while matches!(link.read(&mut [0; 4096]), Ok(count) if count > 0) {}
    let mut second = CommandHost::new(requests.iter().copied());
    tcp_pump::run(&mut qemu.link, &mut second, SLOW).unwrap();
    assert_ne!(second.received.session, first.received.session);
    [first, second]
}

#[test]
#[ignore = "needs QEMU and the firmware image: run `cargo verify`"]
fn firmware_does_not_arm_with_settings_that_are_damaged() {
    let [_, host] = save_and_restart(Failure::Rot, &[Request::Arm, SAVE, Request::Arm]);
    let [refused, saved, answer] = host.received.answers[..] else {
        panic!("{:?}", host.received.answers)
    };
    assert_eq!((refused, saved), (Err(Refusal::SettingsLost), Ok(())));
    assert_ne!(answer, Err(Refusal::SettingsLost));
}

#[test]
#[ignore = "needs QEMU and the firmware image: run `cargo verify`"]
fn firmware_keeps_settings_across_a_reset() {
    let [_, second] = save_and_restart(Failure::Panic, &[]);
    assert_eq!(second.received.settings, Some(SettingsFrom::Saved));
    let pairs = second.received.records.windows(2);
    let neighbours = pairs.filter(|pair| pair[1].tick - pair[0].tick == 1);
    let mut periods_us: Vec<u64> = neighbours
        .map(|pair| pair[1].input.start_us - pair[0].input.start_us)
        .collect();
    // A busy machine delays single ticks.
    let middle = periods_us.len() / 2;
    let (_, median_us, _) = periods_us.select_nth_unstable(middle);
    assert!((1_900..2_100).contains(median_us), "{median_us} us");
}
