//! The program as a user meets it: what it prints, where, and how it ends.

use std::fs;
use std::net::TcpListener;
use std::process::{Output, Stdio};

use crate::program::{Program, text};

/// One line on standard error with these words, and exit code 2.
fn assert_fails(output: &Output, words: &[&str]) {
    let line = text(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{line}");
    assert_eq!(line.trim_end().lines().count(), 1, "{line}");
    assert!(line.starts_with("armbridge: ") && !line.contains("panicked"));
    for word in words {
        assert!(line.contains(word), "no {word:?} in {line:?}");
    }
    assert_eq!(text(&output.stdout), "");
}

#[test]
fn wrong_arguments_say_what_is_right() {
    let program = Program::new("cli-arguments");
    for (args, words) in [
        (["run", "--duration", "0"].as_slice(), "seconds from 0.1"),
        (&["run", "--duration", "-1"], "seconds from 0.1"),
        (&["run", "--seed", "99999999999999999999"], "from 0 to 1844"),
        (&["trials", "--loss", "-0.5"], "fraction from 0 to 1"),
        (&["run", "--set", "period"], "is not KEY=VALUE"),
        (&["run", "--initial", "2,0"], "expected two angles"),
        (
            &["serve", "servos", "--listen", "localhost:1"],
            "tcp://HOST:PORT",
        ),
        (&["serve", "servos"], "--listen"),
        (
            &["serve", "servos", "--listen", "pty:", "--slow", "0"],
            "1..=10000",
        ),
        (&["demo", "--seed", "2"], "`armbridge run demo`"),
        (&["balance"], "balance"),
        (&["trials", "--q", "1,2"], "expected 4 numbers"),
        (&["trials", "--seeds", "5..1"], "expected seeds"),
        (&["trials", "--disturb", "3,1,1,1"], "joint 1 or 2"),
        (&["trials", "--loss", "1.5"], "fraction from 0 to 1"),
        (&["trials", "--reference", "sine:9,9,1"], "sine:A1,A2,HZ"),
        (&["trials", "--best", "--estimator", "kalman"], "--best"),
        (&["fault-campaign", "--kinds", "gremlins"], "servo-deaf"),
        (&["fault-campaign", "--activity", "tango"], "float"),
    ] {
        assert_fails(&program.run(args), &[words, "--help"]);
    }
}

#[test]
fn a_command_of_commands_alone_prints_its_help_as_it_is_laid_out() {
    let program = Program::new("cli-alone");
    for command in ["serve", "identify", "servo"] {
        let output = program.run(&[command]);
        assert_eq!(output.status.code(), Some(2));
        let help = text(&output.stderr);
        let usage = format!("\nUsage: armbridge {command}");
        assert!(help.contains(&usage) && help.lines().count() > 10, "{help}");
    }
}

#[test]
fn a_campaign_repeats_and_a_seed_is_told() {
    let program = Program::new("cli-campaign");
    let args = [
        "fault-campaign",
        "--seeds",
        "60..116",
        "--kinds",
        "goodbye,stop-pin",
    ];
    let json = |args: &[&str]| program.run(&[args, &["--json"]].concat());
    let [first, second] = [json(&args), json(&args)];
    assert_eq!(first.status.code(), Some(0), "{}", text(&first.stdout));
    assert_eq!(text(&first.stdout), text(&second.stdout));
    let report: serde_json::Value = serde_json::from_slice(&first.stdout).unwrap();
    let names: Vec<&str> = report["singles"]
        .as_array()
        .unwrap()
        .iter()
        .map(|row| row["name"].as_str().unwrap())
        .collect();
    assert_eq!(names, ["goodbye", "stop-pin"]);

    // A kind that boards do not detect yet fails too, and is counted apart.
    for (seeds, words) in [
        ("--seed=166", "FAILED, boards do not detect this kind yet"),
        (
            "--seeds=166..167",
            "1 cases: 0 failed, and 1 failed that have a kind",
        ),
    ] {
        let open = program.run(&["fault-campaign", seeds]);
        assert_eq!(open.status.code(), Some(1));
        let open = text(&open.stdout);
        assert!(open.contains(words), "{open}");
    }

    let detected = program.run(&["fault-campaign", "--seed", "17"]);
    let detected = text(&detected.stdout);
    assert!(
        detected.contains("detected after ") && !detected.contains("Some("),
        "{detected}"
    );

    let story = program.run(&["fault-campaign", "--seed", "114"]);
    assert_eq!(story.status.code(), Some(0));
    let story = text(&story.stdout);
    for words in [
        "stop-pin",
        "Fault(EmergencyStop(Pin))",
        "emergency_stop_pin, expected",
    ] {
        assert!(story.contains(words), "{story}");
    }
}

#[test]
fn a_taken_port_is_named() {
    let program = Program::new("cli-taken");
    let taken = TcpListener::bind("127.0.0.1:0").unwrap();
    let at = format!("tcp://{}", taken.local_addr().unwrap());
    let output = program.run(&["serve", "servos", "--listen", &at]);
    assert_fails(&output, &[&at, "taken", "another port"]);
}

#[test]
fn a_folder_that_cannot_be_made_is_named() {
    let program = Program::new("cli-folder");
    fs::write(program.0.join("file"), "in the way").unwrap();
    let output = program.run(&["run", "--duration", "0.5", "--out", "file/runs"]);
    assert_fails(&output, &["file", "--out"]);
    let output = program.run(&["paper", "--out", "file/runs"]);
    assert_fails(&output, &["file", "--out"]);
}

#[test]
fn the_demo_writes_every_file_and_prints_a_table() {
    let program = Program::new("cli-demo");
    let output = program.run(&["run", "--duration", "1"]);
    assert!(output.status.success(), "{}", text(&output.stderr));
    let printed = text(&output.stdout);
    let folder = program.0.join(armbridge_tests::paths::run_folder(printed));
    assert!(folder.starts_with(program.0.join("runs")));
    let widest = printed.lines().map(|line| line.chars().count()).max();
    assert!(
        printed.lines().count() <= 24 && widest <= Some(80),
        "{printed}"
    );

    let mut names: Vec<String> = fs::read_dir(&folder)
        .unwrap()
        .map(|entry| entry.unwrap())
        .inspect(|entry| assert!(entry.metadata().unwrap().len() > 100, "{entry:?}"))
        .map(|entry| entry.file_name().into_string().unwrap())
        .collect();
    names.sort();
    let expected = [
        "angles.png",
        "angles.svg",
        "baseline.mcap",
        "run.html",
        "run.mcap",
        "timing.png",
        "timing.svg",
        "torque.png",
        "torque.svg",
    ];
    assert_eq!(names, expected);
}

#[test]
fn nobody_reads_the_table() {
    let program = Program::new("cli-pipe");
    let mut command = program.command(&["run", "--duration", "1"]);
    command.stdout(Stdio::piped()).stderr(Stdio::piped());
    let mut child = command.spawn().unwrap();
    drop(child.stdout.take());
    let output = child.wait_with_output().unwrap();
    assert_eq!(text(&output.stderr), "");
    // 128 and the number of SIGPIPE, as of other programs.
    assert_eq!(output.status.code(), Some(141));
    assert_eq!(fs::read_dir(program.0.join("runs")).unwrap().count(), 1);
}

#[test]
fn json_is_one_object_and_quiet_is_nothing() {
    let program = Program::new("cli-output");
    let run = |option| {
        let output = program.run(&["run", "demo", option, "--duration", "1", "--seed", "3"]);
        assert!(output.status.success(), "{}", text(&output.stderr));
        assert_eq!(text(&output.stderr), "");
        output.stdout
    };
    let json = run("--json");
    let summary: serde_json::Value = serde_json::from_slice(&json).unwrap();
    assert!(summary.is_object() && text(&json).lines().count() == 1);
    assert_eq!(text(&run("--quiet")), "");
    assert_eq!(fs::read_dir(program.0.join("runs")).unwrap().count(), 2);
}

#[test]
fn the_paper_is_a_page_and_a_json_object() {
    let program = Program::new("cli-paper");
    let output = program.run(&["paper", "--json", "--out", "here"]);
    assert!(output.status.success(), "{}", text(&output.stderr));
    let outline: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    let page = outline["report"].as_str().unwrap();
    assert!(page.starts_with("here") && program.0.join(page).is_file());
    let claims = outline["claims"].as_array().unwrap();
    let lqr = claims.iter().find(|claim| claim["id"] == "lqr").unwrap();
    assert_eq!(lqr["verdict"], "reproduced");
    assert_eq!(lqr["as_printed"][0]["holds"], true);
}

#[test]
fn a_trial_that_makes_no_sense_says_why() {
    let program = Program::new("cli-trial");
    fs::write(program.0.join("arm.toml"), "\ntorque_gian = 0.8\n").unwrap();
    for (args, words) in [
        (
            ["--controller", "paper", "--q", "1,1,1,1"],
            ["--q", "`lqr`"],
        ),
        (
            ["--estimator", "kalman", "--filter", "0.1"],
            ["--filter", "`filtered`"],
        ),
        (
            ["--reference", "sine:0.1,0.1,1", "--duration", "3"],
            ["6 s", "--duration"],
        ),
        (
            ["--reference", "sine:1,1,3", "--seeds", "1"],
            ["refused", "rad/s²"],
        ),
        (
            ["--plant", "none.toml", "--seeds", "1"],
            ["none.toml", "cannot read"],
        ),
        (
            ["--plant", "arm.toml", "--seeds", "1"],
            ["arm.toml:2:1", "`torque_gain`"],
        ),
    ] {
        assert_fails(
            &program.run(&[&["trials"], args.as_slice()].concat()),
            &words,
        );
    }
}

#[test]
fn trials_are_a_table_or_a_json_object_and_plots() {
    let program = Program::new("cli-trials");
    let trials = ["trials", "--seeds", "1..2", "--duration", "2"];
    let output = program.run(&trials);
    assert!(output.status.success(), "{}", text(&output.stderr));
    let lines: Vec<&str> = text(&output.stdout).lines().collect();
    assert_eq!(lines.len(), 7, "{lines:?}");
    assert!(lines[5].starts_with("worst") && lines[6].starts_with("mean"));

    let options = ["--json", "--plot", "plots", "--disturb", "1,0.2,1,0.05"];
    let output = program.run(&[trials.as_slice(), &options].concat());
    let report: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(report["outcomes"][1]["seed"], 2);
    assert!(report["outcomes"][0]["settling_time_s"].as_f64().unwrap() < 1.0);
    assert_eq!(report["trial"]["plant"]["joint1"]["initial_rad"], 0.49);
    for name in ["angles.svg", "torque.png", "run.csv", "run.mcap"] {
        assert!(program.0.join("plots").join(name).is_file(), "{name}");
    }
}

/// As a run measures it: within 20 mrad, and from the step on.
#[test]
fn trials_settle_as_a_run_does() {
    let program = Program::new("trials-settling");
    let settling_s = |args: &[&str]| {
        let report = program.json(&[&["trials", "--json"], args].concat());
        report["outcomes"][0]["settling_time_s"].as_f64().unwrap()
    };
    // Within 15 mrad it takes 0.743 s.
    let rest_s = settling_s(&[]);
    assert!((0.62..0.72).contains(&rest_s), "{rest_s} s");
    // The step comes 2 s after the beginning.
    let step_s = settling_s(&["--reference", "step:0.2,-0.1"]);
    assert!((0.4..0.7).contains(&step_s), "{step_s} s");
}
