//! `armbridge.toml`.

use std::fs;

use super::Program;

#[test]
fn the_file_that_is_written_says_nothing_until_it_is_edited() {
    let program = Program::new();
    assert!(
        program
            .says(&["config"])
            .contains("No armbridge.toml here or above")
    );
    program.says(&["config", "--init"]);
    let path = program.path("armbridge.toml");
    let text = fs::read_to_string(&path).unwrap();
    assert_eq!(text, program.says(&["config", "--explain"]));
    assert!(
        program
            .says(&["config"])
            .contains("sets nothing on the board")
    );
    program.fails(
        &["config", "--init"],
        &["there is an armbridge.toml here already"],
    );

    // As a user edits it.
    let edited = text
        .replace("# link = \"sim:\"", "link = \"tcp://127.0.0.1:1\"")
        .replace("# [limits]", "[limits]")
        .replace("# hold_ms = 100", "hold_ms = 80");
    fs::write(&path, edited).unwrap();
    let table = program.says(&["config"]);
    let line = |key: &str| {
        let line = table.lines().find(|line| line.starts_with(key));
        line.unwrap_or_default()
            .split_whitespace()
            .collect::<Vec<_>>()
            .join(" ")
    };
    assert!(
        line("link").starts_with("link \"tcp://127.0.0.1:1\" "),
        "{table}"
    );
    assert!(
        line("limits.hold_ms").starts_with("limits.hold_ms 80 ms "),
        "{table}"
    );
    assert!(line("out").ends_with(" default"), "{table}");
    // Every command finds it, from further below as well.
    program.fails(&["params"], &["tcp://127.0.0.1:1"]);
    program.says(&["params", "--link", "sim:"]);
    // Its settings for the board are sent by an explicit command.
    let last = table.lines().last().unwrap_or_default();
    assert!(
        last.contains("`armbridge params --from ") && last.contains("armbridge.toml`"),
        "{table}"
    );
    let stdout = program.says(&["params", "--link", "sim:", "--from", "armbridge.toml"]);
    assert!(
        stdout.contains("limits.hold_ms") && stdout.contains("the board has taken it"),
        "{stdout}"
    );
}

#[test]
fn mistakes_have_a_place() {
    let program = Program::new();
    let path = program.path("armbridge.toml");
    for (text, words) in [
        (
            "[limits]\nhold = 3\n",
            "armbridge.toml:2:1: there is no key `limits.hold`",
        ),
        ("link = 3\n", "armbridge.toml:1:8: `link` takes usb:"),
        ("link = \n", "armbridge.toml:1:"),
    ] {
        fs::write(&path, text).unwrap();
        for command in ["config", "params", "design"] {
            program.fails(&[command], &[words]);
        }
    }
}
