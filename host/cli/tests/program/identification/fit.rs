//! `armbridge identify` as a user meets it, with the arm of the bench.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

/// The program, in a folder of this test alone, and that folder.
fn program(test: &str) -> (PathBuf, impl Fn(&[&str]) -> Output) {
    let folder = crate::folder(&format!("identify-{test}"));
    (folder.clone(), program_in(folder))
}

fn program_in(folder: PathBuf) -> impl Fn(&[&str]) -> Output {
    move |args| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_armbridge"));
        let command = command.args(args).current_dir(&folder);
        command.env_remove("ARMBRIDGE_LINK").output().unwrap()
    }
}

fn text(bytes: &[u8]) -> &str {
    std::str::from_utf8(bytes).unwrap()
}

#[test]
fn the_benchs_arm_is_identified_from_its_logs_and_a_board_takes_it() {
    let (folder, program) = program("fit");
    let run = |scenario: &str| {
        let output = program(&["run", scenario]);
        let printed = text(&output.stdout);
        armbridge_tests::paths::run_folder(printed).to_owned()
    };
    let logs = [run("multisine"), run("sweep")];
    let fit = ["identify", "fit", &logs[0], &logs[1]];
    let more = [
        "--json",
        "--out",
        "arm.toml",
        "--report",
        "page",
        "--held-out",
        &logs[0],
    ];
    let output = program(&[&fit[..], &more].concat());
    assert!(output.status.success(), "{}", text(&output.stderr));
    let found: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    // The prior is the bench's arm.
    for number in found["estimates"].as_array().unwrap() {
        let name = number["name"].as_str().unwrap();
        if name == "delay" || name.starts_with("dead zone") {
            continue;
        }
        let value = |key: &str| number[key].as_f64().unwrap();
        let off = (value("value") - value("prior_mean")).abs();
        // Four standard errors.
        assert!(off < 2.05 * value("half_width_95"), "{number}");
    }
    for forecast in found["forecasts"].as_array().unwrap() {
        let rms = forecast["rms_counts"].as_f64().unwrap();
        assert!((0.8..1.5).contains(&rms), "{forecast}");
    }
    assert_eq!(found["checks"]["warnings"], serde_json::json!([]));
    let page = fs::read_to_string(folder.join("page/report.html")).unwrap();
    for heading in [
        "Identifiability",
        "Holdout",
        "Parameters",
        "Friction",
        "Model errors",
    ] {
        assert!(page.contains(heading), "{heading}");
    }
    // The page is self-contained.
    assert_eq!(page.matches("<svg ").count(), 5);
    assert!(!page.contains("src=") && !page.contains("href=") && !page.contains("url(http"));
    for picture in [
        "windows-1",
        "windows-2",
        "residuals",
        "friction",
        "correlations",
    ] {
        let png = fs::read(folder.join(format!("page/{picture}.png"))).unwrap();
        assert!(
            png.starts_with(b"\x89PNG") && png.len() > 20_000,
            "{picture}"
        );
        assert!(
            folder.join(format!("page/{picture}.svg")).exists(),
            "{picture}"
        );
    }
    let output = program(&["params", "--from", "arm.toml"]);
    assert!(output.status.success(), "{}", text(&output.stderr));
    assert!(text(&output.stdout).contains("the board has taken it"));
}

#[test]
fn logs_that_do_not_identify_the_arm_are_diagnosed() {
    let (folder, program) = program("poor");
    let output = program(&["run", "free-fall"]);
    let log = armbridge_tests::paths::run_folder(text(&output.stdout)).to_owned();
    let output = program(&["identify", "fit", &log, "--out", "arm.toml"]);
    let line = text(&output.stderr);
    assert_eq!(output.status.code(), Some(1), "{line}");
    assert!(
        line.starts_with("not identified: too short a log: "),
        "{line}"
    );
    assert_eq!(line.trim_end().lines().count(), 1, "{line}");
    assert!(output.stdout.is_empty());
    assert!(!folder.join("arm.toml").exists());
    let output = program(&["identify", "fit", &log, "--json"]);
    assert_eq!(output.status.code(), Some(1));
    let output: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert!(
        output["diagnosis"]
            .as_str()
            .unwrap()
            .starts_with("too short"),
        "{output}"
    );
    let output = program(&["identify", "fit", &log, "--report", "page"]);
    assert_eq!(output.status.code(), Some(1));
    let page = fs::read_to_string(folder.join("page/report.html")).unwrap();
    assert!(page.contains("too short a log: "));
    let idle = "title = \"Idle\"\n[[step]]\nat_s = 0.1\nidle = true\n[stop]\nafter_s = 0.2\n";
    fs::write(folder.join("idle.toml"), idle).unwrap();
    let output = program(&["run", "idle.toml"]);
    let log = armbridge_tests::paths::run_folder(text(&output.stdout)).to_owned();
    let output = program(&["identify", "fit", &log]);
    let line = text(&output.stderr);
    assert_eq!(output.status.code(), Some(1), "{line}");
    assert!(line.starts_with("not identified: empty: "), "{line}");
    let output = program(&["identify", "fit", "none.mcap"]);
    let line = text(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{line}");
    assert!(line.contains("no such file"), "{line}");
}

#[test]
fn an_external_torque_is_reported_with_its_time() {
    let (folder, program) = program("push");
    let shown = program(&["run", "--show", "multisine"]);
    let pushed = text(&shown.stdout).replace(
        "[bench]",
        "[[bench.push]]\nat_s = 20.0\njoint = 2\ntorque_nm = 0.2\nduration_s = 1.0\n\n[bench]",
    );
    fs::write(folder.join("pushed.toml"), pushed).unwrap();
    let output = program(&["run", "pushed.toml"]);
    let log = armbridge_tests::paths::run_folder(text(&output.stdout)).to_owned();
    let output = program(&["identify", "fit", &log, "--out", "arm.toml"]);
    let line = text(&output.stderr);
    assert_eq!(output.status.code(), Some(1), "{line}");
    assert!(
        line.starts_with("not identified: external torque: from "),
        "{line}"
    );
    assert!(line.contains("act on joint 2"), "{line}");
    assert!(output.stdout.is_empty() && !folder.join("arm.toml").exists());
}

/// An arm unknown to the board.
const HIDDEN: &str = "[arm]\ni1x = 0.018\nb1 = 0.33\nb2 = 0.11\n
[joint1]\ngain_counts_per_nm = 700.0\n[joint2]\ngain_counts_per_nm = 950.0\n";

/// Plan in which both joints swing, of this duration and amplitude.
fn swing(duration_s: f32, amplitude_rad: f32) -> String {
    let end_s = duration_s + 0.6;
    let role = format!(
        "{{ angle = {{ multisine = {{ amplitude = {amplitude_rad}, lowest_hz = 0.2, lines = 4, \
         ramp_s = 2.0 }} }} }}"
    );
    format!(
        "title = \"t\"\ncontrol = \"compensated\"\n[set]\ncontroller.kind = \"computed-torque\"\n\
         controller.natural_rad_s = [20.0, 20.0]\n[bench]\ninitial_rad = [0.0, 0.0]\n[[step]]\n\
         at_s = 0.0\nregulate_rad = [0.0, 0.0]\n[[step]]\nat_s = 0.5\n[step.experiment]\n\
         duration_s = {duration_s}\nangle_rad = [[-0.8, 0.8], [-0.8, 0.8]]\n\
         speed_rad_s = [3.0, 3.0]\nroles = [{role}, {role}]\n[stop]\nafter_s = {end_s}\n\
         [expect]\nexperiments_end = \"finished\"\n"
    )
}

/// The only run folder.
fn only_run(folder: &Path) -> PathBuf {
    let runs = fs::read_dir(folder.join("runs")).unwrap();
    let runs: Vec<PathBuf> = runs.map(|run| run.unwrap().path()).collect();
    assert_eq!(runs.len(), 1, "{runs:?}");
    runs[0].clone()
}

#[test]
fn a_dry_run_shows_what_would_be_swept_and_needs_no_board() {
    let folder = crate::folder("identify-dry-run");
    let program = program_in(folder.clone());
    let output = program(&["identify", "run", "--plan", "sweep", "--dry-run"]);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    let output_text = text(&output.stdout);
    for words in [
        "8 steps in 20.0 s",
        "+0.00 to +1.10 rad (+0 to +63°)",
        "[-0.90 to +0.90 rad (-52 to +52°)]  2.50 rad/s",
        "joint 1 held, joint 2 PWM pulses",
        "beyond 1.50 and 1.50 rad (86 and 86°)",
    ] {
        assert!(output_text.contains(words), "no {words:?} in {output_text}");
    }
    let run = only_run(&folder);
    let svg = fs::read_to_string(run.join("preview.svg")).unwrap();
    assert!(svg.contains("checked for a board with its default settings"));
    assert!(run.join("preview.png").metadata().unwrap().len() > 10_000);
    // Nothing has moved: there is nothing to record.
    assert_eq!(fs::read_dir(&run).unwrap().count(), 2);

    let output = program(&["identify", "run", "--dry-run", "--json"]);
    let report: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    let joint = &report["outlook"]["stages"][1]["joints"][0];
    assert_eq!(joint["is_guarded"], true);
    assert_eq!(report["preview"].as_array().unwrap().len(), 2);
}

#[test]
fn a_hidden_arm_is_identified_written_and_applied() {
    let folder = crate::folder("identify-run");
    fs::write(folder.join("hidden.toml"), HIDDEN).unwrap();
    fs::write(folder.join("swing.toml"), swing(13.0, 0.4)).unwrap();
    let program = program_in(folder.clone());
    let run = [
        "identify",
        "run",
        "--plan",
        "swing.toml",
        "--plant",
        "hidden.toml",
    ];
    let output = program(&[&run[..], &["--apply", "--json"]].concat());
    let output_text = text(&output.stderr);
    assert_eq!(output.status.code(), Some(0), "{output_text}");
    let report: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(report["applied"], true);
    // The board's gains with it.
    assert!(
        output_text.contains("arm.b1_nm_s_rad") && output_text.contains("disc margin"),
        "{output_text}"
    );
    assert!(output_text.contains("nothing is kept"), "{output_text}");
    let run = only_run(&folder);
    let arm: toml::Table = fs::read_to_string(run.join("arm.toml"))
        .unwrap()
        .parse()
        .unwrap();
    for (group, key, truth) in [
        ("arm", "b1_nm_s_rad", 0.33),
        ("arm", "b2_nm_s_rad", 0.11),
        ("joint1", "gain_counts_per_nm", 700.0),
        ("joint2", "gain_counts_per_nm", 950.0),
    ] {
        let found = arm[group][key].as_float().unwrap();
        assert!((found / truth - 1.0).abs() < 0.1, "{key}: {found}");
        assert!((report["arm"][group][key].as_f64().unwrap() - found).abs() < 1e-3);
    }
    for name in ["preview.svg", "preview.png", "run.mcap", "angles.png"] {
        assert!(run.join(name).is_file(), "{name}");
    }
}

/// The beginning of the default plan on a hanging arm: the fit uses the settings that the plan
/// sets, not those of the board before.
#[test]
fn a_hanging_arm_is_identified() {
    let folder = crate::folder("identify-hangs");
    let program = program_in(folder.clone());
    let shown = program(&["run", "--show", "identify"]);
    let plan = text(&shown.stdout).replacen("[set]", "[set]\narm.mounting = \"hanging\"", 1);
    let (plan, _) = plan.split_once("[[step]]\nat_s = 35.4").unwrap();
    let plan = format!("{plan}[stop]\nafter_s = 35.4\n");
    fs::write(folder.join("plan.toml"), plan).unwrap();
    let hidden = HIDDEN.replacen("[arm]", "[arm]\nmounting = \"hanging\"", 1);
    fs::write(folder.join("hidden.toml"), hidden).unwrap();
    let run = ["identify", "run", "--json", "--plan", "plan.toml"];
    let output = program(&[&run[..], &["--plant", "hidden.toml"]].concat());
    let output_text = text(&output.stderr);
    assert_eq!(output.status.code(), Some(0), "{output_text}");
    let report: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    let numbers = report["fit"]["estimates"].as_array().unwrap();
    for (joint, name, truth) in [
        (1, "inertia", 0.021624),
        (1, "gravity", 0.38909),
        (1, "viscous friction", 0.33),
        (1, "Coulomb friction", 0.04),
        (1, "motor gain", 700.0),
        (1, "encoder zero", 512.0),
        (2, "inertia", 0.023579),
        (2, "gravity", 0.18149),
        (2, "viscous friction", 0.11),
        (2, "Coulomb friction", 0.04),
        (2, "motor gain", 950.0),
        (2, "encoder zero", 512.0),
    ] {
        let matches =
            |number: &&serde_json::Value| number["joint"] == joint && number["name"] == name;
        let number = numbers.iter().find(matches).unwrap();
        let [value, half_width] =
            ["value", "half_width_95"].map(|key| number[key].as_f64().unwrap());
        let off = (value - truth).abs();
        // Three standard errors.
        assert!(
            off < 1.53 * half_width && off < 0.05 * truth,
            "{number}, {truth}"
        );
    }
}

#[test]
fn uncertain_parameters_are_not_applied_even_with_yes() {
    let folder = crate::folder("identify-vague");
    fs::write(folder.join("swing.toml"), swing(7.0, 0.17)).unwrap();
    let program = program_in(folder.clone());
    let run = [
        "identify",
        "run",
        "--plan",
        "swing.toml",
        "--apply",
        "--yes",
    ];
    let output = program(&run);
    let output_text = text(&output.stderr);
    assert_eq!(output.status.code(), Some(1), "{output_text}");
    for words in [
        "'s inertia has a 95 % interval of ±",
        "control needs ±20 %",
        "not applied",
    ] {
        assert!(output_text.contains(words), "no {words:?} in {output_text}");
    }
    assert!(only_run(&folder).join("arm.toml").is_file());
}

#[test]
fn an_uninformative_plan_leaves_its_log_and_a_diagnosis() {
    let folder = crate::folder("identify-nothing");
    let program = program_in(folder.clone());
    let output = program(&["identify", "run", "--plan", "free-fall"]);
    let output_text = text(&output.stderr);
    assert_eq!(output.status.code(), Some(1), "{output_text}");
    assert!(
        output_text.contains("the arm is not identified: ")
            && output_text.contains("too short a log"),
        "{output_text}"
    );
    let run = only_run(&folder);
    assert!(run.join("run.mcap").is_file() && !run.join("arm.toml").exists());
}

#[test]
fn a_plan_that_the_board_would_reject_is_refused_before_anything_moves() {
    let folder = crate::folder("identify-refused");
    let program = program_in(folder.clone());
    let plan = swing(13.0, 0.4).replace("[-0.8, 0.8], [-0.8, 0.8]", "[-0.8, 0.8], [-1.4, 0.8]");
    fs::write(folder.join("wide.toml"), plan).unwrap();
    let output = program(&["identify", "run", "--plan", "wide.toml"]);
    let line = text(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{line}");
    assert_eq!(line.trim_end().lines().count(), 1, "{line}");
    for words in [
        "wide.toml:15:27: step 2 at 0.5 s: joint 2 would be braked before its angle limit",
        "at 3.00 rad/s the envelope may reach to",
        "make it narrower or slower",
    ] {
        assert!(line.contains(words), "no {words:?} in {line}");
    }
    assert!(!folder.join("runs").exists());
}
