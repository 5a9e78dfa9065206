//! `armbridge identify paper` as a user meets it: the paper's two experiments simulated,
//! and recorded by the board on the bench's arm.

use armbridge_tests::paper_runs::{DRY, Place, SMOOTH};
use serde_json::Value;

/// The program, in a folder of this test alone.
fn place(test: &str) -> Place {
    let folder = crate::folder(&format!("paper-{test}"));
    Place::new(env!("CARGO_BIN_EXE_armbridge"), folder)
}

/// A number of the fit of this experiment by this model.
fn number(found: &Value, experiment: &Value, model: &str, name: &str) -> f64 {
    let lines = found["lines"].as_array().unwrap();
    let is_it = |line: &&Value| line["experiment"] == *experiment && line["model"] == model;
    let line = lines.iter().find(is_it).expect("a line");
    line[name]["value"].as_f64().expect("a number")
}

fn near(what: &str, found: f64, expected: f64, tolerance: f64) {
    let error = (found - expected).abs();
    assert!(error < tolerance, "{what}: {found}, not {expected}");
}

#[test]
fn without_a_log_both_are_simulated() {
    let place = place("simulated");
    let text = place.printed(&["identify", "paper"]);
    let words = text.split_whitespace().collect::<Vec<_>>().join(" ");
    for expected in [
        "simulated: the paper's arm",
        "samples every 45 ms",
        "free fall viscous only 0.42",
        "constant input viscous only 0.239",
        "viscous friction alone is of the wrong form for the free fall",
        "belong to one arm with b1 = 0.239 N m s/rad and 0.107 N m of dry friction",
        "torque and dry friction are not separately identifiable",
    ] {
        assert!(words.contains(expected), "no {expected:?} in\n{text}");
    }
    for file in text.lines().rev().take(2) {
        assert!(place.folder.join(file).is_file(), "{file}");
    }
}

#[test]
fn two_values_of_the_boards_logs_become_one() {
    let place = place("dry");
    let [fall, push] = [Value::from("free_fall"), Value::from("constant_input")];
    for seed in ["1", "2", "3"] {
        let logs = [
            place.record("paper-free-fall", seed, DRY, ""),
            place.record("paper-constant-input", seed, DRY, "-0.4997 }"),
        ];
        let found = place.json(&["identify", "paper", &logs[0], &logs[1], "--json"]);
        let number = |experiment, model, name| number(&found, experiment, model, name);
        // The paper's two values, from a shorter fall than the paper's.
        near("fall", number(&fall, "viscous_only", "b1"), 0.421, 0.02);
        near("push", number(&push, "viscous_only", "b1"), 0.239, 0.005);
        near(
            "torque",
            number(&push, "viscous_only", "torque_nm"),
            -0.3924,
            0.003,
        );
        // One arm.
        let both = |name| number(&Value::Null, "with_dry_friction", name);
        near("b1", both("b1"), 0.239, 0.004);
        near("dry friction", both("coulomb_nm"), 0.107285, 0.004);
        near("motor", both("torque_nm"), -0.4997, 0.003);
        near(
            "alone",
            number(&fall, "with_dry_friction", "b1"),
            0.239,
            0.012,
        );
        assert_eq!(found["form"]["is_wrong"], true, "{}", found["form"]);
        println!("seed {seed}: {}", found["lines"]);

        // With the paper's rate there are twenty samples of the fall: less is known.
        let few = place.json(&[
            "identify",
            "paper",
            &logs[0],
            &logs[1],
            "--json",
            "--as-paper",
        ]);
        near("period", few["period_s"].as_f64().unwrap(), 0.045, 1e-12);
        let few = |model, name| self::number(&few, &Value::Null, model, name);
        near("b1", few("with_dry_friction", "b1"), 0.239, 0.03);
    }
}

#[test]
fn an_arm_without_dry_friction_has_one_value_and_no_warning() {
    let place = place("smooth");
    let [fall, push] = [Value::from("free_fall"), Value::from("constant_input")];
    for seed in ["1", "2", "4"] {
        let logs = [
            place.record("paper-free-fall", seed, SMOOTH, ""),
            place.record("paper-constant-input", seed, SMOOTH, "-0.3924 }"),
        ];
        let found = place.json(&["identify", "paper", &logs[0], &logs[1], "--json"]);
        for experiment in [&fall, &push] {
            let b1 = number(&found, experiment, "viscous_only", "b1");
            // The paper takes the arm for at rest: held in air without friction, it is
            // not quite.
            near("b1 as the paper", b1, 0.24, 0.015);
        }
        let both = |name| number(&found, &Value::Null, "with_dry_friction", name);
        near("b1", both("b1"), 0.24, 0.004);
        near("dry friction", both("coulomb_nm"), 0.0, 0.004);
        assert_eq!(found["form"]["is_wrong"], false, "{}", found["form"]);
        let sentences = found["sentences"].to_string();
        assert!(!sentences.contains("Warning"), "{sentences}");
        assert!(
            sentences.contains("agree without dry friction"),
            "{sentences}"
        );
    }
}

#[test]
fn logs_that_are_of_no_use_are_told() {
    let place = place("poor");
    let record = |scenario| {
        let printed = place.printed(&["run", scenario]);
        armbridge_tests::paths::run_folder(&printed).to_owned()
    };
    let [upright, bent] = [record("stiction"), record("free-fall")];
    let push = record("paper-constant-input");
    let other = place.record("paper-constant-input", "1", "", "-0.42 }");
    for (args, words) in [
        (
            vec![upright.as_str()],
            "neither a free fall nor a constant input",
        ),
        (vec![&bent], "rad from straight in the free fall"),
        (vec![&push, &other], "give logs of one"),
        (vec!["none.mcap"], "no such file"),
    ] {
        let args = [&["identify", "paper"], args.as_slice()].concat();
        let output = place.run(&args);
        let line = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{line}");
        assert!(line.contains(words), "{line}");
        assert_eq!(line.trim_end().lines().count(), 1, "{line}");
    }
}
