//! Instruction counts of README and book, counted anew by the image `instructions`.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

/// The workspace.
fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

/// Output of the image under QEMU, one virtual ns an instruction.
fn printed() -> String {
    let target = std::env::var_os("CARGO_TARGET_DIR").map_or(root().join("target"), PathBuf::from);
    let image = target.join("thumbv7em-none-eabihf/firmware/instruction-count");
    let output = Command::new("qemu-system-arm")
        .args(["-machine", "mps2-an386", "-display", "none"])
        .args(["-monitor", "none", "-serial", "none"])
        .args(["-semihosting-config", "enable=on,target=native"])
        .args(["-icount", "shift=0", "-kernel"])
        .arg(&image)
        .output()
        .unwrap();
    assert!(output.status.success(), "{}: {output:?}", image.display());
    String::from_utf8(output.stdout).unwrap()
}

/// The count of a function, rounded.
fn count(printed: &str, name: &str) -> String {
    let line = printed.lines().find_map(|line| line.strip_prefix(name));
    let line = line.unwrap_or_else(|| panic!("no {name:?} in\n{printed}"));
    let count: f64 = line.trim().parse().unwrap();
    format!("{count:.0}")
}

/// The second cell of a table's row.
fn cell(file: &str, row: &str) -> String {
    let text = fs::read_to_string(root().join(file)).unwrap();
    let rest = text
        .lines()
        .find_map(|line| line.strip_prefix(&format!("| {row} | ")));
    let rest = rest.unwrap_or_else(|| panic!("no row {row:?} in {file}"));
    rest.split(" | ").next().unwrap().to_owned()
}

#[test]
#[ignore = "needs QEMU and the image `instructions`: run `cargo verify`"]
fn counts_are_those_of_the_readme_and_the_book() {
    let printed = printed();
    let book = "host/doc/src/control.md";
    let linear = count(&printed, "LQR and linear Luenberger observer");
    let kalman = count(&printed, "Kalman filter, 6 states: model, predict, update");
    for (name, row) in [
        (
            "sine and cosine of one angle",
            "sine and cosine of an angle, 1e-7",
        ),
        (
            "LQR and linear Luenberger observer",
            "LQR and Luenberger observer",
        ),
        (
            "Kalman filter, 6 states: model, predict, update",
            "Kalman filter, 6 states: model, predict, update",
        ),
        ("computed torque", "computed torque"),
        ("minimum-jerk trajectory", "minimum-jerk trajectory"),
    ] {
        assert_eq!(cell(book, row), count(&printed, name), "{row}");
    }
    let readme = "README.md";
    assert_eq!(
        cell(readme, "LQR and observer"),
        format!("{linear} instructions")
    );
    assert_eq!(
        cell(readme, "Kalman filter, 6 states"),
        format!("{kalman} instructions")
    );
}
