//! `emulate:` as a user meets it: which image runs, and what is missing where none does.

use std::fs::{self, File};
use std::net::TcpListener;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::time::{Duration, SystemTime};

use serde_json::json;

/// Any free port.
const ANY_PORT: &str = "tcp://127.0.0.1:0";

/// The program in this folder, with cargo's files beside it.
fn run(folder: &Path, args: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_armbridge"));
    let command = command.args(args).current_dir(folder);
    command.env_remove("CARGO_TARGET_DIR").output().unwrap()
}

/// One line on standard error with these words, and exit code 2.
fn assert_fails(output: &Output, words: &[&str]) {
    let line = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{line}");
    assert_eq!(line.trim_end().lines().count(), 1, "{line}");
    for word in words {
        assert!(line.contains(word), "no {word:?} in {line:?}");
    }
}

/// An ELF file that loads its own first bytes.
fn image() -> Vec<u8> {
    let mut file = vec![0_u8; 84];
    file[..6].copy_from_slice(b"\x7FELF\x01\x01");
    // For ARM.
    file[18] = 40;
    // One entry of 32 bytes in the table of segments, behind the header.
    (file[28], file[42], file[44]) = (52, 32, 1);
    // To be loaded, 8 bytes.
    (file[52], file[68]) = (1, 8);
    file
}

/// A source tree with an image of its firmware: a folder inside, and its only source.
pub(crate) fn tree(folder: &Path) -> (PathBuf, PathBuf) {
    let source = folder.join("firmware/src/main.rs");
    let built = folder.join("target/thumbv7em-none-eabihf/firmware");
    for path in [source.parent().unwrap(), &folder.join("host"), &built] {
        fs::create_dir_all(path).unwrap();
    }
    fs::write(folder.join("Cargo.toml"), "[workspace]").unwrap();
    let manifest = "[package]\nname = \"armbridge-firmware\"\n";
    fs::write(folder.join("firmware/Cargo.toml"), manifest).unwrap();
    fs::write(&source, "").unwrap();
    fs::write(built.join("mps2-an386"), image()).unwrap();
    let list = format!("mps2-an386: {}\n", source.display());
    fs::write(built.join("mps2-an386.d"), list).unwrap();
    (folder.join("host"), source)
}

#[test]
fn outside_any_source_tree_the_missing_image_is_named() {
    let folder = tempfile::tempdir().unwrap();
    for args in [
        ["run", "--quiet", "--link", "emulate:"].as_slice(),
        &["status", "--link", "emulate:"],
    ] {
        let words = ["source tree", "cargo build-emulator", "emulate:IMAGE"];
        assert_fails(&run(folder.path(), args), &words);
    }
}

#[test]
fn changed_firmware_must_be_built_before_it_runs() {
    let folder = tempfile::tempdir().unwrap();
    let (inside, source) = tree(folder.path());
    let args = ["run", "--quiet", "--link", "emulate:"];
    // The image is current: only QEMU is missing.
    let mut command = Command::new(env!("CARGO_BIN_EXE_armbridge"));
    let command = command.args(args).current_dir(&inside).env("PATH", "");
    let output = command.env_remove("CARGO_TARGET_DIR").output().unwrap();
    assert_fails(&output, &["qemu-system-arm"]);

    let file = File::options().write(true).open(&source).unwrap();
    file.set_modified(SystemTime::now() + Duration::from_secs(9))
        .unwrap();
    let words = [
        "firmware/src/main.rs is newer than the firmware image",
        "cargo build-emulator",
    ];
    assert_fails(&run(&inside, &args), &words);

    fs::remove_dir_all(folder.path().join("target")).unwrap();
    let words = ["no firmware image", "cargo build-emulator"];
    assert_fails(&run(&inside, &args), &words);
}

#[test]
#[ignore = "needs QEMU and the firmware image: run `cargo verify`"]
fn the_image_that_runs_is_named_as_the_board_reports_it() {
    let here = Path::new(env!("CARGO_MANIFEST_DIR"));
    let runs = tempfile::tempdir().unwrap();
    let out = runs.path().to_str().unwrap();
    let mut command = Command::new(env!("CARGO_BIN_EXE_armbridge"));
    let command = command.args(["run", "--duration", "0.5", "--link", "emulate:"]);
    let output = command.args(["--out", out]).current_dir(here).output();
    let errors = String::from_utf8(output.unwrap().stderr).unwrap();
    let named = errors
        .split_once("board: firmware image ")
        .expect(&errors)
        .1;
    let (path, crc) = named.lines().next().unwrap().split_once(", ").unwrap();
    assert!(path.ends_with("/mps2-an386"), "{path}");

    // Another run, of the same file by its name.
    let link = format!("emulate:{}", here.join(path).display());
    let mut command = Command::new(env!("CARGO_BIN_EXE_armbridge"));
    let command = command.args(["status", "--link", &link]);
    let output = command.current_dir(runs.path()).output().unwrap();
    let status = String::from_utf8(output.stdout).unwrap();
    let row = status.lines().find(|line| line.contains("image")).unwrap();
    assert!(row.trim_end().ends_with(crc), "{crc}: {row}");

    // Compared with the images of a release.
    let digits = crc.strip_prefix("CRC-32 ").unwrap();
    for (listed, words) in [
        (digits, "the image for mps2-an386 of release 7.8.9"),
        ("00000000", "none of release 7.8.9 (mps2-an386 00000000)"),
    ] {
        let image = json!({ "board": "mps2-an386", "image_crc32": listed, "sha256": "" });
        let list = json!({ "version": "7.8.9", "commit": "", "images": [image] });
        fs::write(runs.path().join("images.json"), list.to_string()).unwrap();
        let args = ["status", "--link", &link, "--images", "images.json"];
        let output = run(runs.path(), &args);
        let status = String::from_utf8(output.stdout).unwrap();
        assert!(status.contains(&format!("{crc}: {words}")), "{status}");
    }
}

#[test]
fn an_emulator_that_cannot_start_says_why() {
    let temporary = tempfile::tempdir().unwrap();
    let folder = temporary.path();
    let taken = TcpListener::bind("127.0.0.1:0").unwrap();
    let at = format!("tcp://{}", taken.local_addr().unwrap());
    let serve = |link, at| run(folder, &["serve", "board", "--link", link, "--listen", at]);
    let output = serve("emulate:", &at);
    assert_fails(&output, &[&at, "taken", "another port"]);

    let path = folder.join("no-such-image");
    let image_name = path.to_str().unwrap();
    let link = format!("emulate:{image_name}");
    let args = ["run", "--quiet", "--link", &link];
    assert_fails(&run(folder, &args), &[image_name, "cargo build-emulator"]);
    let output = serve(&link, ANY_PORT);
    assert_eq!(output.status.code(), Some(2));
    let errors = String::from_utf8_lossy(&output.stderr);
    assert!(errors.contains("cargo build-emulator"), "{errors}");

    fs::write(&path, "no image").unwrap();
    let words = [image_name, "no ELF file for ARM", "cargo build-emulator"];
    assert_fails(&run(folder, &args), &words);

    fs::write(&path, image()).unwrap();
    let mut command = Command::new(env!("CARGO_BIN_EXE_armbridge"));
    let command = command.args(args).current_dir(folder).env("PATH", "");
    let words = ["qemu-system-arm", "cargo verify", "apt-get install"];
    assert_fails(&command.output().unwrap(), &words);

    // TCP's port multiplexer, which no machine runs.
    let unused = "tcp://127.0.0.1:1";
    let on_bus = format!("{link}?bus={unused}");
    let output = run(folder, &["run", "--quiet", "--link", &on_bus]);
    assert_fails(&output, &[unused, "is the other side listening?"]);
    let runs = fs::read_dir(folder.join("runs")).map(Iterator::count);
    assert!(
        matches!(runs, Err(_) | Ok(0)),
        "an empty run was left behind"
    );
}

/// Test vectors, and the arm of the emulated board, by a client that knows the book alone.
#[cfg(target_os = "linux")]
#[test]
#[ignore = "needs QEMU and the firmware image: run `cargo verify`"]
fn a_client_of_the_wire_chapter_moves_the_emulated_arm() {
    let script = concat!(env!("CARGO_MANIFEST_DIR"), "/../doc/clients/wire.py");
    let lines = std::fs::read_to_string(script).unwrap().lines().count();
    assert!(lines <= 150, "{lines} lines");
    let python = |argument: &str| {
        let mut command = Command::new("timeout");
        let output = command
            .args(["60", "python3", script, argument])
            .output()
            .unwrap();
        let text = String::from_utf8_lossy(&output.stdout).into_owned();
        let error = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.success(), "{text}{error}");
        text
    };
    assert!(python("--check").ends_with("vectors\n"));
    let link = ["--listen", ANY_PORT, "--link", "emulate:", "--quiet"];
    let server = crate::listeners::Program::serve(&[&["board"][..], &link].concat());
    let text = python(&server.at);
    let angles: Vec<f64> = text.split(' ').filter_map(|it| it.parse().ok()).collect();
    // The paper's controller leaves some rest error.
    let [first, second] = angles[..] else {
        panic!("{text}")
    };
    assert!(
        (first - 0.2).abs() < 0.05 && (second + 0.1).abs() < 0.05,
        "{text}"
    );
}
