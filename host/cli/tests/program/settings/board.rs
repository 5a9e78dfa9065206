//! `params` and `design --apply`, with the board on the bench.

use serde_json::json;

use super::{Program, text};

#[test]
fn get_shows_what_the_board_has() {
    let program = Program::new();
    let table = program.says(&["params"]);
    let mut lines = table.lines();
    let head = lines.next().unwrap();
    assert_eq!(
        head.split_whitespace().collect::<Vec<_>>(),
        ["key", "value"]
    );
    // A screen of 80 columns shows it, and what explains it.
    let explained = program.says(&["params", "limits", "controller.gain"]);
    assert!(explained.contains("\n    Silence of the host after which torque goes off.\n"));
    for line in table.lines().chain(explained.lines()) {
        assert!(line.chars().count() <= 80, "{line}");
    }
    assert!(table.contains("controller.kind") && !table.contains("controller.gain"));
    let hold = program.json(&["params", "limits.hold_ms", "--json", "--link", "sim:"]);
    assert_eq!(hold[0]["value"], json!(100));
    assert_eq!(hold[0]["unit"], json!("ms"));
    assert_eq!(hold[0]["takes"], json!("an integer from 0 to 2000"));
    for (key, words) in [
        ("foo", "the groups are setup, controller, estimator, arm"),
        ("limts", "is it `limits`?"),
        ("limits.hold_mss", "is it `limits.hold_ms`?"),
        ("limits.zzz", "is it `limits."),
        ("z.z", "`armbridge params --all` lists them"),
    ] {
        program.fails(&["params", key], &[words]);
    }
    // A group is all of its parameters; of other kinds only if asked for.
    let group = |args: &[&str]| program.json(args).as_array().unwrap().len();
    assert_eq!(group(&["params", "controller", "--json"]), 4);
    assert_eq!(group(&["params", "controller", "--all", "--json"]), 7);
    let gain = program.says(&["params", "controller.gain"]);
    assert!(gain.contains("Only with controller.kind gain"), "{gain}");
    program.fails(&["params", "limits.hold"], &["is it `limits.hold_ms`?"]);
    program.fails(&["params", "--link", "sam:"], &["expected usb:"]);
}

#[test]
fn set_changes_all_or_nothing_and_says_so() {
    let program = Program::new();
    let stdout = program.says(&[
        "params",
        "limits.hold_ms=80",
        "controller.q=30,30,0.3,0.3",
        "--save",
    ]);
    let lines: Vec<Vec<&str>> = stdout
        .lines()
        .map(|line| line.split("  ").collect())
        .collect();
    assert_eq!(lines.len(), 3, "{stdout}");
    assert!(
        stdout.contains("[15.0, 15.0, 1.0, 1.0]  ->  [30.0, 30.0, 0.3, 0.3]"),
        "{stdout}"
    );
    // One on the bench ends with the command.
    assert!(
        stdout.ends_with("has taken it; it is simulated and ends here, so nothing is kept\n"),
        "{stdout}"
    );
    let report = program.json(&["params", "limits.hold_ms=80", "--json"]);
    assert_eq!(report["changes"][0]["before"], json!(100));
    assert_eq!(
        (&report["done"], &report["saved"]),
        (&json!(true), &json!(false))
    );
    assert!(
        program
            .says(&["params", "limits.hold_ms=100"])
            .contains("nothing to change")
    );
    assert!(
        program
            .says(&["params", "limits.lost_ms=30", "--dry-run"])
            .contains("dry run")
    );
    for (args, words) in [
        (
            ["params", "limits.hold_ms", "limits.lost_ms=30"].as_slice(),
            "`limits.hold_ms` has no value",
        ),
        (
            &["params", "limits.hold_ms=9999"],
            "an integer from 0 to 2000",
        ),
        (
            &["params", "limits.hold_ms=600"],
            "longer than `limits.silence_ms` (500)",
        ),
        (
            &["params", "controller.damping=1,1"],
            "set `controller.kind` too",
        ),
        (
            &[
                "params",
                "controller.kind=gain",
                "controller.gain=0,0,0,0,0,0,0,0",
            ],
            "the closed loop would grow",
        ),
    ] {
        program.fails(args, &[words]);
    }
}

#[test]
fn a_design_goes_to_the_board_by_hand_or_by_file() {
    let program = Program::new();
    let args = [
        "design",
        "--q",
        "30,30,0.3,0.3",
        "--r",
        "10,10",
        "--estimator",
        "kalman",
    ];
    let with = |more: &[&'static str]| [&args[..], more].concat();
    let shown = program.says(&args);
    for word in [
        "gain",
        "pole of",
        "margin of",
        "each its own",
        "disc margin",
    ] {
        assert!(shown.contains(word), "no {word} in {shown}");
    }
    let report = program.json(&with(&["--json"]));
    assert_eq!(report["parameters"]["controller"]["q"][0], json!(30.0));
    assert_eq!(report["design"]["is_stable"], json!(true));
    let stdout = program.says(&with(&["--apply"]));
    assert!(
        stdout.contains("estimator.kind")
            && stdout.contains("\nthe board has taken it; it is simulated"),
        "{stdout}"
    );

    program.says(&with(&["--write", "gains.toml", "--plot", "step"]));
    let stdout = program.says(&["params", "--from", "gains.toml"]);
    assert!(stdout.contains("[30.0, 30.0, 0.3, 0.3]"), "{stdout}");
    // It is a configuration, too.
    std::fs::rename(program.path("gains.toml"), program.path("armbridge.toml")).unwrap();
    assert_eq!(
        program.json(&["design", "--json"])["design"],
        report["design"]
    );
    for name in ["step.svg", "step.png"] {
        assert!(
            program.path(name).metadata().unwrap().len() > 10_000,
            "{name}"
        );
    }
}

#[test]
fn what_cannot_be_designed_is_refused_in_words() {
    let program = Program::new();
    for (args, words) in [
        (
            ["design", "--q", "1,2"].as_slice(),
            "4 numbers from 0 to 1000000",
        ),
        (
            &["design", "--q", "0,0,0,0"],
            "no gains exist for these weights",
        ),
        (
            &["design", "--poles", "2,0.5,0.5,0.5"],
            "inside the unit circle",
        ),
        (
            &["design", "--natural", "3000,3000"],
            "the closed loop would grow",
        ),
        (
            &["design", "--estimator", "kalmann"],
            "\"luenberger\", \"kalman\", \"difference\" or \"gain\"",
        ),
        (&["design", "--save"], "--apply"),
        (
            &["design", "--arm", "nowhere.toml"],
            "cannot read nowhere.toml",
        ),
        (&["design", "--plot", "no/where.svg"], "no/where"),
        (&["design", "--plot", "step.bmp"], "ending in .svg or .png"),
        (
            &["design", "--q", "1,1,1,1", "--poles", "0.5,0.5,0.5,0.5"],
            "cannot be used with",
        ),
    ] {
        program.fails(args, &[words]);
    }
    // A loop that is stable with the state known may be unstable with this estimator.
    let shaky = [
        "design",
        "--natural",
        "300,300",
        "--set",
        "estimator.kind=difference",
    ];
    let output =
        program.run(&[&shaky[..], &["--set", "estimator.filter_s=0.1", "--apply"]].concat());
    assert_eq!(output.status.code(), Some(1));
    assert!(text(&output.stderr).contains("nothing was sent"));
}
