//! The image `instructions` under QEMU and in this emulator: the same counts and results.

use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Instant;

use crate::{mps2, trace};

fn image() -> PathBuf {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let target = std::env::var_os("CARGO_TARGET_DIR").map_or(root.join("target"), PathBuf::from);
    target.join("thumbv7em-none-eabihf/firmware/instruction-count")
}

fn read(path: &Path) -> Vec<u8> {
    std::fs::read(path).unwrap_or_else(|error| {
        panic!(
            "{}: {error}; `cargo build-instructions` makes it",
            path.display()
        )
    })
}

/// QEMU with an image, a virtual nanosecond an instruction.
pub(crate) fn command(image: &Path) -> Command {
    let mut command = Command::new("qemu-system-arm");
    command
        .args(["-machine", "mps2-an386", "-display", "none"])
        .args(["-monitor", "none", "-serial", "none"])
        .args(["-semihosting-config", "enable=on,target=native"])
        .args(["-icount", "shift=0", "-kernel"])
        .arg(image);
    command
}

#[test]
fn counts_and_results_are_those_of_qemu() {
    let image = image();
    let (mut core, mut bus) = mps2::machine(&read(&image));
    let begun = Instant::now();
    assert_eq!(mps2::run(&mut core, &mut bus), 0);
    let executed = core.executed();
    let per_second = executed as f64 / begun.elapsed().as_secs_f64();
    println!(
        "{executed} instructions, {:.1} million a second",
        per_second / 1e6
    );
    let output = command(&image).output().unwrap();
    assert!(output.status.success(), "{output:?}");
    let expected = String::from_utf8(output.stdout).unwrap();
    let printed = String::from_utf8(bus.printed).unwrap();
    assert!(expected.contains("Kalman filter"), "{expected}");
    assert_eq!(printed, expected);
}

/// Bytes of code, as the image has them.
const CODE: u32 = 0x1_2000;

/// Compares all registers, those of the floating-point unit too, before each instruction.
#[test]
#[ignore = "minutes: QEMU prints each instruction"]
fn each_state_is_that_of_qemu() {
    let image = image();
    let compare = |range: std::ops::Range<u32>, limit| {
        let (mut core, mut bus) = mps2::machine(&read(&image));
        // The architecture leaves the flags open at a reset.
        core.set_xpsr(0x4100_0000);
        trace::compare(
            command(&image),
            &mut core,
            &mut bus,
            (&range, limit),
            u32::MAX,
        )
    };
    assert_eq!(compare(0..CODE, 200_000), 200_000);
    // Then the first instructions of each part of the code, however late they are executed.
    let parts = (0..CODE).step_by(0x400).map(|start| {
        let compared = compare(start..start + 0x400, 4_000);
        println!("{start:#x}: {compared}");
        compared
    });
    let compared: usize = parts.sum();
    assert!(compared > 100_000, "{compared}");
}
