//! Output that cannot be written: closed pipes, full disks, files that exist, ctrl-C.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};

use serde_json::Value;

/// A run that expects nothing.
const SHORT: &str = "title = \"short\"\n[[step]]\nat_s = 0\nregulate_rad = [0, 0]\n\
                     [stop]\nafter_s = 0.5\n";

/// The program, in an empty folder.
struct Program(PathBuf);

impl Program {
    fn new(test: &str) -> Self {
        Self(crate::folder(&format!("output-{test}")))
    }

    fn command(&self, args: &[&str]) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_armbridge"));
        command.args(args).current_dir(&self.0);
        command
            .env_remove("ARMBRIDGE_LINK")
            .env_remove("ARMBRIDGE_OUT");
        command
    }

    fn run(&self, args: &[&str]) -> Output {
        self.command(args).output().unwrap()
    }

    /// Its standard output; it must succeed.
    fn prints(&self, args: &[&str]) -> String {
        let output = self.run(args);
        assert!(output.status.success(), "{args:?}: {}", stderr(&output));
        String::from_utf8(output.stdout).unwrap()
    }

    /// It refuses in one line that contains these words.
    fn refuses(&self, args: &[&str], words: &[&str]) {
        let output = self.run(args);
        let line = stderr(&output);
        assert_eq!(output.status.code(), Some(2), "{args:?}: {line}");
        assert_eq!(line.lines().count(), 1, "{args:?}: {line}");
        for word in words {
            assert!(line.contains(word), "{args:?}: no {word:?} in {line}");
        }
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.join(name)
    }

    /// A short run; its folder.
    fn records(&self) -> PathBuf {
        fs::write(self.path("short.toml"), SHORT).unwrap();
        self.prints(&["run", "short.toml", "--quiet"]);
        let mut folders = names(&self.path("runs"));
        self.path("runs").join(folders.pop().unwrap())
    }
}

fn stderr(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

fn names(folder: &Path) -> Vec<String> {
    let Ok(entries) = fs::read_dir(folder) else {
        return Vec::new();
    };
    let names = entries.map(|entry| entry.unwrap().file_name().into_string().unwrap());
    let mut names: Vec<String> = names.collect();
    names.sort();
    names
}

#[test]
fn a_closed_pipe_ends_every_command_quietly() {
    let program = Program::new("pipe");
    program.records();
    for args in [
        ["info"].as_slice(),
        &["run", "upright", "--show"],
        &["run", "--list"],
        &["run", "upright", "--duration", "0.5"],
        &["completions", "bash"],
        &["man"],
        &["config"],
        &["params"],
        &["design"],
        &["replay"],
        &["plot", "--what", "phase", "--format", "svg"],
        &["export", "csv", "--out", "-"],
        &["bench", "--seeds", "1", "--duration", "0.5"],
        &["identify", "fit", "--json"],
    ] {
        let mut command = program.command(args);
        let mut child = command
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        drop(child.stdout.take());
        let output = child.wait_with_output().unwrap();
        let text = stderr(&output);
        assert!(!text.contains("cannot print"), "{args:?}: {text}");
        assert_eq!(output.status.code(), Some(141), "{args:?}: {text}");
    }
    // As in `info 2>&1 | head -3`.
    let mut command = program.command(&["info", "nowhere"]);
    let mut child = command.stderr(Stdio::piped()).spawn().unwrap();
    drop(child.stderr.take());
    assert_eq!(child.wait().unwrap().code(), Some(2));
}

#[cfg(target_os = "linux")]
#[test]
fn a_result_that_cannot_be_printed_is_an_error() {
    let program = Program::new("full");
    for args in [["config"].as_slice(), &["export", "csv", "--out", "-"]] {
        program.records();
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
    let program = Program::new("disk");
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
    let program = Program::new("no-room");
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
    let program = Program::new("existing");
    let run = program.records();
    for args in [
        ["design", "--write", "gains.toml"].as_slice(),
        &["design", "--plot", "step.svg"],
        &["export", "csv", "--out", "log.csv"],
        &["man", "--out", "pages"],
        &[
            "bench",
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
    let program = Program::new("export");
    program.records();
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
    let program = Program::new("newest");
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

/// Interrupts a command that has worked for a while, as ctrl-C does.
#[cfg(unix)]
fn interrupted(program: &Program, args: &[&str]) -> Output {
    let mut command = program.command(args);
    let command = command.stdout(Stdio::piped()).stderr(Stdio::piped());
    let child = command.spawn().unwrap();
    std::thread::sleep(std::time::Duration::from_secs(4));
    let id = child.id().to_string();
    let sent = Command::new("kill").args(["-INT", &id]).status().unwrap();
    assert!(sent.success());
    child.wait_with_output().unwrap()
}

#[cfg(unix)]
#[test]
fn ctrl_c_keeps_the_trials_and_cases_that_are_done() {
    let program = Program::new("ctrl-c");
    let args = [
        "bench",
        "--seeds",
        "1..10000",
        "--duration",
        "0.5",
        "--json",
    ];
    let output = interrupted(&program, &args);
    assert_eq!(output.status.code(), Some(130), "{}", stderr(&output));
    assert!(
        stderr(&output).contains("of 10000 seeds"),
        "{}",
        stderr(&output)
    );
    let report: Value = serde_json::from_slice(&output.stdout).unwrap();
    let outcomes = report["outcomes"].as_array().unwrap();
    assert!((1..10_000).contains(&outcomes.len()), "{}", outcomes.len());

    let output = interrupted(
        &program,
        &["fault-campaign", "--seeds", "1000000", "--json"],
    );
    assert_eq!(output.status.code(), Some(130), "{}", stderr(&output));
    let report: Value = serde_json::from_slice(&output.stdout).unwrap();
    let cases = |group: &str| report[group]["cases"].as_u64().unwrap();
    assert!(cases("all_singles") + cases("all_pairs") > 0, "{report}");
}
