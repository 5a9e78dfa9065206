//! Output that cannot be written: closed pipes, full disks, files that exist.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use serde_json::Value;

use crate::program::{Program, names, stderr, text};

/// A run that expects nothing.
const SHORT: &str = "title = \"short\"\n[[step]]\nat_s = 0\nregulate_rad = [0, 0]\n\
                     [stop]\nafter_s = 0.5\n";

/// A short run; its folder.
pub(super) fn records(program: &Program) -> PathBuf {
    fs::write(program.path("short.toml"), SHORT).unwrap();
    program.prints(&["run", "short.toml", "--quiet"]);
    let mut folders = names(&program.path("runs"));
    program.path("runs").join(folders.pop().unwrap())
}

#[test]
fn a_closed_pipe_ends_every_command_quietly() {
    let program = Program::new("output-pipe");
    records(&program);
    for args in [
        ["info"].as_slice(),
        &["run", "upright", "--show"],
        &["run", "--list"],
        &["run", "upright", "--duration", "0.5"],
        &["completions", "bash"],
        &["man"],
        &["config"],
        &["--help"],
        &["params"],
        &["design"],
        &["replay"],
        &["plot", "--what", "phase", "--format", "svg"],
        &["export", "csv", "--out", "-"],
        &["trials", "--seeds", "1", "--duration", "0.5"],
        &["identify", "fit", "--json"],
    ] {
        let (reader, writer) = std::io::pipe().unwrap();
        drop(reader);
        let output = program.command(args).stdout(writer).output().unwrap();
        let text = stderr(&output);
        assert!(!text.contains("cannot print"), "{args:?}: {text}");
        assert_eq!(output.status.code(), Some(141), "{args:?}: {text}");
    }
    // As in `info 2>&1 | head -3`.
    let (reader, writer) = std::io::pipe().unwrap();
    drop(reader);
    let mut command = program.command(&["info", "nowhere"]);
    assert_eq!(command.stderr(writer).status().unwrap().code(), Some(2));
}

#[cfg(target_os = "linux")]
#[test]
fn a_result_that_cannot_be_printed_is_an_error() {
    let program = Program::new("output-full");
    records(&program);
    for args in [
        ["config"].as_slice(),
        &["export", "csv", "--out", "-"],
        &["--help"],
        &["run", "-h"],
        &["help", "run"],
        &["--version"],
    ] {
        let full = fs::File::options().write(true).open("/dev/full").unwrap();
        let output = program.command(args).stdout(full).output().unwrap();
        let text = stderr(&output);
        assert_eq!(output.status.code(), Some(2), "{text}");
        assert!(text.contains("cannot print: No space left"), "{text}");
    }
    program.refuses(
        &["export", "csv", "--out", "/dev/full"],
        &["/dev/full", "No space left"],
    );
}

/// Runs a scenario where no file may be larger than this.
#[cfg(target_os = "linux")]
fn run_with_room(program: &Program, kib: u32) -> Output {
    // A signal that is ignored leaves the write to fail, as on a full disk.
    let script = format!(
        "trap '' XFSZ; ulimit -f {kib}; exec {} run upright --duration 3",
        env!("CARGO_BIN_EXE_armbridge")
    );
    let mut command = Command::new("bash");
    command.args(["-c", &script]).current_dir(&program.0);
    command.env_remove("ARMBRIDGE_LINK").output().unwrap()
}

#[cfg(target_os = "linux")]
#[test]
fn a_disk_that_fills_leaves_a_summary_and_no_half_files() {
    let program = Program::new("output-disk");
    // Neither the log nor the picture of the angles has room.
    let output = run_with_room(&program, 40);
    let text = String::from_utf8_lossy(&output.stdout).replace("\n ", " ");
    assert_eq!(output.status.code(), Some(1), "{text}{}", stderr(&output));
    let words: Vec<&str> = text.split_whitespace().collect();
    let text = words.join(" ");
    assert!(text.starts_with("armbridge upright"), "{text}");
    for words in ["run.mcap", "cannot write", "File too large"] {
        assert!(text.contains(words), "no {words}: {text}");
    }
    let folder = program.path("runs").join(&names(&program.path("runs"))[0]);
    for name in names(&folder) {
        assert!(!name.contains(".part"), "{name}");
        let is_whole = match folder.join(&name).extension().unwrap().to_str() {
            Some("png") => fs::read(folder.join(&name))
                .unwrap()
                .ends_with(b"\xaeB`\x82"),
            Some("svg") => fs::read(folder.join(&name)).unwrap().ends_with(b"</svg>\n"),
            _ => fs::metadata(folder.join(&name)).unwrap().len() > 1_000,
        };
        assert!(is_whole, "{name}");
    }
    // What was written of the log can be read.
    program.prints(&["info"]);
}

#[cfg(target_os = "linux")]
#[test]
fn a_disk_that_is_full_from_the_beginning_leaves_nothing() {
    let program = Program::new("output-no-room");
    let output = run_with_room(&program, 0);
    let text = stderr(&output);
    assert_eq!(output.status.code(), Some(2), "{text}");
    assert!(
        text.contains("cannot write") && text.contains("run.mcap"),
        "{text}"
    );
    assert_eq!(names(&program.path("runs")), [""; 0]);
}

#[test]
fn files_that_exist_are_kept() {
    let program = Program::new("output-existing");
    let run = records(&program);
    for args in [
        ["design", "--write", "gains.toml"].as_slice(),
        &["design", "--plot", "step.svg"],
        &["export", "csv", "--out", "log.csv"],
        &["man", "--out", "pages"],
        &[
            "trials",
            "--seeds",
            "1",
            "--duration",
            "0.5",
            "--plot",
            "trial",
        ],
    ] {
        let path = args.last().unwrap();
        program.prints(args);
        program.refuses(args, &[path, "it exists; --force replaces it"]);
        program.prints(&[args, &["--force"]].concat());
    }
    // What is not written is not touched either.
    fs::write(program.path("step.png"), "mine").unwrap();
    program.prints(&["design", "--plot", "step.svg", "--force"]);
    assert_eq!(fs::read(program.path("step.png")).unwrap(), b"mine");
    let arm = ["arm", "--for", "0.2", "--quiet", "--record", "arm.mcap"];
    program.prints(&arm);
    program.refuses(&arm, &["arm.mcap", "a log is never replaced"]);
    // Beside a log, names are the program's own.
    let export = ["export", "csv"];
    let first = program.prints(&export);
    assert!(first.contains("/run.csv · "), "{first}");
    assert_eq!(program.prints(&export), first);
    fs::write(run.join("run.csv"), "mine").unwrap();
    let second = program.prints(&export);
    assert!(second.contains("/run-2.csv · "), "{second}");
    assert_eq!(fs::read(run.join("run.csv")).unwrap(), b"mine");
    program.prints(&["export", "csv", "--force"]);
    assert!(fs::metadata(run.join("run.csv")).unwrap().len() > 1_000);
    assert!(names(&program.0).iter().all(|name| !name.contains(".part")));
}

#[test]
fn a_log_is_printed_or_has_the_ending_of_its_format() {
    let program = Program::new("output-export");
    records(&program);
    let printed = program.prints(&["export", "csv", "--out", "-"]);
    assert!(printed.starts_with("time_s,tick,"), "{printed:.40}");
    assert!(printed.lines().count() > 400);
    assert!(!program.path("-").exists());
    for (format, out, words) in [
        ("csv", "a.parquet", "the format is csv"),
        ("mat", "a.csv", "ending in .mat"),
        ("mat", "-", "only csv can be printed"),
    ] {
        program.refuses(&["export", format, "--out", out], &[words]);
    }
    program.prints(&["export", "csv", "--out", "a.CSV"]);
    program.prints(&["export", "csv", "--out", "a.txt"]);
    let bitmap = ["design", "--plot", "x.bmp"];
    program.refuses(&bitmap, &["ending in .svg or .png"]);
}

#[test]
fn the_newest_run_is_the_latest_and_not_the_last_by_name() {
    let program = Program::new("output-newest");
    let log = |program: &Program| -> PathBuf {
        let replayed: Value = serde_json::from_str(&program.prints(&["replay", "--json"])).unwrap();
        replayed["log"].as_str().unwrap().into()
    };
    // One after the other, within a second.
    for name in ["zero.toml", "alpha.toml"] {
        fs::write(program.path(name), SHORT).unwrap();
        program.prints(&["run", name, "--quiet"]);
    }
    let newest = log(&program);
    assert!(newest.ends_with("run.mcap") && newest.to_str().unwrap().contains("Z-alpha"));
    // Names of folders that have no milliseconds.
    let bytes = fs::read(program.path("").join(newest)).unwrap();
    fs::remove_dir_all(program.path("runs")).unwrap();
    for number in ["", "-2", "-9", "-12"] {
        let folder = format!("runs/2026-01-31T12-00-00Z-demo{number}");
        fs::create_dir_all(program.path(&folder)).unwrap();
        fs::write(program.path(&folder).join("run.mcap"), &bytes).unwrap();
    }
    let last = "runs/2026-01-31T12-00-00Z-demo-12/run.mcap";
    assert_eq!(log(&program), Path::new(last));
    // In the folder that is configured.
    fs::rename(program.path("runs"), program.path("mine")).unwrap();
    fs::write(program.path("armbridge.toml"), "out = \"mine\"\n").unwrap();
    let found = log(&program);
    assert!(found.ends_with(last.replace("runs", "mine")), "{found:?}");
    assert!(program.prints(&["info"]).contains("mine"));
    assert!(
        program
            .prints(&["export", "csv"])
            .contains("demo-12/run.csv")
    );
}

/// Runs the program where no file may have contents.
#[cfg(target_os = "linux")]
fn without_room(program: &Program, args: &str) -> Output {
    let script = format!(
        "trap '' XFSZ; ulimit -f 0; exec {} {args}",
        env!("CARGO_BIN_EXE_armbridge")
    );
    let mut command = Command::new("bash");
    command.args(["-c", &script]).current_dir(&program.0);
    command.env_remove("ARMBRIDGE_OUT").output().unwrap()
}

#[cfg(target_os = "linux")]
#[test]
fn a_file_is_replaced_only_by_a_whole_one() {
    let program = Program::new("output-replaced");
    fs::write(program.path("step.svg"), "mine").unwrap();
    let output = without_room(
        &program,
        "design --plot step.svg --force | cat; exit ${PIPESTATUS[0]}",
    );
    assert!(
        stderr(&output).contains("cannot write step.svg"),
        "{}",
        stderr(&output)
    );
    assert_eq!(fs::read(program.path("step.svg")).unwrap(), b"mine");
    let output = without_room(&program, "doctor | cat");
    assert!(output.status.success(), "{}", stderr(&output));
    assert_eq!(names(&program.0), ["step.svg"]);
}

#[test]
fn trials_replace_all_their_files_or_none() {
    let program = Program::new("output-trials");
    let trials = |seed: &'static str| {
        [
            "trials",
            "--seeds",
            seed,
            "--duration",
            "0.5",
            "--quiet",
            "--plot",
            "trial",
        ]
    };
    fs::create_dir(program.path("trial")).unwrap();
    fs::write(program.path("trial/run.csv"), "mine").unwrap();
    program.refuses(&trials("1"), &["run.csv", "it exists; --force replaces it"]);
    assert_eq!(names(&program.path("trial")), ["run.csv"]);
    program.prints(&[trials("1").as_slice(), &["--force"]].concat());
    let first = names(&program.path("trial"));
    program.prints(&[trials("2").as_slice(), &["--force"]].concat());
    assert_eq!(names(&program.path("trial")), first);
}

#[test]
fn a_recording_of_nothing_leaves_no_folder() {
    let program = Program::new("output-record");
    let args = ["status", "--link", "tcp://127.0.0.1:1", "--record", "logs"];
    let output = program.run(&args);
    assert_eq!(output.status.code(), Some(2), "{}", stderr(&output));
    assert_eq!(names(&program.path("logs")), [""; 0]);
}

#[cfg(target_os = "linux")]
#[test]
fn standard_output_has_a_name_in_the_system() {
    let program = Program::new("output-dev-stdout");
    records(&program);
    let file = fs::File::create(program.path("printed.csv")).unwrap();
    let mut command = program.command(&["export", "csv", "--out", "/dev/stdout"]);
    let output = command.stdout(file).output().unwrap();
    assert!(output.status.success(), "{}", stderr(&output));
    let printed = fs::read_to_string(program.path("printed.csv")).unwrap();
    assert!(printed.starts_with("time_s,tick,"), "{printed:.40}");
    assert!(!printed.contains(" ticks, "));
}

#[cfg(unix)]
#[test]
fn text_of_others_has_no_power_over_the_terminal() {
    let program = Program::new("output-hostile");
    // The name of a run is in its log, and so is that of its file.
    let hostile = "a\x1b[2J\x07\u{9b}1m\nlink";
    let shown = "a\\u001b[2J\\u0007\\u009b1m";
    let file = format!("{hostile}.toml");
    let title = SHORT.replace("short", "\\u001b]0;title\\u0007");
    fs::write(program.path(&file), title).unwrap();
    for args in [
        ["run", &file, "--check"].as_slice(),
        &["run", &file],
        &["info"],
    ] {
        let output = program.run(args);
        let text = [stderr(&output), text(&output.stdout).to_owned()].concat();
        let is_control = |c: char| c.is_control() && c != '\n';
        assert!(!text.contains(is_control), "{args:?}: {text:?}");
        assert!(text.contains(shown), "{args:?}: {text}");
    }
    let info = program.prints(&["info"]);
    assert!(!info.contains("\nlink.toml"), "{info}");
}
