//! `armbridge identify run` on a board that outlives it: asked before anything moves,
//! interrupted, and applied.

use std::io::Write;
#[cfg(unix)]
use std::io::{BufRead, BufReader};
use std::path::PathBuf;
#[cfg(unix)]
use std::process::Command;
use std::process::{Output, Stdio};

use armbridge_client::transport::LinkUri;
use armbridge_link::message::{Drive, Mode};
use armbridge_log::recording::Recording;
use armbridge_sim::plant::PlantFile;

#[cfg(unix)]
use crate::links::program::interrupt;
use crate::links::program::{TCP, assert_ends, command, folder, run, spawn, text};
use armbridge_tests::served_board::Served;

/// Ten seconds in which both joints swing, on a machine that may be busy for a while.
const PLAN: &str = "title = \"t\"
control = \"compensated\"
[set]
limits.check_rad_s2 = 0
limits.silence_ms = 2000
limits.hold_ms = 2000
controller.kind = \"computed-torque\"
controller.natural_rad_s = [20.0, 20.0]
[[step]]
at_s = 0.0
regulate_rad = [0.0, 0.0]
[[step]]
at_s = 0.5
[step.experiment]
duration_s = 9.0
angle_rad = [[-0.8, 0.8], [-0.8, 0.8]]
speed_rad_s = [3.0, 3.0]
roles = [
    { angle = { multisine = { amplitude = 0.4, lowest_hz = 0.2, lines = 4, ramp_s = 2.0 } } },
    { angle = { multisine = { amplitude = 0.45, lowest_hz = 0.2, lines = 4, ramp_s = 2.0 } } },
]
[stop]
after_s = 9.6
[expect]
experiments_end = \"finished\"
";

/// Two setpoints, at which the arm is to come to rest.
const STAND: &str = "title = \"t\"
control = \"compensated\"
set = { limits.silence_ms = 2000, limits.hold_ms = 2000 }
[[step]]
at_s = 0.0
regulate_rad = [0.0, 0.0]
[[step]]
at_s = 0.5
regulate_rad = [0.15, -0.1]
[stop]
after_s = 2.5
[expect]
settles_within_s = 1.2
";

/// The plan's file, and the folder for its runs.
fn plan(test: &str) -> [String; 2] {
    let base = folder().join(format!("identify-{test}"));
    let _ = std::fs::remove_dir_all(&base);
    std::fs::create_dir_all(&base).unwrap();
    let file = base.join("swing.toml");
    std::fs::write(&file, PLAN).unwrap();
    [file, base].map(|path| path.to_str().unwrap().to_owned())
}

/// The same with these words after it.
fn args<'a>([plan, out]: &'a [String; 2], more: &[&'a str]) -> Vec<&'a str> {
    let args = ["identify", "run", "--plan", plan.as_str(), "--out", out];
    [&args[..], more].concat()
}

/// The run folder that was printed last.
fn left(output: &Output) -> PathBuf {
    folder().join(text(&output.stdout).lines().last().unwrap())
}

#[test]
fn nothing_moves_without_a_yes() {
    let board = Served::on(TCP);
    let plan = plan("no");
    for answer in ["no\n", "y\n", ""] {
        let mut command = command(&board.link, &args(&plan, &[]));
        command.stdin(Stdio::piped());
        command.stdout(Stdio::piped()).stderr(Stdio::piped());
        let mut child = command.spawn().unwrap();
        child
            .stdin
            .take()
            .unwrap()
            .write_all(answer.as_bytes())
            .unwrap();
        let output = child.wait_with_output().unwrap();
        assert_ends(&output, 2, "nothing has moved");
        let output_text = text(&output.stdout);
        assert!(
            output_text.contains("[-0.80 to +0.80 rad (-46 to +46°)]"),
            "{output_text}"
        );
        assert!(text(&output.stderr).contains("will move"));
        // The picture that was asked about; no log.
        let run = PathBuf::from(output_text.lines().last().unwrap());
        assert!(run.is_file() && !run.with_file_name("run.mcap").exists());
        board.until_off();
        assert_eq!(board.seen().mode, Mode::Idle, "{answer:?}");
    }
}

#[test]
fn the_boards_own_limits_are_asked_first() {
    let board = Served::on(TCP);
    let plan = plan("limits");
    assert_ends(
        &run(&board.link, &["params", "limits.angle_rad=0.9,1.5"]),
        0,
        "has taken it",
    );
    let output = run(&board.link, &args(&plan, &["--yes"]));
    assert_ends(
        &output,
        2,
        "step 2 at 0.5 s: joint 1 would be braked before its angle limit",
    );
    assert_eq!(board.seen().mode, Mode::Idle);
    assert_eq!(
        std::fs::read_dir(&plan[1]).unwrap().count(),
        1,
        "only the plan"
    );
}

#[cfg(unix)]
#[test]
fn ctrl_c_switches_off_and_leaves_the_log() {
    let board = Served::on(TCP);
    let plan = plan("ctrl-c");
    let child = spawn(&board.link, &args(&plan, &["--yes", "--apply"]));
    board.until("it swings", |seen| {
        seen.mode.drive() == Some(Drive::Experiment)
    });
    interrupt(&child);
    let output = child.wait_with_output().unwrap();
    assert_ends(&output, 130, "ended early: ctrl-c; motors are off");
    board.until_off();
    let run = left(&output);
    let log = Recording::load(&run.join("run.mcap")).unwrap();
    assert!(!log.records().is_empty());
    assert_eq!(log.damage, [""; 0]);
    assert!(!run.join("arm.toml").exists());
}

/// An arm that the board does not know, as a plant file has it.
const HIDDEN: &str = "[arm]
i1x = 0.018
b1 = 0.33
b2 = 0.11
[joint1]
gain_counts_per_nm = 700.0
";

/// Plan, log, fit, apply; the board has the arm, and stands by it.
fn find_apply_and_stand(link: &LinkUri, plan: &[String; 2]) {
    let output = run(link, &args(plan, &["--yes", "--apply"]));
    let saved = "has taken it, and keeps its settings across power-off";
    assert_ends(&output, 0, saved);
    let truth = [
        ("arm.b1_nm_s_rad", 0.33),
        ("arm.b2_nm_s_rad", 0.11),
        ("joint1.gain_counts_per_nm", 700.0),
    ];
    let keys = truth.map(|(key, _)| key);
    let parameters = run(link, &[&["params"][..], &keys[..], &["--json"]].concat());
    let parameters: serde_json::Value = serde_json::from_slice(&parameters.stdout).unwrap();
    for (number, (key, truth)) in parameters.as_array().unwrap().iter().zip(truth) {
        let found = number["value"].as_f64().unwrap();
        assert!((found / truth - 1.0).abs() < 0.15, "{key}: {found}");
    }
    // The same log once more is nothing new.
    let log = left(&output);
    let fit = ["identify", "fit", log.to_str().unwrap(), "--apply", "--yes"];
    assert_ends(&run(link, &fit), 0, "the board has this arm already");
    let stand = PathBuf::from(&plan[1]).join("stand.toml");
    std::fs::write(&stand, STAND).unwrap();
    let stand = ["run", stand.to_str().unwrap(), "--json", "--out", &plan[1]];
    assert_ends(&run(link, &stand), 0, "\"faults\":[]");
}

#[test]
fn what_was_found_reaches_the_board_and_stands_with_it() {
    let plan = plan("apply");
    let hidden = PathBuf::from(&plan[1]).join("hidden.toml");
    std::fs::write(&hidden, HIDDEN).unwrap();
    let arm = PlantFile::read(&hidden).unwrap().config([0.0; 2]);
    find_apply_and_stand(&Served::with_arm(TCP, &arm).link, &plan);
}

#[cfg(unix)]
#[test]
#[ignore = "needs QEMU and the firmware image: run `cargo verify`"]
fn what_was_found_reaches_the_emulated_board_too() {
    let plan = plan("emulated");
    let hidden = PathBuf::from(&plan[1]).join("hidden.toml");
    std::fs::write(&hidden, HIDDEN).unwrap();
    let mut board = Command::new(env!("CARGO_BIN_EXE_armbridge"));
    board.args(["serve", "board", "--link", "emulate:", "--listen", TCP]);
    board.args(["--initial", "0,0"]);
    board.args(["--quiet", "--plant", hidden.to_str().unwrap()]);
    let mut board = board.stderr(Stdio::piped()).spawn().unwrap();
    let mut lines = BufReader::new(board.stderr.take().unwrap()).lines();
    let output_text = lines.next().unwrap().unwrap();
    let name = output_text.strip_prefix("control link on ").unwrap();
    let link = name.split(';').next().unwrap().parse().unwrap();
    let performed = std::panic::catch_unwind(|| find_apply_and_stand(&link, &plan));
    board.kill().unwrap();
    board.wait().unwrap();
    performed.unwrap();
}
