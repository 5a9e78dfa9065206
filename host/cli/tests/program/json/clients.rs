//! Clients of the book, in Octave, Node and a shell, on a board of their own.

use std::process::Command;

use serde_json::{Value, json};

use super::server;

/// What a client of the book prints, on a board of its own.
fn client(program: &str, arguments: &[&str]) -> String {
    let server = server();
    let (host, port) = server.at.split_once(':').unwrap();
    let place = arguments
        .iter()
        .map(|it| it.replace("HOST", host).replace("PORT", port));
    let output = Command::new("timeout")
        .args(["60", program])
        .args(place)
        .current_dir(concat!(env!("CARGO_MANIFEST_DIR"), "/../doc/clients"))
        .output()
        .unwrap();
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(
        output.status.success(),
        "{text}{}",
        String::from_utf8_lossy(&output.stderr)
    );
    text
}

/// Runs a script of Octave, whose board is at this test's port.
fn octave(script: &str) -> String {
    let text = std::fs::read_to_string(format!(
        "{}/../doc/clients/{script}",
        env!("CARGO_MANIFEST_DIR")
    ));
    let text = text.unwrap();
    assert!(text.contains("tcpclient(\"127.0.0.1\", 7002)"));
    let text = text.replace("\"127.0.0.1\", 7002", "\"HOST\", PORT");
    client("octave-cli", &["--no-gui", "--eval", &text])
}

/// The numbers of a text.
fn numbers(text: &str) -> Vec<f64> {
    let words = text.split(|it: char| !(it.is_ascii_digit() || it == '.' || it == '-'));
    words.filter_map(|word| word.parse().ok()).collect()
}

#[test]
#[ignore = "needs Octave, Node and nc: run `cargo verify`"]
fn clients_of_the_book_move_the_arm() {
    let printed = [
        octave("matlab.m"),
        client("node", &["client.mjs", "HOST:PORT"]),
    ];
    for text in printed {
        let [first, second] = numbers(&text)[..] else {
            panic!("{text}")
        };
        // The paper's controller leaves some rest error.
        assert!(
            (first - 0.2).abs() < 0.05 && (second + 0.1).abs() < 0.05,
            "{text}"
        );
    }
    let text = client("sh", &["client.sh", "HOST", "PORT"]);
    let answer: Value = serde_json::from_str(&text).unwrap();
    assert_eq!(
        (&answer["ok"], &answer["mode"]),
        (&json!(true), &json!("track"))
    );
}

#[test]
#[ignore = "needs Octave, Node and nc: run `cargo verify`"]
fn the_paper_s_loop_in_octave_is_left_behind_by_the_board_s() {
    let text = octave("paper.m");
    let [hertz, first, second, _, own_first, own_second] = numbers(&text)[..] else {
        panic!("{text}")
    };
    assert!((hertz - 22.0).abs() < 1e-9, "{text}");
    // Dry friction holds the arm where the torque of a PC's loop no longer moves it.
    assert!(
        first.max(second) > 5.0 * own_first.max(own_second),
        "{text}"
    );
    assert!(own_first.max(own_second) < 3.0, "{text}");
}
