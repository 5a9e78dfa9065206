//! The first lines of a run: they fit what the arm has done.

use armbridge_tests::served_board::Served;

use super::links::program::{TCP, text};
use super::program::Program;

/// Standard output on one line.
fn printed(program: &Program, args: &[&str]) -> String {
    text(&program.run(args).stdout).replace('\n', " ")
}

/// A short scenario with pushes.
fn scenario(pushes: &[f64]) -> String {
    let head = "title = 'Pushes'\nabout = 'It is pushed.'\n[stop]\nafter_s = 0.9\n";
    let step = "[[step]]\nat_s = 0.0\nregulate_rad = [0.0, 0.0]\n";
    let push = |at_s: &f64| {
        format!("[[bench.push]]\nat_s = {at_s}\njoint = 1\ntorque_nm = 0.2\nduration_s = 0.1\n")
    };
    let pushes: String = pushes.iter().map(push).collect();
    [head, step, &pushes].concat()
}

#[test]
fn where_the_arm_begins_and_what_pushes_it_is_told_of_a_simulated_one() {
    let program = Program::new("headline-begins");
    for (pushes, left_out) in [
        (&[0.4][..], "the scenario's push is left out: a run pushes"),
        (
            &[0.4, 0.6],
            "the scenario's 2 pushes are left out: a run pushes",
        ),
    ] {
        program.write("pushes.toml", &scenario(pushes));
        let args = ["run", "pushes.toml", "--initial", "0.1,-0.2"];
        let out = printed(&program, &args);
        let about = "Let go at +0.10 and -0.20 rad. It is pushed.";
        assert!(out.contains(about), "{out}");
        // A served arm is wherever it is.
        let board = Served::on(TCP);
        let link = board.link.to_string();
        let output = program.run(&["run", "pushes.toml", "--link", &link]);
        let (out, notes) = (text(&output.stdout), text(&output.stderr));
        assert_eq!(output.status.code(), Some(0), "{notes}");
        assert!(
            !out.contains("Let go at") && !out.contains("It is pushed"),
            "{out}"
        );
        assert!(out.contains("Pushes"), "{out}");
        assert!(notes.contains(left_out), "{notes}");
    }
    // A run that is cut short has its title, not the outcome that it was meant to have.
    let out = printed(&program, &["run", "pushes.toml", "--duration", "0.5"]);
    assert!(
        out.contains("Pushes") && !out.contains("It is pushed"),
        "{out}"
    );
}

/// It floats where it is served, too, and what a hand would have shown is not expected.
#[test]
fn hands_lead_a_simulated_arm_alone() {
    let program = Program::new("headline-hands");
    program.write(
        "led.toml",
        "title = 'Led'\nabout = 'A hand leads it.'\n[[step]]\nat_s = 0.0\nfloat = true\n\
         [[bench.hand]]\nat_s = 1.5\npath = [{ after_s = 0.5, angle_rad = [0.2, -0.2] }]\n\
         [stop]\nafter_s = 3.0\n[expect]\nstays_within_rad = 0.1\n",
    );
    let out = printed(&program, &["run", "led.toml"]);
    let ended = "complete, and ended as it should. Let go at +0.30 and -0.25 rad. A hand leads it.";
    assert!(out.contains(ended), "{out}");
    let board = Served::on(TCP);
    let output = program.run(&["run", "led.toml", "--link", &board.link.to_string()]);
    let (out, notes) = (text(&output.stdout), text(&output.stderr));
    assert_eq!(output.status.code(), Some(0), "{notes}");
    assert!(!out.contains("A hand leads it"), "{out}");
    assert!(notes.contains("`[[bench.hand]]` are left out"), "{notes}");
}

#[test]
fn an_arm_that_falls_in_an_experiment_is_not_said_to_balance() {
    let program = Program::new("headline-experiment");
    let out = printed(&program, &["run", "free-fall"]);
    assert!(out.contains("complete, and ended as it should. Let go and fall"));
    assert!(!out.contains("balances"), "{out}");
}

/// The baseline, which goes on to its end, is nothing to compare with it.
#[test]
fn a_run_that_fails_at_once_is_not_compared() {
    let program = Program::new("headline-failed");
    let slow = "limits.speed_rad_s=[0.2,0.2]";
    let out = printed(&program, &["run", "demo", "--set", slow]);
    assert!(out.contains("The run FAILED at 0.0"), "{out}");
    assert!(!out.contains("static friction holds it"), "{out}");
    assert!(!out.contains("It stands upright"), "{out}");
    assert!(!out.contains("· 0 s in"), "{out}");
}
