//! A control loop of the firmware with a client that never stops asking.

use armbridge_servo::Firmware;
use armbridge_tests::transparent_port::loops::{client, hammered, in_emulator, on_bench};

#[test]
#[ignore = "needs QEMU and the firmware image: run `cargo verify`"]
fn the_emulated_board_does_not_notice_a_client() {
    for firmware in Firmware::ALL {
        hammered(firmware, in_emulator);
    }
}

/// The same code on the same servos: with either firmware, with a client or without,
/// emulator and bench agree in every tick.
#[test]
#[ignore = "needs QEMU and the firmware image: run `cargo verify`"]
fn emulator_and_bench_agree_with_a_client_too() {
    for firmware in Firmware::ALL {
        let (mut bench, _) = on_bench(firmware, Some(client(firmware)));
        let (mut emulator, _) = in_emulator(firmware, Some(client(firmware)));
        for record in bench.iter_mut().chain(&mut emulator) {
            record.timing.compute_ns = 0;
        }
        assert_eq!(bench, emulator, "{firmware}");
    }
}
